// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Runs a target without libFuzzer: on all files of the given folders and files, then on damaged
// copies of them, the same ones for the same seed. Each input is written to FILE before it is run.
// TARGET [--mutations N] [--seed S] [--save FILE] PATH...

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fuzz/targets/fuzz_input.h"

namespace {

namespace fs = std::filesystem;

void run(const std::string& bytes, const std::string& save) {
  if (!save.empty()) std::ofstream(save, std::ios::binary) << bytes;
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// All files, in order of their names.
std::vector<fs::path> files_of(const fs::path& path) {
  if (!fs::is_directory(path)) return {path};
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// One to four changes: of a byte, of a stretch that is repeated, removed or comes from another
/// seed, of a number.
std::string damaged(std::string bytes, const std::string& other, std::mt19937_64& random) {
  constexpr const char* kNumbers[] = {"1e300", "-1",  "nan", "1e-300", "99999999999999999999",
                                      "0",     "1,5", "",    "inf",    "4294967297"};
  for (auto n = 1 + random() % 4; n > 0; --n) {
    const std::size_t at = bytes.empty() ? 0 : random() % bytes.size();
    const std::size_t count = 1 + random() % 40;
    switch (random() % 6) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.erase(at, count);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, count));
        break;
      case 3:
        bytes.insert(at, other.substr(other.empty() ? 0 : random() % other.size(), count));
        break;
      case 4:
        bytes.resize(at);
        break;
      default: {
        const std::size_t begin = std::min(bytes.find_first_of(" ,=", at), bytes.size());
        const std::size_t end = std::min(bytes.find_first_of(" ,\n", begin + 1), bytes.size());
        if (begin < end) bytes.replace(begin + 1, end - begin - 1, kNumbers[random() % 10]);
      }
    }
  }
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  std::uint64_t mutations = 0, seed = 1;
  std::string save;
  std::vector<std::string> seeds;
  for (int i = 1; i < argc; ++i) {
    if (i + 1 < argc && std::strcmp(argv[i], "--mutations") == 0) {
      mutations = std::stoull(argv[++i]);
    } else if (i + 1 < argc && std::strcmp(argv[i], "--seed") == 0) {
      seed = std::stoull(argv[++i]);
    } else if (i + 1 < argc && std::strcmp(argv[i], "--save") == 0) {
      save = argv[++i];
    } else {
      for (const fs::path& file : files_of(argv[i])) seeds.push_back(read(file));
    }
  }
  if (seeds.empty()) {
    std::fprintf(stderr, "no input given\n");
    return 1;
  }
  for (const std::string& bytes : seeds) run(bytes, save);
  std::mt19937_64 random(seed);
  for (std::uint64_t i = 0; i < mutations; ++i) {
    const std::string& first = seeds[random() % seeds.size()];
    run(damaged(first, seeds[random() % seeds.size()], random), save);
  }
  std::printf("%zu inputs and %llu damaged copies\n", seeds.size(),
              static_cast<unsigned long long>(mutations));
  return 0;
}
