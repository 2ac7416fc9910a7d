// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// commit_driver MAIN NAME=TEXT... [-FORMER...]: writes a group of files.

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "libhybrid/io/file_group.h"
#include "libhybrid/io/file_writer.h"

int main(int argc, char** argv) try {
  hybrid::FileGroup group(argv[1]);
  std::vector<std::string> former;
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    if (word[0] == '-') {
      former.push_back(word.substr(1));
      continue;
    }
    const std::string name = word.substr(0, word.find('='));
    hybrid::FileWriter file(group.stage(name), group.target(name));
    file.write(word.substr(word.find('=') + 1));
    file.close();
  }
  group.commit(former);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "%s\n", e.what());
  return 1;
}
