// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/trajectory_writer.h"

#include <fmt/format.h>
#include <mrpt/math/CQuaternion.h>

#include <cstddef>
#include <iterator>

namespace hybrid {

std::string tum_text(const Trajectory& trajectory, const std::vector<std::string>& names) {
  constexpr std::size_t kUsualRow = 128;
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  text.reserve(kUsualRow * trajectory.size());
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    const TimedPose& p = trajectory[k];
    mrpt::math::CQuaternionDouble q;
    p.pose.getAsQuaternion(q);
    const double sign = q.r() < 0 ? -1.0 : 1.0;
    fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}\n",
                   names.empty() ? fmt::to_string(p.time) : names[k], p.pose.x(), p.pose.y(),
                   p.pose.z(), sign * q.x(), sign * q.y(), sign * q.z(), sign * q.r());
  }
  return text;
}

std::string covariances_csv(const Trajectory& trajectory,
                            const std::vector<Eigen::MatrixXd>& covariances, bool is_3d) {
  std::vector<std::string> names = {"x", "y"};
  if (is_3d) names.insert(names.end(), {"z", "rx", "ry"});
  names.push_back(is_3d ? "rz" : "yaw");
  const auto n = static_cast<Eigen::Index>(names.size());
  std::string text = "time";
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = i; j < names.size(); ++j) text += "," + names[i] + "_" + names[j];
  }
  for (std::size_t k = 0; k < trajectory.size(); ++k) {
    fmt::format_to(std::back_inserter(text), "\n{}", trajectory[k].time);
    const Eigen::MatrixXd& P = covariances[k];
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = i; j < n; ++j) {
        text += ',';
        if (P.rows() == n) fmt::format_to(std::back_inserter(text), "{}", P(i, j));
      }
    }
  }
  return text + "\n";
}

}  // namespace hybrid
