#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "server/store/blobs.h"
#include "server/store/database.h"
#include "server/store/records.h"

namespace photond {

/// The files of jobs: encoded pictures, and checkpoints, which are accumulator files. A row is written after its
/// blob; a blob goes after its last row. Thread-safe.
class JobFiles {
 public:
  struct Checkpoint {
    std::uint32_t passes = 0;
    double seconds = 0;  ///< of computing, until here
    Digest blob;
    std::uint64_t bytes = 0;
  };

  /// `database` must have the tables of schema() and outlive the object. Errors: io.
  static Result<std::unique_ptr<JobFiles>> open(Database& database, const std::filesystem::path& frames,
                                                const std::filesystem::path& checkpoints);

  /// Keeps an encoded picture; the first one of a revision and format stays. Errors: those of the disk.
  Status put_frame(const std::string& job, std::uint32_t revision, FrameFormat format,
                   std::span<const std::byte> bytes);
  /// Errors: not_found (not kept, or damaged), io.
  Result<Blob> frame(const std::string& job, std::uint32_t revision, FrameFormat format);
  /// The same as a file. Errors: as frame.
  Result<FileBytes> open_frame(const std::string& job, std::uint32_t revision, FrameFormat format);

  /// Keeps what `content` writes as the newest checkpoint, and the one before it. Errors: those of the disk.
  Status put_checkpoint(const std::string& job, std::uint32_t passes, double seconds,
                        const Blobs::Content& content);
  /// Newest first.
  Result<std::vector<Checkpoint>> checkpoints(const std::string& job);
  /// Errors: not_found for a damaged one, io.
  Result<Blob> read(const Checkpoint& checkpoint) { return checkpoint_files_->get(checkpoint.blob); }
  /// The same as a file. Errors: as read.
  Result<FileBytes> open(const Checkpoint& checkpoint) { return checkpoint_files_->open_file(checkpoint.blob); }
  /// Removes all but the newest `keep`.
  Status drop_checkpoints(const std::string& job, std::size_t keep = 0);
  /// Removes those before the newest that is whole. Errors: io.
  Status drop_older_checkpoints(const std::string& job);
  /// Removes one that is of no use. Errors: io.
  Status drop_checkpoint(const std::string& job, const Checkpoint& checkpoint);
  /// Removes the pictures of a job.
  Status drop_frames(const std::string& job);

  /// What would be gone if these jobs kept their pictures and newest checkpoints, and other jobs nothing. Errors: io.
  Result<std::uint64_t> spare_bytes(const std::set<std::string>& jobs);

  const Blobs& frame_files() const { return *frame_files_; }
  const Blobs& checkpoint_files() const { return *checkpoint_files_; }

 private:
  Result<Digest> find_frame(const std::string& job, std::uint32_t revision, FrameFormat format);
  JobFiles(Database& database, std::unique_ptr<Blobs> frames, std::unique_ptr<Blobs> checkpoints)
      : database_(database), frame_files_(std::move(frames)), checkpoint_files_(std::move(checkpoints)) {}
  Status sweep(Blobs& files, const char* table);
  Status publish(Blobs& files, const char* table, const Blobs::Written& written, const Database::Body& row);
  void remove_unnamed(Blobs& files, const char* table, const Digest& blob);
  Result<std::uint64_t> bytes_without(const std::string& rows, const std::set<std::string>& jobs);
  Status drop(Blobs& files, const char* table, const std::string& job, std::size_t keep);
  Status remove_rows(Blobs& files, const char* table, const std::string& job, const std::vector<Digest>& blobs);

  Database& database_;
  const std::unique_ptr<Blobs> frame_files_;
  const std::unique_ptr<Blobs> checkpoint_files_;
  std::mutex changing_;  ///< a blob that is published must not lose its file before it has its row; never held for long
};

}  // namespace photond
