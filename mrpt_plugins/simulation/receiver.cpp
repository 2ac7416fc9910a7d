// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/receiver.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/geometry/se3.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/simulation/random.h"

namespace hybrid {
namespace {

constexpr double kSameTime = 1e-9;  // s

Eigen::Vector3d normal_vector(double sigma, Random& random) {
  Eigen::Vector3d v;
  for (double& x : v) x = random.normal(sigma);
  return v;
}

/// One of the spells, and those before.
struct Spell {
  double begin = 0, end = 0;  // the first is yet to be drawn
  bool holds = false;

  /// Goes on to a time; true where another spell has begun since.
  bool advance(double time, const Scenario::Spells& spells, Random& random) {
    if (spells.every == 0) return false;
    const bool held = holds;
    bool is_another = false;
    while (time >= end) {
      begin = end - spells.every * std::log(1 - random.uniform());
      end = begin + random.uniform(spells.shortest, spells.longest);
      is_another = true;
    }
    holds = time >= begin;
    return holds && (is_another || !held);
  }
};

/// The errors of a receiver, fix by fix.
class Errors {
 public:
  Errors(const Scenario::Fixes& options, bool is_3d, Random& random)
      : options_(options), is_3d_(is_3d), random_(random) {
    lasting_ = normal_vector(options.lasting_sigma, random);
  }

  /// Goes on to a time; false where there is no fix.
  bool advance(double time) {
    const double passed = time - time_;
    time_ = time;
    const double kept = std::exp(-passed / options_.lasts);
    lasting_ = kept * lasting_ +
               normal_vector(options_.lasting_sigma * std::sqrt(1 - kept * kept), random_);
    if (run_.advance(time, options_.biased, random_)) begin_bias();
    const Eigen::Vector3d step = normal_vector(options_.bias_walk * std::sqrt(passed), random_);
    if (run_.holds) bias_.head(axes()) += step.head(axes());
    outage_.advance(time, options_.outages, random_);
    return !outage_.holds;
  }

  void draw(SimulatedFix& fix) {
    const Eigen::Vector3d own = normal_vector(options_.sigma, random_);
    const bool is_false = random_.uniform() < options_.false_share;
    fix.mode = is_false ? FixMode::kFalse : run_.holds ? FixMode::kBiased : FixMode::kGood;
    fix.error = lasting_ + own;
    if (run_.holds) fix.error += bias_;
    if (is_false) {
      const double half = options_.false_reach / 2;
      for (double& x : fix.error) x = random_.uniform(-half, half);
      fix.error.z() /= 10;  // heights are false by less
    }
    for (double& x : fix.error) x = quantised(x);
  }

 private:
  int axes() const { return is_3d_ ? 3 : 2; }

  void begin_bias() {
    Eigen::Vector3d direction = normal_vector(1, random_);
    if (!is_3d_) direction.z() = 0;
    bias_ = random_.uniform(options_.min_bias, options_.max_bias) * direction.normalized();
  }

  const Scenario::Fixes& options_;
  const bool is_3d_;
  Random& random_;
  double time_ = 0;
  Spell run_, outage_;
  Eigen::Vector3d lasting_, bias_ = Eigen::Vector3d::Zero();
};

/// The true pose at a time within the path, at constant velocity between frames.
Eigen::Isometry3d pose_at(double time, double period,
                          const std::vector<mrpt::poses::CPose3D>& path) {
  const double at = time / period;
  const std::size_t i = std::min(path.size() - 1, static_cast<std::size_t>(at + kSameTime));
  const double share = at - static_cast<double>(i);
  if (i + 1 == path.size() || share < kSameTime) return to_isometry(path[i]);
  const SE3 step = to_se3(path[i + 1] - path[i]);
  return to_isometry(path[i]) * to_isometry(SE3::exp(share * step.log()));
}

}  // namespace

std::vector<SimulatedFix> draw_fixes(const Scenario& scenario,
                                     const std::vector<mrpt::poses::CPose3D>& path) {
  const Scenario::Fixes& options = scenario.fixes;
  std::vector<SimulatedFix> fixes;
  if (options.period == 0) return fixes;
  const double frames = scenario.path.period;
  const double last = frames * static_cast<double>(path.size() - 1);
  const LocalFrame world(options.datum);
  const Eigen::Vector3d antenna(options.antenna[0], options.antenna[1], options.antenna[2]);
  constexpr std::uint64_t kOwn = std::uint64_t{1} << 63;
  Random random(scenario.seed ^ kOwn);
  Errors errors(options, scenario.is_3d, random);
  for (std::size_t k = 0;; ++k) {
    const double time = static_cast<double>(k) * options.period;
    SimulatedFix fix;
    fix.time = time + options.delay;
    if (fix.time > last + kSameTime) return fixes;
    if (!errors.advance(time)) continue;
    errors.draw(fix);
    fix.frame = static_cast<std::size_t>(std::ceil(fix.time / frames - kSameTime));
    const Eigen::Vector3d true_place = pose_at(time, frames, path) * antenna;
    fix.place = world.to_geodetic(true_place + fix.error);
    fix.place = {quantised(fix.place.latitude), quantised(fix.place.longitude),
                 quantised(fix.place.altitude)};
    fixes.push_back(fix);
  }
}

}  // namespace hybrid
