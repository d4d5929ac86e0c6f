#include "server/jobs/scene_archive.h"

#include <zip.h>

#include <algorithm>
#include <optional>

namespace photond {

namespace {

using ZipHandle = std::unique_ptr<zip_t, decltype(&zip_discard)>;
using FileHandle = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

constexpr std::uint64_t kSmallEntry = 1 << 20;  // below it a high ratio is harmless

bool ends_with(const std::string& text, const std::string& end) {
  if (text.size() < end.size()) return false;
  return std::equal(end.rbegin(), end.rend(), text.rbegin(),
                    [](char a, char b) { return a == std::tolower(static_cast<unsigned char>(b)); });
}

bool leaves_archive(const std::string& name) {
  if (name.empty() || name.front() == '/' || name.find('\\') != std::string::npos) return true;
  return ("/" + name + "/").find("/../") != std::string::npos || name.find('\0') != std::string::npos;
}

Result<ZipHandle> open_archive(std::span<const std::byte> bytes) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* archive = source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
  if (archive == nullptr && source != nullptr) zip_source_free(source);
  const std::string reason = zip_error_strerror(&error);
  zip_error_fini(&error);
  if (archive == nullptr) return invalid_input("not a readable zip archive: " + reason);
  return ZipHandle(archive, &zip_discard);
}

Error too_large(const std::string& what, std::uint64_t max_bytes, const std::string& where) {
  return {ErrorCode::limit_exceeded, what + " more than " + std::to_string(max_bytes) + " bytes", where};
}

Status check_entry(const zip_stat_t& entry, std::uint64_t total, const ArchiveLimits& limits) {
  constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
  if ((entry.valid & kNeeded) != kNeeded) return invalid_input("a zip entry without name or size");
  const std::string name = entry.name;
  if (leaves_archive(name)) return invalid_input("a zip entry's name leaves the archive", name);
  if ((entry.valid & ZIP_STAT_ENCRYPTION_METHOD) && entry.encryption_method != ZIP_EM_NONE) {
    return Error{ErrorCode::unsupported, "encrypted zip entries are not supported", name};
  }
  if (entry.size > limits.max_bytes || total + entry.size > limits.max_bytes) {
    return too_large("the archive unpacks to", limits.max_bytes, name);
  }
  const std::uint64_t packed = std::max<std::uint64_t>(entry.comp_size, 1);
  if (entry.size > kSmallEntry && entry.size / packed > limits.max_ratio) {
    return Error{ErrorCode::limit_exceeded,
                 "a zip entry is compressed more than " + std::to_string(limits.max_ratio) + ":1", name};
  }
  return Done{};
}

Result<std::vector<std::byte>> unpack(zip_t* archive, const zip_stat_t& entry) {
  const FileHandle file(zip_fopen_index(archive, entry.index, 0), &zip_fclose);
  if (!file) return invalid_input(std::string("cannot unpack: ") + zip_strerror(archive), entry.name);
  std::vector<std::byte> bytes(entry.size);
  std::uint64_t done = 0;
  while (done < entry.size) {
    const zip_int64_t got = zip_fread(file.get(), bytes.data() + done, entry.size - done);
    if (got <= 0) return invalid_input("a zip entry is damaged or shorter than stated", entry.name);
    done += static_cast<std::uint64_t>(got);
  }
  std::byte beyond;
  if (zip_fread(file.get(), &beyond, 1) > 0)
    return invalid_input("a zip entry is longer than stated", entry.name);
  return bytes;
}

/// What macOS packs beside the files: "__MACOSX/model/._scene.gltf" holds attributes of "model/scene.gltf".
bool is_companion(const std::string& name) { return name.starts_with("__MACOSX/"); }

Status choose_root(SceneArchive& archive) {
  for (const auto& [name, bytes] : archive.files) {
    if (!ends_with(name, ".gltf") && !ends_with(name, ".glb")) continue;
    if (!archive.root.empty()) {
      return invalid_input("the archive holds several glTF files: " + archive.root + " and " + name);
    }
    archive.root = name;
  }
  if (archive.root.empty()) return invalid_input("the archive holds no .gltf or .glb file");
  return Done{};
}

}  // namespace

ResourceReader SceneArchive::reader() const {
  const std::size_t slash = root.rfind('/');
  const std::string folder = slash == std::string::npos ? "" : root.substr(0, slash + 1);
  const auto left = std::make_shared<std::uint64_t>(max_bytes);  // shared by copies of the reader
  return [this, folder, left](const std::string& path) -> Result<std::vector<std::byte>> {
    const auto found = files.find(folder + path);
    if (found == files.end())
      return Error{ErrorCode::not_found, "the archive holds no file " + folder + path, path};
    const std::vector<std::byte>& bytes = found->second;
    if (bytes.size() > *left)
      return too_large("the files of the scene, each as often as it is named, have", max_bytes, path);
    *left -= bytes.size();
    return bytes;
  };
}

Result<SceneArchive> read_archive(std::span<const std::byte> zip, const ArchiveLimits& limits) {
  const Result<ZipHandle> handle = open_archive(zip);
  if (!handle) return handle.error();
  zip_t* archive = handle->get();
  const zip_int64_t count = zip_get_num_entries(archive, 0);
  if (count < 0 || static_cast<std::uint64_t>(count) > limits.max_entries) {
    return Error{ErrorCode::limit_exceeded,
                 "the archive holds more than " + std::to_string(limits.max_entries) + " entries", ""};
  }
  SceneArchive result{.max_bytes = limits.max_bytes};
  std::uint64_t total = 0;
  for (zip_int64_t i = 0; i < count; ++i) {
    zip_stat_t entry;
    zip_stat_init(&entry);
    if (zip_stat_index(archive, static_cast<zip_uint64_t>(i), 0, &entry) != 0)
      return invalid_input("damaged zip");
    if (const Status fine = check_entry(entry, total, limits); !fine) return fine.error();
    const std::string name = entry.name;
    if (name.back() == '/' || is_companion(name)) continue;
    Result<std::vector<std::byte>> bytes = unpack(archive, entry);
    if (!bytes) return bytes.error();
    total += bytes->size();
    result.files.insert_or_assign(name, std::move(*bytes));
  }
  if (const Status chosen = choose_root(result); !chosen) return chosen.error();
  return result;
}

}  // namespace photond
