// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// An example of a mapping plugin with a factor and a variable of its own: the walls of a building
// meet at right angles, so every laser scan tells the heading of the robot, modulo 90 degrees,
// against the direction of the walls, which nobody knows before.

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/factors/factor_of.h"
#include "mrpt_plugins/mapping/register_plugin.h"

namespace example {

/// Residual [rad]: heading + direction of the walls in the frame of the robot - their direction in
/// the map, modulo a right angle.
class WallDirection : public hybrid::FactorOf<1, hybrid::SE2, hybrid::SO2> {
 public:
  WallDirection(hybrid::Key pose, hybrid::Key walls, double measured, const hybrid::Noise& noise,
                hybrid::Loss loss)
      : FactorOf({pose, walls}, noise, loss), measured_(measured) {}

  std::string name() const override { return "wall direction"; }

  Residual evaluate(const hybrid::SE2& pose, const hybrid::SO2& walls,
                    Jacobian<hybrid::SE2>* J_pose, Jacobian<hybrid::SO2>* J_walls) const override {
    if (J_pose != nullptr) {
      *J_pose << 0, 0, 1;
      *J_walls << -1;
    }
    return Residual(hybrid::wrap_angle(4 * (pose.angle() + measured_ - walls.angle())) / 4);
  }

 private:
  double measured_;
};

/// The direction [rad] of the walls in the frame of the robot, modulo a right angle: of the mean of
/// exp(4 i a) over the ways between neighbouring points. None where they have no clear one.
std::optional<double> wall_direction(const mrpt::obs::CObservation2DRangeScan& scan,
                                     double least_share) {
  const std::size_t count = scan.getScanSize();
  const double turn = (scan.rightToLeft ? 1.0 : -1.0) * scan.aperture;
  std::optional<std::complex<double>> before;
  std::complex<double> sum = 0;
  double length = 0;
  for (std::size_t i = 0; i < count; i += 3) {  // neighbours farther apart: less noise
    if (!scan.getScanRangeValidity(i)) {
      before.reset();
      continue;
    }
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    const auto point = std::polar<double>(scan.getScanRange(i), turn * (share - 0.5));
    if (before) {
      const std::complex<double> way = point - *before;
      if (std::abs(way) < 0.5) {  // farther apart they are not of one wall
        sum += std::polar(std::abs(way), 4 * std::arg(way));
        length += std::abs(way);
      }
    }
    before = point;
  }
  if (length < 1.0 || std::abs(sum) < least_share * length) return std::nullopt;
  return std::arg(sum) / 4 + scan.sensorPose.yaw();
}

class WallCompass : public hybrid::MappingPlugin {
  DEFINE_MRPT_OBJECT(WallCompass, example)

 public:
  void configure(hybrid::IniSection section) override {
    sigma_ = section.get("sigma", sigma_, "of the direction of a scan [rad]", hybrid::kPositive);
    share_ = section.get("share", share_, "least share of a scan that agrees on the direction",
                         hybrid::kPositive);
  }

  std::vector<std::string> observation_classes() const override {
    return {"CObservation2DRangeScan"};
  }

  hybrid::Contribution observe(const hybrid::Frame& frame, const hybrid::MapView& map) override {
    hybrid::Contribution out;
    if (map.is_3d) return out;
    for (const auto& observation : frame.observations) {
      using Scan = mrpt::obs::CObservation2DRangeScan;
      const auto* scan = dynamic_cast<const Scan*>(observation.get());
      if (scan == nullptr) continue;
      if (const auto direction = wall_direction(*scan, share_)) {
        add(frame, map, *direction, out);
      } else {
        ++out.dropped["example: a scan without a clear direction"];
      }
    }
    return out;
  }

 private:
  void add(const hybrid::Frame& frame, const hybrid::MapView& map, double direction,
           hybrid::Contribution& out) const {
    const hybrid::Key walls('w', 0);
    // A window may have marginalised it, and a contribution that was refused never brought it.
    if (!map.holds(walls) && !out.delta.values.contains(walls)) {
      out.delta.values.insert(walls, hybrid::SO2(frame.T_map_robot.yaw() + direction));
    }
    out.delta.continuous.push_back(std::make_shared<WallDirection>(
        frame.pose, walls, direction, hybrid::Noise::isotropic(1, sigma_), hybrid::Loss::huber()));
  }

  double sigma_ = 0.03, share_ = 0.4;
};

}  // namespace example

HYBRID_REGISTER_PLUGIN(WallCompass, example)
