#include "core/scene/gltf/warnings.h"

namespace photond::gltf {

void Warnings::add(const std::string& message, const std::string& place) {
  const auto [found, inserted] = index_.try_emplace(message, entries_.size());
  if (inserted) {
    entries_.push_back({message, place});
  } else {
    ++entries_[found->second].count;
  }
}

std::vector<std::string> Warnings::lines() const {
  std::vector<std::string> out;
  for (const Entry& entry : entries_) {
    const std::string more = entry.count > 1 ? " and " + std::to_string(entry.count - 1) + " more" : "";
    out.push_back(entry.place + more + ": " + entry.message);
  }
  return out;
}

}  // namespace photond::gltf
