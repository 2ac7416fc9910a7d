// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/bridge/satellite_fix.h"
#include "mrpt_plugins/import/detail/named_table.h"
#include "mrpt_plugins/import/detection_options.h"
#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

/// Streams a table of satellite fixes, row by row.
class FixTable {
 public:
  explicit FixTable(const FixTableOptions& options);

  /// Time of the next fix [s]; infinite after the last one.
  double time() const { return next_ ? next_->time : std::numeric_limits<double>::infinity(); }
  /// Times of the first fix and of the last one that was taken.
  double first() const { return first_; }
  double last() const { return last_; }

  /// All fixes of a time that are next.
  std::vector<mrpt::obs::CObservation::Ptr> take(double time);

  /// Share of the file that has been read.
  double share() const { return table_.share(); }
  /// Notes what is odd about the table, and where it is put.
  void finish(LogWriter& log) const;

 private:
  void check_columns() const;
  void advance();
  GeodeticPoint place();
  GeodeticPoint stated_place() const;
  std::uint8_t quality() const;

  const FixTableOptions& options_;
  NamedTable table_;
  std::optional<LocalFrame> frame_;            // of tables with x and y
  std::optional<Eigen::Vector3d> subtracted_;  // the first place, where no datum is given
  std::string label_;
  std::optional<SatelliteFix> next_;
  double first_ = 0, last_ = 0;
};

}  // namespace hybrid
