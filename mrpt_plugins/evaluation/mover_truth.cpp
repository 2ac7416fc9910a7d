// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/mover_truth.h"

#include <algorithm>

#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
TrueMovers read_true_movers(const std::string& path) {
  TrueMovers truth;
  TextReader table(path);
  for (auto row = table.first_below("step"); row; row = table.next()) {
    row->expect(5, "step,id,x,y,z");
    const auto step = static_cast<std::size_t>(row->id(0));
    const Eigen::Vector3d position(row->coordinate(2), row->coordinate(3), row->coordinate(4));
    if (!truth[row->id(1)].emplace(step, position).second) {
      row->fail("this thing has a place at this step already");
    }
  }
  return truth;
}

MoverReport mover_report(const std::vector<AssociationDecision>& decisions,
                         const std::vector<MoverEstimate>& movers, const MoverTruth& truth) {
  MoverReport report;
  report.things = movers.size();
  std::map<std::int64_t, std::map<std::int64_t, std::size_t>> votes;  // by mover and true id
  for (const AssociationDecision& d : decisions) {
    if (!d.true_id) continue;
    if (truth.movers.count(*d.true_id) == 0) {
      if (d.mover) ++report.false_sightings;
      continue;
    }
    ++report.sightings;
    if (!d.estimated_id) ++report.kept_out;
    if (!d.mover) continue;
    ++report.followed;
    ++votes[*d.mover][*d.true_id];
  }
  double sum = 0, relative_sum = 0;
  std::size_t relative = 0;
  for (const MoverEstimate& mover : movers) {
    const auto own = votes.find(mover.id);
    if (own == votes.end()) continue;
    const auto most = std::max_element(own->second.begin(), own->second.end(),
                                       [](auto& a, auto& b) { return a.second < b.second; });
    const auto& places = truth.movers.at(most->first);
    for (std::size_t k = 0; k < mover.states.size(); ++k) {
      if (mover.keyframes[k] >= truth.rows.size()) continue;
      const auto place = places.find(truth.rows[mover.keyframes[k]]);
      if (place == places.end()) continue;
      const Eigen::Vector3d& estimate = mover.states[k].position;
      const double error = (transformed(truth.T_truth_map, estimate) - place->second).norm();
      sum += error;
      report.max_m = std::max(report.max_m, error);
      ++report.states;
      const auto pose = truth.poses.find(mover.states[k].time);
      if (pose == truth.poses.end()) continue;
      const mrpt::poses::CPose3D T_truth_estimate =
          pose->second.truth + (mrpt::poses::CPose3D() - pose->second.estimate);
      relative_sum += (transformed(T_truth_estimate, estimate) - place->second).norm();
      ++relative;
    }
  }
  if (report.states > 0) report.mean_m = sum / static_cast<double>(report.states);
  if (relative > 0) report.relative_mean_m = relative_sum / static_cast<double>(relative);
  return report;
}

}  // namespace hybrid
