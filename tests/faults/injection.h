// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "libhybrid/io/folders.h"
#include "tests/apps/run_app.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {

/// One call of a program that goes wrong: see fault_shim.cpp.
struct Fault {
  std::string calls = "disk";  ///< disk, space, open or memory
  std::string how = "once";    ///< once, on, or the number of a signal
  long at = 0;                 ///< counted from 1; 0: none
};

inline std::string to_string(const Fault& fault) {
  return fault.calls + " call " + std::to_string(fault.at) + ", " + fault.how;
}

using Files = std::map<std::string, std::string>;

class InjectionTest : public ScratchFolder {
 protected:
  void SetUp() override {
    if (HYBRID_SANITIZED) GTEST_SKIP() << "sanitizers take the place of the calls";
  }

  /// Runs a program of the build with a call that goes wrong.
  Ran run_with(const Fault& fault, const std::string& command) const {
    return run_app(command, "LD_PRELOAD=" HYBRID_FAULT_SHIM " HYBRID_FAULT_CALLS=" + fault.calls +
                                " HYBRID_FAULT_HOW=" + fault.how +
                                " HYBRID_FAULT_AT=" + std::to_string(fault.at) +
                                " HYBRID_FAULT_COUNT=" + at("calls.txt") + " ");
  }
  /// How many such calls it makes.
  long count(const Fault& fault, const std::string& command) const {
    const Ran ran = run_with({fault.calls, fault.how, 0}, command);
    EXPECT_EQ(ran.code, 0) << ran.text;
    return std::stol(read("calls.txt"));
  }
  /// All numbers up to `count`, or, where that is too long, so many drawn by a fixed seed.
  static std::vector<long> numbers(long count, std::size_t most) {
    std::vector<long> all(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<long>(i) + 1;
    std::mt19937_64 random(20260101);
    for (std::size_t i = all.size(); i-- > 1;) std::swap(all[i], all[random() % (i + 1)]);
    all.resize(std::min(all.size(), most));
    std::sort(all.begin(), all.end());
    return all;
  }

  /// All files of a folder, hidden ones too.
  Files files(const std::string& name) const {
    Files found;
    for (const std::string& file : files_below(folder / name)) {
      found[file] = read(name + "/" + file);
    }
    return found;
  }
  void set_files(const std::string& name, const Files& files) const {
    std::filesystem::remove_all(folder / name);
    for (const auto& [file, text] : files) {
      std::filesystem::create_directories((folder / name / file).parent_path());
      write(name + "/" + file, text);
    }
  }
};

}  // namespace hybrid
