#include "server/store/job_files.h"

#include <algorithm>
#include <map>
#include <set>

namespace photond {

namespace {

std::span<const std::byte> name_of(const Digest& blob) { return std::as_bytes(std::span(blob.bytes)); }

Digest digest_of(const std::vector<std::byte>& bytes) {
  Digest digest;
  std::copy_n(bytes.begin(), std::min(bytes.size(), digest.bytes.size()),
              reinterpret_cast<std::byte*>(digest.bytes.data()));
  return digest;
}

}  // namespace

Result<std::unique_ptr<JobFiles>> JobFiles::open(Database& database, const std::filesystem::path& frames,
                                                 const std::filesystem::path& checkpoints) {
  auto frame_files = Blobs::open(frames);
  if (!frame_files) return frame_files.error();
  auto checkpoint_files = Blobs::open(checkpoints);
  if (!checkpoint_files) return checkpoint_files.error();
  std::unique_ptr<JobFiles> files(new JobFiles(database, std::move(*frame_files), std::move(*checkpoint_files)));
  if (const Status swept = files->sweep(*files->frame_files_, "frames"); !swept) return swept.error();
  if (const Status swept = files->sweep(*files->checkpoint_files_, "checkpoints"); !swept) return swept.error();
  return files;
}

Status JobFiles::sweep(Blobs& files, const char* table) {
  std::set<Digest> wanted;
  const Status read = database_.read([&](Transaction& transaction) {
    Query query = transaction.query(std::string("SELECT blob FROM ") + table);
    while (query.next()) wanted.insert(digest_of(query.bytes(0)));
    return query.status();
  });
  if (!read) return read;
  const auto swept = files.sweep([&](const Digest& blob) { return wanted.contains(blob); });
  return swept ? Status(Done{}) : swept.error();
}

Status JobFiles::put_frame(const std::string& job, std::uint32_t revision, FrameFormat format,
                           std::span<const std::byte> bytes) {
  const auto written = frame_files_->write([bytes](const Blobs::Sink& sink) { return sink(bytes); });
  if (!written) return written.error();
  const std::lock_guard lock(changing_);
  return publish(*frame_files_, "frames", *written, [&](Transaction& transaction) {
    return transaction.run("INSERT OR IGNORE INTO frames VALUES (?, ?, ?, ?, ?)", job, revision, format,
                           name_of(written->name()), bytes.size());
  });
}

/// With its row, or not at all. To be called with `changing_` held.
Status JobFiles::publish(Blobs& files, const char* table, const Blobs::Written& written, const Database::Body& row) {
  if (const Status published = files.publish(written); !published) return published;
  const Status added = database_.write(row);
  if (!added) remove_unnamed(files, table, written.name());
  return added;
}

Result<Blob> JobFiles::frame(const std::string& job, std::uint32_t revision, FrameFormat format) {
  const Result<Digest> blob = find_frame(job, revision, format);
  return blob ? frame_files_->get(*blob) : blob.error();
}

Result<FileBytes> JobFiles::open_frame(const std::string& job, std::uint32_t revision, FrameFormat format) {
  const Result<Digest> blob = find_frame(job, revision, format);
  return blob ? frame_files_->open_file(*blob) : blob.error();
}

Result<Digest> JobFiles::find_frame(const std::string& job, std::uint32_t revision, FrameFormat format) {
  std::optional<Digest> blob;
  const Status read = database_.read([&](Transaction& transaction) {
    Query query = transaction.query("SELECT blob FROM frames WHERE job = ? AND revision = ? AND format = ?", job,
                                    revision, format);
    if (query.next()) blob = digest_of(query.bytes(0));
    return query.status();
  });
  if (!read) return read.error();
  if (blob) return *blob;
  return Error{ErrorCode::not_found, "revision " + std::to_string(revision) + " is not kept; ask for latest", ""};
}

Status JobFiles::put_checkpoint(const std::string& job, std::uint32_t passes, double seconds,
                                const Blobs::Content& content) {
  std::uint64_t bytes = 0;
  const auto written = checkpoint_files_->write([&](const Blobs::Sink& sink) {
    return content([&](std::span<const std::byte> piece) {
      bytes += piece.size();
      return sink(piece);
    });
  });
  if (!written) return written.error();
  const std::lock_guard lock(changing_);
  const Status put = publish(*checkpoint_files_, "checkpoints", *written, [&](Transaction& transaction) {
    return transaction.run("INSERT OR REPLACE INTO checkpoints VALUES (?, ?, ?, ?, ?)", job, passes,
                           name_of(written->name()), bytes, seconds);
  });
  return put ? drop(*checkpoint_files_, "checkpoints", job, 2) : put;
}

Result<std::vector<JobFiles::Checkpoint>> JobFiles::checkpoints(const std::string& job) {
  std::vector<Checkpoint> found;
  const Status read = database_.read([&](Transaction& transaction) {
    Query query = transaction.query(
        "SELECT passes, seconds, blob, bytes FROM checkpoints WHERE job = ? ORDER BY passes DESC", job);
    while (query.next()) {
      found.push_back({static_cast<std::uint32_t>(query.whole(0)), query.real(1), digest_of(query.bytes(2)),
                       query.whole(3)});
    }
    return query.status();
  });
  if (!read) return read.error();
  return found;
}

Status JobFiles::drop_checkpoints(const std::string& job, std::size_t keep) {
  const std::lock_guard lock(changing_);
  return drop(*checkpoint_files_, "checkpoints", job, keep);
}

Status JobFiles::drop_older_checkpoints(const std::string& job) {
  const auto all = checkpoints(job);
  if (!all) return all.error();
  auto older = std::find_if(all->begin(), all->end(), [this](const Checkpoint& newest) { return open(newest).ok(); });
  while (older != all->end() && ++older != all->end()) {
    if (const Status dropped = drop_checkpoint(job, *older); !dropped) return dropped;
  }
  return Done{};
}

Status JobFiles::drop_checkpoint(const std::string& job, const Checkpoint& checkpoint) {
  const std::lock_guard lock(changing_);
  return remove_rows(*checkpoint_files_, "checkpoints", job, {checkpoint.blob});
}

Status JobFiles::drop_frames(const std::string& job) {
  const std::lock_guard lock(changing_);
  return drop(*frame_files_, "frames", job, 0);
}

Result<std::uint64_t> JobFiles::spare_bytes(const std::set<std::string>& jobs) {
  const Result<std::uint64_t> frames = bytes_without("SELECT job, blob, bytes, 1 FROM frames", jobs);
  if (!frames) return frames;
  const Result<std::uint64_t> checkpoints = bytes_without(
      "SELECT job, blob, bytes, passes = max(passes) OVER (PARTITION BY job) FROM checkpoints", jobs);
  return checkpoints ? *frames + *checkpoints : checkpoints;
}

/// Of `rows` (job, blob, bytes, whether these jobs keep it). A blob that several jobs name, as those of equal jobs,
/// counts once, and stays with the last of them.
Result<std::uint64_t> JobFiles::bytes_without(const std::string& rows, const std::set<std::string>& jobs) {
  std::map<Digest, std::uint64_t> blobs;
  std::set<Digest> staying;
  const Status read = database_.read([&](Transaction& transaction) {
    Query query = transaction.query(rows);
    while (query.next()) {
      const Digest blob = digest_of(query.bytes(1));
      blobs[blob] = query.whole(2);
      if (query.whole(3) != 0 && jobs.contains(query.text(0))) staying.insert(blob);
    }
    return query.status();
  });
  if (!read) return read.error();
  std::uint64_t bytes = 0;
  for (const auto& [blob, size] : blobs) bytes += staying.contains(blob) ? 0 : size;
  return bytes;
}

/// After a row could not be written (the job is gone, the disk full). What fails here too is swept at the next start.
void JobFiles::remove_unnamed(Blobs& files, const char* table, const Digest& blob) {
  bool named = true;
  const Status read = database_.read([&](Transaction& transaction) {
    Query query = transaction.query(std::string("SELECT 1 FROM ") + table + " WHERE blob = ? LIMIT 1", name_of(blob));
    named = query.next();
    return query.status();
  });
  if (read && !named) (void)files.remove(blob).ok();
}

/// Removes the rows of a job but for the `keep` with the most passes.
Status JobFiles::drop(Blobs& files, const char* table, const std::string& job, std::size_t keep) {
  const std::string name = table;
  std::vector<Digest> blobs;
  const Status listed = database_.read([&](Transaction& transaction) {
    const std::string order = name == "checkpoints" ? " ORDER BY passes DESC" : " ORDER BY revision DESC, format";
    Query rows = transaction.query("SELECT blob FROM " + name + " WHERE job = ?" + order, job);
    for (std::size_t row = 0; rows.next(); ++row) {
      if (row >= keep) blobs.push_back(digest_of(rows.bytes(0)));
    }
    return rows.status();
  });
  return listed ? remove_rows(files, table, job, blobs) : listed;
}

/// Removes the rows of these blobs, and those of the blobs that no other row names.
Status JobFiles::remove_rows(Blobs& files, const char* table, const std::string& job,
                             const std::vector<Digest>& blobs) {
  if (blobs.empty()) return Done{};
  const std::string name = table;
  std::vector<Digest> gone;
  const Status written = database_.write([&](Transaction& transaction) -> Status {
    for (const Digest& blob : blobs) {
      const Status removed =
          transaction.run("DELETE FROM " + name + " WHERE job = ? AND blob = ?", job, name_of(blob));
      if (!removed) return removed;
      Query others = transaction.query("SELECT 1 FROM " + name + " WHERE blob = ? LIMIT 1", name_of(blob));
      if (!others.next()) gone.push_back(blob);
      if (const Status read = others.status(); !read) return read;
    }
    return Done{};
  });
  if (!written) return written;
  for (const Digest& blob : gone) {
    if (const Status removed = files.remove(blob); !removed) return removed;
  }
  return Done{};
}

}  // namespace photond
