// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <string>

#include "libhybrid/io/text_reader.h"

namespace hybrid {

/// The lines of a log of CARMEN, compressed or not.
class CarmenLines {
 public:
  explicit CarmenLines(const std::string& path);

  bool next(TextRow& row) { return reader_->next(row); }
  /// Back to the first line.
  void rewind();
  double share() const { return text_.empty() ? reader_->share() : 0; }
  bool is_compressed() const { return !text_.empty(); }
  /// Whether the last line has no end.
  bool is_cut() const;

 private:
  std::string path_;
  std::string text_;  // of a compressed log
  std::unique_ptr<TextReader> reader_;
};

}  // namespace hybrid
