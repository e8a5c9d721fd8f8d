#include <cstdio>
#include <fstream>

#include "kinds.hpp"
#include "mutate.hpp"

/// write_seeds FOLDER: writes a fuzzer's initial corpus to FOLDER/KIND/: a valid input and some
/// that are slightly damaged.
int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  if (argc != 2) {
    std::fputs("usage: write_seeds FOLDER\n", stderr);
    return 1;
  }
  const fs::path scratch = fs::path(argv[1]) / "scratch";
  fs::create_directories(scratch);
  for (const auto& kind : chasles::fuzz::kinds()) {
    const fs::path folder = fs::path(argv[1]) / kind.name;
    fs::create_directories(folder);
    const std::string seed = kind.seed(scratch);
    std::ofstream(folder / "seed", std::ios::binary) << seed;
    chasles::fuzz::Dice dice(1);
    for (int i = 0; i < 16; ++i) {
      const std::string name = "damaged_" + std::to_string(i);
      std::ofstream(folder / name, std::ios::binary) << chasles::fuzz::mutate(seed, dice);
    }
  }
  fs::remove_all(scratch);
  return 0;
}
