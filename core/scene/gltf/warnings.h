#pragma once

#include <map>
#include <string>
#include <vector>

namespace photond::gltf {

/// Collects warnings so that one message about many places stays one line.
class Warnings {
 public:
  void add(const std::string& message, const std::string& place);
  /// "place: message" or "place and 4 more: message", in the order of first occurrence.
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::string message;
    std::string place;
    std::size_t count = 1;
  };
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace photond::gltf
