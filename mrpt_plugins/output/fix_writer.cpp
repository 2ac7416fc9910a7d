// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/fix_writer.h"

#include <fmt/format.h>

#include <iterator>

#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/output/detail/csv_field.h"

namespace hybrid {

std::string to_string(FixMode mode) {
  return kFixModes.at(static_cast<std::size_t>(mode));
}

std::string fixes_csv(const MapResult& result) {
  std::string text =
      "time,keyframe,x,y,z,antenna_x,antenna_y,antenna_z,east,north,up,error_east,error_north,"
      "error_up,sigma,mode,p_good,p_biased,p_false,not_used,sensor\n";
  for (const FixEstimate& fix : result.fixes) {
    Eigen::Vector3d off = Eigen::Vector3d::Zero();
    if (result.datum) off = result.datum->T_datum_map.linear() * (fix.measured - fix.antenna);
    fmt::format_to(std::back_inserter(text), "{},{}", fix.time, fix.keyframe);
    for (const Eigen::Vector3d& v : {fix.measured, fix.antenna, off, fix.error}) {
      fmt::format_to(std::back_inserter(text), ",{:.6f},{:.6f},{:.6f}", v.x(), v.y(), v.z());
    }
    fmt::format_to(std::back_inserter(text), ",{:.6g},{}", fix.sigma,
                   fix.mode ? to_string(*fix.mode) : "");
    const auto& p = fix.probabilities;
    const bool known = p[0] + p[1] + p[2] > 0;
    for (const double value : p) text += known ? fmt::format(",{:.6g}", value) : ",";
    text += ',' + fix.unused + ',' + csv_field(fix.sensor) + '\n';
  }
  return text;
}

}  // namespace hybrid
