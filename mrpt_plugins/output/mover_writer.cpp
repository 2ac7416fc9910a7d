// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mover_writer.h"

#include <fmt/format.h>

#include <iterator>

#include "mrpt_plugins/output/detail/csv_field.h"

namespace hybrid {

std::string movers_csv(const MapResult& result) {
  std::string text =
      "id,probability,class,sightings,keyframe,time,x,y,z,vx,vy,vz,"
      "cov_xx,cov_xy,cov_xz,cov_yy,cov_yz,cov_zz,"
      "cov_vxvx,cov_vxvy,cov_vxvz,cov_vyvy,cov_vyvz,cov_vzvz\n";
  const auto out = std::back_inserter(text);
  for (const MoverEstimate& mover : result.movers) {
    const std::string name =
        mover.class_index ? csv_field(result.class_names.at(*mover.class_index)) : "";
    for (std::size_t k = 0; k < mover.states.size(); ++k) {
      const MoverState& s = mover.states[k];
      fmt::format_to(out, "{},{:.6g},{},{},{},{},{},{},{},{},{},{}", mover.id, mover.probability,
                     name, mover.sightings, mover.keyframes[k], s.time, s.position.x(),
                     s.position.y(), s.position.z(), s.velocity.x(), s.velocity.y(),
                     s.velocity.z());
      for (int first : {0, 3}) {
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j) {
            fmt::format_to(out, ",{}", s.covariance(first + i, first + j));
          }
        }
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace hybrid
