// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <optional>
#include <string>

#include "libhybrid/io/text_reader.h"

namespace hybrid {

/// Streams true poses in the plane, rows `time x y angle`, and interpolates them.
class PlanarTruth {
 public:
  explicit PlanarTruth(const std::string& path) : table_(path) {}

  /// The pose at `time`, which must not be before that of the last call; empty outside the times of
  /// the file.
  std::optional<mrpt::poses::CPose3D> at(double time);

 private:
  struct Row {
    double time, x, y, angle;
  };

  void advance();

  TextReader table_;
  std::optional<Row> before_, after_;
};

}  // namespace hybrid
