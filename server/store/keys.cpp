#include "server/store/keys.h"

#include <fcntl.h>
#include <openssl/crypto.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <sstream>

#include "server/store/file.h"

namespace photond {

namespace {

constexpr char kFirstLine[] = "photond keys 1: id, SHA-256, scope, jobs, bytes, streams, created, label";

std::string limit_text(const std::optional<std::uint64_t>& limit) { return limit ? std::to_string(*limit) : "-"; }

std::optional<std::uint64_t> number(const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::string line_of(const KeyRecord& key) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(key.created.time_since_epoch()).count();
  return key.id + " " + to_hex(key.hash) + " " + scope_name(key.scope) + " " + limit_text(key.limits.jobs) + " " +
         limit_text(key.limits.bytes) + " " + limit_text(key.limits.streams) + " " + std::to_string(seconds) + " " +
         key.label + "\n";
}

std::optional<KeyRecord> parse_line(const std::string& line) {
  std::istringstream in(line);
  std::array<std::string, 7> field;
  for (std::string& text : field) in >> text;
  const auto hash = digest_from_hex(field[1]);
  const auto scope = scope_from_name(field[2]);
  const auto created = number(field[6]);
  const bool limits = std::all_of(field.begin() + 3, field.begin() + 6,
                                  [](const std::string& text) { return text == "-" || number(text); });
  if (!in || !hash || !scope || !created || !limits) return std::nullopt;
  KeyRecord key{field[0], *hash, *scope, {number(field[3]), number(field[4]), number(field[5])}, {}, {}};
  key.created = std::chrono::system_clock::time_point(std::chrono::seconds(*created));
  in.ignore();  // the space
  std::getline(in, key.label);
  return key;
}

}  // namespace

const char* scope_name(Scope scope) {
  return scope == Scope::read ? "read" : scope == Scope::submit ? "submit" : "admin";
}

std::optional<Scope> scope_from_name(const std::string& name) {
  for (const Scope scope : {Scope::read, Scope::submit, Scope::admin}) {
    if (name == scope_name(scope)) return scope;
  }
  return std::nullopt;
}

Result<NewKey> make_key(Scope scope, const KeyLimits& limits, const std::string& label) {
  const bool printable = std::all_of(label.begin(), label.end(), [](unsigned char c) { return c >= ' ' && c != 127; });
  if (!printable || label.size() > 100) return invalid_input("a label is one line of at most 100 bytes");
  Digest random;
  if (::getrandom(random.bytes.data(), random.bytes.size(), 0) != static_cast<ssize_t>(random.bytes.size()))
    return system_error("cannot get random bytes", errno);
  NewKey key;
  key.secret = "photond_" + to_hex(random);
  key.record.hash = sha256(std::as_bytes(std::span(key.secret.data(), key.secret.size())));
  key.record.id = "k-" + to_hex(key.record.hash).substr(0, 8);
  key.record.scope = scope;
  key.record.limits = limits;
  key.record.created = std::chrono::system_clock::now();
  key.record.label = label;
  return key;
}

Result<std::vector<KeyRecord>> KeyFile::read() const {
  const Result<std::vector<std::byte>> bytes = read_whole(path_);
  if (!bytes && bytes.error().code == ErrorCode::not_found) return std::vector<KeyRecord>{};
  if (!bytes) return bytes.error();
  std::istringstream text(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  const Error damaged{ErrorCode::io, path_.string() + " is not a file of keys, or is damaged", ""};
  std::string line;
  std::getline(text, line);
  if (line != kFirstLine) return damaged;
  std::vector<KeyRecord> keys;
  while (std::getline(text, line)) {
    auto key = parse_line(line);
    if (!key) return damaged;
    keys.push_back(std::move(*key));
  }
  return keys;
}

Status KeyFile::write(const std::vector<KeyRecord>& keys) const {
  std::string text = std::string(kFirstLine) + "\n";
  for (const KeyRecord& key : keys) text += line_of(key);
  const std::filesystem::path next = path_.string() + ".next";
  {
    Result<File> file = File::open(next, O_WRONLY | O_CREAT | O_TRUNC);
    if (!file) return file.error();
    if (const Status written = file->write(std::as_bytes(std::span(text.data(), text.size()))); !written) return written;
    if (const Status synced = file->sync(); !synced) return synced;
  }
  std::error_code failed;
  std::filesystem::rename(next, path_, failed);
  if (failed) return system_error("cannot replace " + path_.string(), failed.value());
  return sync_folder(path_.parent_path());
}

template <class Change>
Status KeyFile::change(const Change& change) const {
  if (const Status made = make_folder(path_.parent_path()); !made) return made;
  Result<File> lock = File::open(path_.string() + ".lock", O_RDWR | O_CREAT);
  if (!lock) return lock.error();
  if (::flock(lock->descriptor(), LOCK_EX) != 0) return system_error("cannot lock " + path_.string(), errno);
  Result<std::vector<KeyRecord>> keys = read();
  if (!keys) return keys.error();
  if (const Status changed = change(*keys); !changed) return changed;
  return write(*keys);
}

Status KeyFile::add(const KeyRecord& key, const std::function<Status()>& hand_over) const {
  return change([&](std::vector<KeyRecord>& keys) {
    keys.push_back(key);
    return hand_over();
  });
}

Status KeyFile::revoke(const std::string& id) const {
  return change([&id](std::vector<KeyRecord>& keys) -> Status {
    const auto removed = std::erase_if(keys, [&id](const KeyRecord& key) { return key.id == id; });
    if (removed == 0) return Error{ErrorCode::not_found, "there is no key " + id, ""};
    return Done{};
  });
}

Status Keyring::refresh() const {
  struct stat now {};
  if (::stat(file_->path().c_str(), &now) != 0) now = {};  // as a file without keys
  // Every change makes a new file.
  const Version version{now.st_ino, static_cast<std::uint64_t>(now.st_mtim.tv_sec),
                        static_cast<std::uint64_t>(now.st_mtim.tv_nsec), static_cast<std::uint64_t>(now.st_size)};
  if (version == version_) return Done{};
  keys_.clear();
  version_ = {};
  Result<std::vector<KeyRecord>> keys = file_->read();
  if (!keys) return keys.error();
  keys_ = std::move(*keys);
  version_ = version;
  return Done{};
}

bool Keyring::required() const {
  if (!file_) return false;
  const std::lock_guard lock(mutex_);
  return required_ = required_ || file_->exists();
}

Result<std::optional<KeyRecord>> Keyring::find(const std::string& secret) const {
  const Digest hash = sha256(std::as_bytes(std::span(secret.data(), secret.size())));
  const std::lock_guard lock(mutex_);
  if (const Status read = refresh(); !read) return read.error();
  std::optional<KeyRecord> found;
  for (const KeyRecord& key : keys_) {
    if (CRYPTO_memcmp(key.hash.bytes.data(), hash.bytes.data(), hash.bytes.size()) == 0) found = key;
  }
  return found;
}

}  // namespace photond
