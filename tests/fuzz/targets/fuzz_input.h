// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "libhybrid/core/error.h"

/// One run of a target on any bytes: Error is what bad input gives; whatever else leaves it, or
/// ends the process, is a fault.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace hybrid::fuzz {

/// The bytes of an input, from which a target takes choices first.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size)
      : rest_(reinterpret_cast<const char*>(data), size) {}

  /// A number below n, from the next byte; a letter or digit in text, so that a seed can be read.
  std::size_t choose(std::size_t n) {
    if (rest_.empty()) return 0;
    const auto byte = static_cast<unsigned char>(rest_.front());
    rest_.remove_prefix(1);
    return byte % n;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

/// A folder of its own for the files of one process, removed at its end.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("fuzz_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }

  std::string at(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, std::string_view content) const {
    std::ofstream(at(name), std::ios::binary) << content;
    return at(name);
  }

 private:
  std::filesystem::path path_;
};

/// Ends the process, so that the input counts as a finding.
inline void expect(bool holds) {
  if (!holds) std::abort();
}

/// Calls what may throw Error.
template <class Call>
void allow_error(Call call) {
  try {
    call();
  } catch (const Error& e) {
    expect(!std::string_view(e.what()).empty());
  }
}

}  // namespace hybrid::fuzz
