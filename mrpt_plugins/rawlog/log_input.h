// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "libhybrid/io/regular_file.h"

namespace HYBRID_API hybrid {

/// What a rawlog is read from: a regular file, or standard input as it comes.
class LogInput {
 public:
  /// Throws Error as RegularFile does; of standard input, for a terminal or a folder.
  explicit LogInput(const std::string& path);

  /// As messages name it.
  const std::string& name() const { return name_; }
  int descriptor() const;
  /// Bytes; nothing where only the end of standard input will tell.
  std::optional<std::uint64_t> size() const;

 private:
  std::string name_;
  std::optional<RegularFile> file_;
};

}  // namespace hybrid
