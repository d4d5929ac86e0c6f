#include "core/film/film_bytes.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <type_traits>

namespace photond {
namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");
static_assert(sizeof(Film::Sums::value_type) == 48 && sizeof(Film::SquareSums::value_type) == 72, "no padding");

constexpr std::uint32_t kMaxSide = 16'384;

/// Hands everything on; after a failure nothing more.
class Writer {
 public:
  explicit Writer(const ByteSink& sink) : sink_(sink) {}

  template <class T>
  void number(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    raw(&value, sizeof value);
  }
  template <class T>
  void array(const ZeroedArray<T>& values) {
    raw(values.data(), values.size() * sizeof(T));
  }
  const Status& status() const { return status_; }

 private:
  void raw(const void* data, std::size_t size) {
    std::span<const std::byte> left(static_cast<const std::byte*>(data), size);
    while (!left.empty() && status_) {
      const auto piece = left.first(std::min(left.size(), kPiece));
      status_ = sink_(piece);
      left = left.subspan(piece.size());
    }
  }
  // What hashes and writes it finds it in the processor's cache, and may end the writing soon.
  static constexpr std::size_t kPiece = 1 << 18;

  const ByteSink& sink_;
  Status status_ = Done{};
};

/// Reads in order; what lies beyond the end reads as nothing and makes `ok` false.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <class T>
  T number() {
    T value{};
    if (has(1, sizeof value)) copy(&value, sizeof value);
    return value;
  }
  template <class T>
  void array(ZeroedArray<T>& values, std::size_t count) {
    if (!has(count, sizeof(T))) return;
    values = ZeroedArray<T>(count);
    copy(values.data(), count * sizeof(T));
  }
  bool ok() const { return ok_; }
  bool at_end() const { return ok_ && bytes_.empty(); }

 private:
  bool has(std::size_t count, std::size_t size) { return ok_ = ok_ && count <= bytes_.size() / size; }
  void copy(void* to, std::size_t size) {
    if (size > 0) std::memcpy(to, bytes_.data(), size);
    bytes_ = bytes_.subspan(size);
  }

  std::span<const std::byte> bytes_;
  bool ok_ = true;
};

Status read_ranges(Reader& reader, Film& film) {
  const auto count = reader.number<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const auto first = reader.number<std::uint32_t>();
    const auto last = reader.number<std::uint32_t>();
    if (reader.ok() && (first >= last || (i > 0 && first <= film.passes.back().last))) {
      return invalid_input("the ranges of passes are not in order");
    }
    film.passes.push_back({first, last});
  }
  return Done{};
}

/// Sets the number of complete blocks and the list of the others, without their sums, by the ranges of passes.
void find_blocks(Film& film) {
  for (const PassRange& range : film.passes) {
    const std::uint32_t first = range.first / kBlockPasses, last = (range.last - 1) / kBlockPasses;
    for (const std::uint32_t index : {first, last}) {
      if (!film.open.empty() && film.open.back().index == index) continue;
      std::uint16_t passes = 0;
      for (std::uint32_t i = 0; i < kBlockPasses; ++i) {
        // A block cannot begin beyond the last pass, but may end there.
        const std::uint64_t pass = std::uint64_t{index} * kBlockPasses + i;
        if (pass <= UINT32_MAX && film.contains(static_cast<std::uint32_t>(pass))) passes |= 1u << i;
      }
      if (passes != 0xffff) film.open.push_back({index, passes, {}});
    }
  }
  std::uint32_t passes_in_open = 0;
  for (const Film::OpenBlock& block : film.open) passes_in_open += std::popcount(block.passes);
  film.blocks = (film.pass_count() - passes_in_open) / kBlockPasses;
}

void read_sums(Reader& reader, Film& film, std::size_t pixels, bool banded) {
  reader.array(film.complete, pixels);
  if (film.blocks > 0) reader.array(film.block_squares, pixels);
  if (film.blocks < kBlocksForEstimate) reader.array(film.pass_squares, pixels);
  for (Film::OpenBlock& block : film.open) reader.array(block.sum, pixels);
  reader.array(film.largest, pixels);
  if (banded) reader.array(film.bands, pixels);
}

}  // namespace

Status write_film(const Film& film, const ByteSink& sink) {
  Writer writer(sink);
  writer.number(static_cast<std::uint32_t>(film.width));
  writer.number(static_cast<std::uint32_t>(film.height));
  writer.number(static_cast<std::uint32_t>(film.passes.size()));
  for (const PassRange& range : film.passes) {
    writer.number(range.first);
    writer.number(range.last);
  }
  writer.number(film.rejected);
  writer.number(film.truncated);
  writer.number(static_cast<std::uint8_t>(film.bands.empty() ? 0 : 1));
  writer.array(film.complete);
  writer.array(film.block_squares);
  writer.array(film.pass_squares);
  for (const Film::OpenBlock& block : film.open) writer.array(block.sum);
  writer.array(film.largest);
  writer.array(film.bands);
  return writer.status();
}

std::uint64_t film_size(const Film& film) {
  std::uint64_t size = 0;
  [[maybe_unused]] const Status counted = write_film(film, [&size](std::span<const std::byte> piece) -> Status {
    size += piece.size();
    return Done{};
  });
  assert(counted.ok());
  return size;
}

std::vector<std::byte> film_bytes(const Film& film) {
  std::vector<std::byte> bytes;
  bytes.reserve(film_size(film));
  [[maybe_unused]] const Status written = write_film(film, [&bytes](std::span<const std::byte> piece) -> Status {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
    return Done{};
  });
  assert(written.ok());
  return bytes;
}

Result<Film> read_film(std::span<const std::byte> bytes) {
  Reader reader(bytes);
  Film film;
  const auto width = reader.number<std::uint32_t>(), height = reader.number<std::uint32_t>();
  if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide) {
    return invalid_input("the film has a size that is not allowed");
  }
  film.width = static_cast<int>(width);
  film.height = static_cast<int>(height);
  if (const Status ranges = read_ranges(reader, film); !ranges) return ranges.error();
  film.rejected = reader.number<std::uint64_t>();
  film.truncated = reader.number<std::uint64_t>();
  const auto banded = reader.number<std::uint8_t>();
  if (!reader.ok() || banded > 1) return invalid_input("the film is cut short");
  find_blocks(film);
  read_sums(reader, film, std::size_t{width} * height, banded == 1);
  if (!reader.at_end()) return invalid_input("the film has another length than its passes need");
  for (float value : film.largest) {
    if (!(value >= 0) || std::isinf(value)) return invalid_input("the film holds a value that no pass can have");
  }
  return film;
}

}  // namespace photond
