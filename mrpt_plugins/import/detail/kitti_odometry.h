// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <optional>
#include <string>

#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// Streams the motions between consecutive images.
class KittiOdometry {
 public:
  /// Of files as KittiOptions has them. Throws Error for a missing one.
  KittiOdometry(const std::string& odometry, const std::string& covariances, double inflate);

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

  bool is_3d_;
  TextReader table_;
  std::string covariances_file_;
  std::optional<TextReader> covariances_;
  double inflate_;  // standard deviations of these
  std::optional<mrpt::poses::CPose3D> last_;
  bool y_is_right_ = false;  // in the file
  std::size_t count_ = 0;
};

}  // namespace hybrid
