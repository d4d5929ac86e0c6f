#include "server/jobs/machine_memory.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <string>

namespace photond {

std::uint64_t machine_memory() {
  std::uint64_t bytes =
      static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::")) continue;  // of v1
    std::uint64_t limit = 0;
    std::ifstream file("/sys/fs/cgroup" + line.substr(3) + "/memory.max");
    if (file >> limit) bytes = std::min(bytes, limit);  // else it says "max"
  }
  return bytes;
}

}  // namespace photond
