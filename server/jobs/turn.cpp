#include "server/jobs/turn.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace photond {

namespace {

using Line = std::array<char, 64>;  // as long as any id, filled up with zeros

}  // namespace

Turn::Turn(const std::filesystem::path& file) {
  if (Result<File> opened = File::open(file, O_RDWR | O_CREAT)) file_ = std::move(*opened);
  Line line{};
  if (file_.read_at(std::as_writable_bytes(std::span(line)), 0)) last_ = line.data();
  give({});
}

void Turn::give(const std::string& job) const {
  Line line{};
  std::copy_n(job.begin(), std::min(job.size(), line.size() - 1), line.begin());
  // Into the memory of the system, which takes no time. One that fails leaves what stood there: an older turn.
  if (file_.is_open()) (void)(::pwrite(file_.descriptor(), line.data(), line.size(), 0) > 0);
}

}  // namespace photond
