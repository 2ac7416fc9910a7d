// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid::bench {

/// A measurement of a pose or of a point, seen from a pose.
struct Measurement {
  Key from;
  Key to;
  std::variant<SE2, SE3, Eigen::Vector2d> measured;  ///< a point as range [m] and bearing [rad]
  Noise noise;
  ContinuousFactorPtr factor;
};

/// The measurements of one step: those with its pose as the later one, relative poses first.
using Step = std::vector<Measurement>;

/// Reads relative poses, grouped by their later pose.
inline std::vector<Step> read_pose_graph(const std::string& path) {
  const PoseGraph graph = read_graph(path);
  std::map<Key, Step> steps;
  for (const GraphEdge<SE2>& e : graph.poses2) {
    steps[std::max(e.from, e.to)].push_back(
        {e.from, e.to, e.measured, e.noise,
         std::make_shared<BetweenSE2>(e.from, e.to, e.measured, e.noise)});
  }
  for (const GraphEdge<SE3>& e : graph.poses3) {
    steps[std::max(e.from, e.to)].push_back(
        {e.from, e.to, e.measured, e.noise,
         std::make_shared<Between<SE3>>(e.from, e.to, e.measured, e.noise)});
  }
  std::vector<Step> list;
  for (auto& [key, step] : steps) list.push_back(std::move(step));
  return list;
}

/// Victoria Park with known association: "ODOMETRY i j x y angle" with the upper triangle of a
/// covariance, and "LANDMARK i l x y v ..." with the variance v of the range [m^2]; that of the
/// bearing is v / 10 [rad^2].
inline std::vector<Step> read_victoria_park(const std::string& path) {
  TextReader reader(path, {TextFormat::Cut::kWords, "#"});
  std::map<std::uint64_t, Step> odometry, sightings;
  for (TextRow row; reader.next(row);) {
    const bool is_odometry = row[0] == "ODOMETRY";
    if (!is_odometry && row[0] != "LANDMARK") row.fail("neither ODOMETRY nor LANDMARK");
    row.expect(is_odometry ? 12 : 6, 12, "a tag, i, j, x, y and the rest of a measurement");
    const auto i = static_cast<std::uint64_t>(row.id(1)), j = static_cast<std::uint64_t>(row.id(2));
    const double x = row.number(3), y = row.number(4);
    const std::vector<double> v = row.numbers(5, row.size());
    const Key pose('x', i);
    if (is_odometry) {
      Eigen::Matrix3d covariance;
      covariance << v[1], v[2], v[3], v[2], v[4], v[5], v[3], v[5], v[6];
      const SE2 z(x, y, v[0]);
      const Noise noise = Noise::covariance(covariance);
      const Key next('x', j);
      odometry[j].push_back(
          {pose, next, z, noise, std::make_shared<BetweenSE2>(pose, next, z, noise)});
    } else {
      const Eigen::Vector2d z(std::hypot(x, y), std::atan2(y, x));
      const Eigen::Vector2d sigmas(std::sqrt(v[0]), std::sqrt(v[0] / 10.0));
      const Noise noise = Noise::diagonal(sigmas);
      const Key landmark('l', j);
      sightings[i].push_back(
          {pose, landmark, z, noise, std::make_shared<BearingRange2>(pose, landmark, z, noise)});
    }
  }
  for (auto& [i, list] : sightings) {
    odometry[i].insert(odometry[i].end(), list.begin(), list.end());
  }
  std::vector<Step> list;
  for (auto& [i, step] : odometry) list.push_back(std::move(step));
  return list;
}

inline std::vector<Step> read_steps(const std::string& path) {
  const bool g2o = path.size() > 4 && path.substr(path.size() - 4) == ".g2o";
  return g2o ? read_pose_graph(path) : read_victoria_park(path);
}

/// Inserts a new variable at the value that a measurement gives from its known other end.
inline void insert_from(const Measurement& m, const Values& known, Values& values) {
  const auto has = [&](Key key) { return values.contains(key) || known.contains(key); };
  const bool forward = !has(m.to);
  if (!forward && has(m.from)) return;
  const Key origin = forward ? m.from : m.to;
  const Values& home = values.contains(origin) ? values : known;
  if (const SE2* z = std::get_if<SE2>(&m.measured)) {
    const SE2 pose = home.at<SE2>(origin);
    values.insert(forward ? m.to : m.from, forward ? pose * *z : pose * z->inverse());
  } else if (const SE3* z = std::get_if<SE3>(&m.measured)) {
    const SE3 pose = home.at<SE3>(origin);
    values.insert(forward ? m.to : m.from, forward ? pose * *z : pose * z->inverse());
  } else {
    values.insert(m.to, Eigen::Vector2d(home.at<SE2>(origin) *
                                        from_polar(std::get<Eigen::Vector2d>(m.measured))));
  }
}

template <class Pose>
void insert_first(Key key, Delta& delta) {
  delta.values.insert(key, Pose());
  delta.continuous.push_back(
      std::make_shared<Prior<Pose>>(key, Pose(), Noise::isotropic(Pose::kDim, 0.01)));
}

/// The change of a step on top of the present estimate; the first pose gets a prior.
inline Delta to_delta(const Step& step, const Values& estimate) {
  Delta delta;
  if (estimate.empty()) {
    const Measurement& m = step.front();
    const bool point = std::holds_alternative<Eigen::Vector2d>(m.measured);
    const Key first = point ? m.from : std::min(m.from, m.to);
    std::holds_alternative<SE3>(m.measured) ? insert_first<SE3>(first, delta)
                                            : insert_first<SE2>(first, delta);
  }
  for (const Measurement& m : step) {
    insert_from(m, estimate, delta.values);
    delta.continuous.push_back(m.factor);
  }
  return delta;
}

}  // namespace hybrid::bench
