// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <optional>

#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/kitti.h"

namespace hybrid {

/// Streams the motions between consecutive images.
class KittiOdometry {
 public:
  /// Throws Error for a missing file.
  explicit KittiOdometry(const KittiOptions& options);

  /// The next motion; empty at the end. Counts dropped and repaired motions. Throws Error with
  /// file:line for malformed rows.
  std::optional<OdometryIncrement> next(DropReport& dropped);

  /// Motions so far.
  std::size_t count() const { return count_; }
  bool is_3d() const { return is_3d_; }
  /// Share of the file that has been read.
  double share() const { return table_.share(); }

 private:
  std::optional<OdometryIncrement> next_in_plane(DropReport& dropped);
  std::optional<OdometryIncrement> next_in_space();

  const KittiOptions& options_;
  bool is_3d_;
  TextReader table_;
  std::optional<TextReader> covariances_;
  std::optional<mrpt::poses::CPose3D> last_;
  bool y_is_right_ = false;  // in the file
  std::size_t count_ = 0;
};

}  // namespace hybrid
