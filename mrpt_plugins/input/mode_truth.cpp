// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/mode_truth.h"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "libhybrid/core/error.h"

namespace hybrid {

std::vector<int> read_true_modes(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw Error(fmt::format("cannot read {}", path));
  std::vector<int> modes;
  std::string line;
  for (int n = 1; std::getline(file, line); ++n) {
    std::istringstream words(line.substr(0, line.find_first_of("%#")));
    std::string word, more;
    if (!(words >> word)) continue;
    const bool digits = word.find_first_not_of("0123456789") == std::string::npos;
    if (!digits || word.size() > 6 || (words >> more)) {
      throw Error(fmt::format("{}:{}: '{}' is not the number of a mode", path, n, line));
    }
    modes.push_back(std::stoi(word));
  }
  if (modes.empty()) throw Error(fmt::format("{}: holds no mode", path));
  return modes;
}

}  // namespace hybrid
