#include "server/http/static_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>

namespace photond {

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMaxBytes = 64 << 20;

std::string content_type_of(const fs::path& path) {
  static const std::map<std::string, std::string> kTypes{{".html", "text/html; charset=utf-8"},
                                                         {".js", "text/javascript; charset=utf-8"},
                                                         {".css", "text/css; charset=utf-8"},
                                                         {".json", "application/json"},
                                                         {".svg", "image/svg+xml"},
                                                         {".png", "image/png"},
                                                         {".jpg", "image/jpeg"},
                                                         {".ico", "image/x-icon"},
                                                         {".woff2", "font/woff2"},
                                                         {".wasm", "application/wasm"},
                                                         {".map", "application/json"},
                                                         {".webmanifest", "application/manifest+json"},
                                                         {".txt", "text/plain; charset=utf-8"}};
  const auto found = kTypes.find(path.extension().string());
  return found == kTypes.end() ? "application/octet-stream" : found->second;
}

/// The bundler writes a hash of the content into the names of everything below /assets/.
std::string cache_rule_of(const std::string& path) {
  if (path.starts_with("/assets/")) return "public, max-age=31536000, immutable";
  return path.ends_with(".html") ? "no-store" : "no-cache";
}

}  // namespace

Result<StaticFiles> StaticFiles::load(const std::string& folder) {
  StaticFiles result;
  std::uintmax_t total = 0;
  std::error_code failed;
  for (const auto& entry : fs::recursive_directory_iterator(folder, failed)) {
    if (entry.is_symlink(failed) || !entry.is_regular_file(failed)) continue;
    total += entry.file_size(failed);
    if (total > kMaxBytes)
      return Error{ErrorCode::limit_exceeded, folder + " is too large for a web client", ""};
    std::ifstream file(entry.path(), std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file) return Error{ErrorCode::io, "cannot read " + entry.path().string(), ""};
    std::string path("/");
    path += entry.path().lexically_relative(folder).generic_string();
    Response response;
    response.content_type = content_type_of(entry.path());
    response.headers.emplace_back("Cache-Control", cache_rule_of(path));
    const auto* begin = reinterpret_cast<const std::byte*>(bytes.data());
    response.body = std::make_shared<const std::vector<std::byte>>(begin, begin + bytes.size());
    result.files_.emplace(path, std::move(response));
  }
  if (failed)
    return Error{ErrorCode::io, "cannot read the web client's folder " + folder + ": " + failed.message(), ""};
  return result;
}

const Response* StaticFiles::find(const std::string& path) const {
  const auto found = files_.find(path == "/" ? "/index.html" : path == "/docs" ? "/docs.html" : path);
  return found == files_.end() ? nullptr : &found->second;
}

}  // namespace photond
