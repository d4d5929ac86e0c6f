#include "core/scene/gltf/draco_mesh.h"

#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <stdexcept>
#include <type_traits>
#include <vector>

#include "core/scene/gltf/decompress.h"

namespace photond::gltf {
namespace {

constexpr std::uint8_t kMajor = 2, kMinor = 2;
constexpr std::uint32_t kMostAttributes = 256;

/// The decoder of one of Draco's two methods, stopped where the stream says that it would take too much. What it reads
/// ahead has the order of the bitstream's specification.
template <class Decoder>
class BoundedDecoder final : public Decoder {
 public:
  explicit BoundedDecoder(std::uint64_t max_bytes) : max_bytes_(max_bytes) {}

  bool exceeded() const { return exceeded_; }

 private:
  static constexpr bool kEdgebreaker = std::is_same_v<Decoder, draco::MeshEdgebreakerDecoder>;

  bool DecodeConnectivity() override { return connectivity_fits(*this->buffer()) && Decoder::DecodeConnectivity(); }
  bool DecodePointAttributes() override {
    return attributes_are_few(*this->buffer()) && Decoder::DecodePointAttributes();
  }
  bool DecodeAllAttributes() override { return attributes_fit() && Decoder::DecodeAllAttributes(); }

  bool take(std::uint64_t bytes) {
    bytes_ += bytes;
    exceeded_ = bytes_ > max_bytes_;
    return !exceeded_;
  }

  /// About what the decoders allocate for faces and vertices, and for each set of seams between attributes along them.
  bool connectivity_fits(draco::DecoderBuffer ahead) {
    std::uint32_t faces = 0, vertices = 0;
    if (!kEdgebreaker) return draco::DecodeVarint(&faces, &ahead) && take(std::uint64_t{24} * faces);
    std::uint8_t seams = 0;
    return draco::DecodeVarint(&vertices, &ahead) && draco::DecodeVarint(&faces, &ahead) && ahead.Decode(&seams) &&
           take(faces * (std::uint64_t{48} + 16 * seams) + vertices * (std::uint64_t{32} + 8 * seams));
  }

  bool attributes_are_few(draco::DecoderBuffer ahead) {
    std::uint8_t groups = 0;
    if (!ahead.Decode(&groups)) return false;
    if (kEdgebreaker) ahead.Advance(3 * groups);
    std::uint64_t attributes = 0;
    for (int group = 0; group < groups; ++group) {
      std::uint32_t count = 0, id = 0;
      if (!draco::DecodeVarint(&count, &ahead)) return false;
      attributes += count;
      if (attributes > kMostAttributes) return false;
      for (std::uint32_t i = 0; i < count; ++i) {
        ahead.Advance(4);
        if (!draco::DecodeVarint(&id, &ahead)) return false;
      }
      ahead.Advance(count);
    }
    return true;
  }

  /// Each value is there as it is coded, 32 bits a component, and as it is asked for.
  bool attributes_fit() {
    const draco::PointCloud& cloud = *this->point_cloud();
    std::uint64_t bytes_per_point = 0;
    for (int i = 0; i < cloud.num_attributes(); ++i) {
      const draco::PointAttribute& attribute = *cloud.attribute(i);
      bytes_per_point += 8 + 4 * attribute.num_components() + static_cast<std::uint64_t>(attribute.byte_stride());
    }
    return take(cloud.num_points() * bytes_per_point);
  }

  std::uint64_t max_bytes_;
  std::uint64_t bytes_ = 0;
  bool exceeded_ = false;
};

bool skip(draco::DecoderBuffer& buffer, std::int64_t bytes) {
  if (bytes > buffer.remaining_size()) return false;
  buffer.Advance(bytes);
  return true;
}

bool skip_name(draco::DecoderBuffer& buffer) {
  std::uint8_t length = 0;
  return buffer.Decode(&length) && skip(buffer, length);
}

/// Names and values, and the same again inside.
bool skip_metadata_tree(draco::DecoderBuffer& buffer) {
  std::uint64_t pending = 1;
  for (bool first = true; pending > 0; first = false, --pending) {
    std::uint32_t entries = 0, inside = 0, size = 0;
    if (!first && !skip_name(buffer)) return false;
    if (!draco::DecodeVarint(&entries, &buffer)) return false;
    for (std::uint32_t i = 0; i < entries; ++i) {
      if (!skip_name(buffer) || !draco::DecodeVarint(&size, &buffer) || !skip(buffer, size)) return false;
    }
    if (!draco::DecodeVarint(&inside, &buffer)) return false;
    pending += inside;
  }
  return true;
}

/// That of each attribute, which is named by its id, and that of the mesh.
bool skip_metadata(draco::DecoderBuffer& buffer) {
  std::uint32_t attributes = 0, id = 0;
  if (!draco::DecodeVarint(&attributes, &buffer)) return false;
  for (std::uint32_t i = 0; i < attributes; ++i) {
    if (!draco::DecodeVarint(&id, &buffer) || !skip_metadata_tree(buffer)) return false;
  }
  return skip_metadata_tree(buffer);
}

template <class Decoder>
Result<std::unique_ptr<draco::Mesh>> decode(const std::vector<char>& stream, std::uint64_t max_bytes,
                                            const std::string& where) {
  BoundedDecoder<Decoder> decoder(max_bytes);
  draco::DecoderBuffer buffer;
  buffer.Init(stream.data(), stream.size());
  auto mesh = std::make_unique<draco::Mesh>();
  bool decoded = false;
  try {
    decoded = decoder.Decode(draco::DecoderOptions(), &buffer, mesh.get()).ok();
  } catch (const std::length_error&) {
    // A vector of a size that no data can have: as wrong as what the decoder itself finds.
  }
  if (decoder.exceeded()) return too_much_compressed_data(where);
  if (!decoded) return invalid_input("data cannot be decompressed", where);
  return mesh;
}

}  // namespace

Result<std::unique_ptr<draco::Mesh>> decode_draco_mesh(std::span<const unsigned char> data, std::uint64_t max_bytes,
                                                       const std::string& where) {
  std::vector<char> stream(data.begin(), data.end());
  draco::DecoderBuffer buffer;
  buffer.Init(stream.data(), stream.size());
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok() || header.encoder_type != draco::TRIANGULAR_MESH) {
    return invalid_input("data is not a mesh compressed by Draco", where);
  }
  if (header.version_major != kMajor || header.version_minor != kMinor) {
    return Error{ErrorCode::unsupported, "data is not in version 2.2 of Draco's bitstream", where};
  }
  if ((header.flags & METADATA_FLAG_MASK) != 0) {
    // Nothing needs it, and Draco reads it into any amount of memory.
    const std::int64_t begin = buffer.decoded_size();
    if (!skip_metadata(buffer)) return invalid_input("data cannot be decompressed", where);
    stream.erase(stream.begin() + begin, stream.begin() + buffer.decoded_size());
    stream[begin - 1] = 0;  // the flag
  }
  switch (header.encoder_method) {
    case draco::MESH_SEQUENTIAL_ENCODING:
      return decode<draco::MeshSequentialDecoder>(stream, max_bytes, where);
    case draco::MESH_EDGEBREAKER_ENCODING:
      return decode<draco::MeshEdgebreakerDecoder>(stream, max_bytes, where);
    default:
      return Error{ErrorCode::unsupported, "the method of Draco is not supported", where};
  }
}

}  // namespace photond::gltf
