// Writes the sample scenes: photond_samples OUTDIR
#include <filesystem>
#include <fstream>
#include <iostream>

#include "scenes.h"

namespace {

bool write_file(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return static_cast<bool>(out.flush());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: photond_samples OUTDIR\n";
    return 2;
  }
  const std::filesystem::path directory = argv[1];
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  using namespace photond::samples;
  const std::pair<const char*, Glb> scenes[] = {{"cornell_box.glb", cornell_box()},
                                                {"glass_and_mirror.glb", glass_and_mirror()},
                                                {"pool.glb", pool()},
                                                {"lantern.glb", lantern()}};
  for (const auto& [name, glb] : scenes) {
    if (write_file(directory / name, glb.bytes())) continue;
    std::cerr << "photond_samples: cannot write " << (directory / name).string() << "\n";
    return 1;
  }
  return 0;
}
