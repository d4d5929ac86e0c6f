#pragma once

#include <filesystem>
#include <string>

#include "server/store/file.h"

namespace photond {

/// Whose turn it is to compute, in a file that the next start finds: when the process dies that job is to blame sooner than
/// those that merely wait. It outlives the process, not the power; where it cannot be written nobody is to blame.
class Turn {
 public:
  explicit Turn(const std::filesystem::path& file);

  /// Who had it when the process before this one died; nobody: empty.
  const std::string& last() const { return last_; }
  /// By its id; empty: nobody has it.
  void give(const std::string& job) const;

 private:
  File file_;
  std::string last_;
};

}  // namespace photond
