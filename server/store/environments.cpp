#include "server/store/environments.h"

#include <algorithm>
#include <sstream>

#include "server/store/uploads.h"

namespace photond {

namespace {

constexpr const char* kColumns =
    "SELECT id, media_type, bytes, width, height, warnings, created_ms, owner, name FROM environments";

std::int64_t milliseconds(WallTime time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time.time_since_epoch()).count();
}

// One warning a line.
std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::vector<std::string> divided(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

Result<EnvironmentRecord> read_row(const Query& row) {
  EnvironmentRecord record;
  const std::vector<std::byte> id = row.bytes(0);
  if (id.size() != sizeof record.id.bytes) return Error{ErrorCode::io, "an environment has no id", ""};
  std::copy(id.begin(), id.end(), reinterpret_cast<std::byte*>(record.id.bytes.data()));
  record.media_type = row.text(1);
  record.bytes = row.whole(2);
  record.width = static_cast<int>(row.integer(3));
  record.height = static_cast<int>(row.integer(4));
  record.warnings = divided(row.text(5));
  record.created = WallTime(std::chrono::milliseconds(row.integer(6)));
  record.owner = row.text(7);
  record.name = row.text(8);
  return record;
}

Result<std::vector<EnvironmentRecord>> read_rows(Query query) {
  std::vector<EnvironmentRecord> records;
  while (query.next()) {
    Result<EnvironmentRecord> record = read_row(query);
    if (!record) return record.error();
    records.push_back(std::move(*record));
  }
  if (const Status read = query.status(); !read) return read.error();
  return records;
}

std::span<const std::byte> key(const Digest& id) { return std::as_bytes(std::span(id.bytes)); }

}  // namespace

Result<std::unique_ptr<Environments>> Environments::open(Database& database, const std::filesystem::path& folder) {
  Result<std::unique_ptr<Blobs>> files = Blobs::open(folder);
  if (!files) return files.error();
  std::unique_ptr<Environments> environments(new Environments(database, std::move(*files)));
  const auto known = environments->list();
  if (!known) return known.error();
  const auto swept = environments->files_->sweep([&](const Digest& id) {
    return std::any_of(known->begin(), known->end(), [&](const EnvironmentRecord& r) { return r.id == id; });
  });
  if (!swept) return swept.error();
  return environments;
}

Status Environments::put(const EnvironmentRecord& r, const std::vector<std::byte>& bytes,
                         const std::optional<std::uint64_t>& owner_bytes) {
  const std::lock_guard lock(changing_);
  const auto known = find(r.id);
  if (!known) return known.error();
  if (*known) return Done{};
  if (const auto stored = files_->put(bytes); !stored) return stored.error();
  const Status written = database_.write([&](Transaction& transaction) {
    if (const Status fits = check_uploads(transaction, r.owner, r.bytes, owner_bytes); !fits) return fits;
    return transaction.run(
        "INSERT INTO environments (id, arrival, media_type, bytes, width, height, warnings, created_ms, owner, "
        "name) SELECT ?, coalesce(max(arrival), 0) + 1, ?, ?, ?, ?, ?, ?, ?, ? FROM environments",
        key(r.id), r.media_type, r.bytes, r.width, r.height, joined(r.warnings), milliseconds(r.created), r.owner,
        r.name);
  });
  if (!written) (void)files_->remove(r.id).ok();  // else the next start sweeps it
  return written;
}

Result<std::optional<EnvironmentRecord>> Environments::find(const Digest& id) const {
  std::optional<EnvironmentRecord> found;
  const Status read = database_.read([&](Transaction& transaction) -> Status {
    auto records = read_rows(transaction.query(std::string(kColumns) + " WHERE id = ?", key(id)));
    if (!records) return records.error();
    if (!records->empty()) found = std::move(records->front());
    return Done{};
  });
  if (!read) return read.error();
  return found;
}

Result<std::vector<EnvironmentRecord>> Environments::list() const {
  std::vector<EnvironmentRecord> all;
  const Status read = database_.read([&](Transaction& transaction) -> Status {
    auto records = read_rows(transaction.query(std::string(kColumns) + " ORDER BY arrival"));
    if (!records) return records.error();
    all = std::move(*records);
    return Done{};
  });
  if (!read) return read.error();
  return all;
}

Result<Blob> Environments::bytes(const Digest& id) {
  Result<Blob> bytes = files_->get(id);
  if (bytes || bytes.error().code != ErrorCode::not_found) return bytes;
  if (const Status removed = remove(id); !removed) return removed.error();
  return Error{ErrorCode::not_found, "there is no environment " + to_hex(id), ""};
}

Status Environments::name(const Digest& id, const std::string& name) {
  return database_.write([&](Transaction& transaction) {
    return transaction.run("UPDATE environments SET name = ? WHERE id = ? AND name = ''", name, key(id));
  });
}

Status Environments::remove(const Digest& id) {
  const std::lock_guard lock(changing_);
  const Status written = database_.write(
      [&](Transaction& transaction) { return transaction.run("DELETE FROM environments WHERE id = ?", key(id)); });
  if (!written) return written;
  return files_->remove(id);
}

}  // namespace photond
