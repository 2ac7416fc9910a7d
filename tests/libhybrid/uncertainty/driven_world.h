// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/uncertainty/sensor_noise.h"

namespace hybrid {

/// A robot on a winding way among things, with what is wrong with its log.
struct DrivenWorld {
  double range_m = 0.05, range_share = 0, angle = 0.01;  ///< true noise
  double stated_range = 0.1, stated_angle = 0.02;
  double odometry_angle = 0.004, stated_odometry_angle = 0.004;  ///< rad per sqrt(step)
  double lasting = 0;                                            ///< m, of ranges, alike for 3 s
  double mirrored = 1, yaw = 0, delay = 0;
  double clutter = 0.1;       ///< per frame
  double turning = 1;         ///< 0: straight on
  bool bends_rarely = false;  ///< turns alike but for 5 s in 30
  double speed = 1;           ///< m/s
  int things = 60;
  double half = 20;  ///< side of the square of things, halved [m]
  int frames = 600;
  bool is_3d = false, has_ids = false, tracker = false;
  unsigned seed = 1;
};

struct DrivenLog {
  std::vector<OdometryPose> odometry;
  std::vector<MovedSightings> frames;

  std::vector<TimedSightings> sightings() const {
    std::vector<TimedSightings> out;
    for (const MovedSightings& frame : frames) out.push_back(frame.sightings);
    return out;
  }
};

inline DrivenLog drive(const DrivenWorld& world) {
  constexpr double kStep = 0.05;  // s; a frame every fourth
  std::mt19937 random(world.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Vector3d> things;
  for (int k = 0; k < world.things; ++k) {
    things.emplace_back(world.half * uniform(random), world.half * uniform(random),
                        world.is_3d ? 2 * uniform(random) : 0.0);
  }
  std::vector<SE3> truth;
  DrivenLog log;
  SE3 pose({0, -8, 0}, SO3()), odometry;
  const int steps = 4 * world.frames + 100;
  for (int i = 0; i < steps; ++i) {
    truth.push_back(pose);
    log.odometry.push_back({kStep * i, odometry});
    SE3::Tangent v = SE3::Tangent::Zero();
    v[0] = world.speed * kStep;
    const bool bends = !world.bends_rarely || i % 600 < 100;
    v[5] = world.turning * kStep * (0.12 + (bends ? 0.5 * std::sin(0.9 * kStep * i) : 0));
    pose = pose * SE3::exp(v);
    v[5] += 0.5 * world.odometry_angle * normal(random);
    v[0] += 0.002 * normal(random);
    v[1] += 0.002 * normal(random);
    odometry = odometry * SE3::exp(v);
  }
  std::vector<int> last(things.size(), -1000);
  std::vector<std::int64_t> ids(things.size(), -1);
  std::vector<double> lasting(things.size(), 0);
  std::int64_t next = 0;
  const SE3 T_robot_sensor({0.2, 0, 0}, SO3());
  for (int i = 40; i < 4 * world.frames + 40; i += 4) {
    MovedSightings frame;
    frame.sightings.time = kStep * i + world.delay;
    frame.sightings.T_robot_sensor = T_robot_sensor;
    const auto stamped = static_cast<std::size_t>(i + std::lround(world.delay / kStep));
    frame.T_odometry_robot = log.odometry[stamped].pose;
    frame.motion_covariance(0, 0) = frame.motion_covariance(1, 1) = 4 * 0.002 * 0.002;
    frame.motion_covariance(5, 5) = std::pow(world.stated_odometry_angle, 2);
    const SE3 sensor = truth[static_cast<std::size_t>(i)] * T_robot_sensor *
                       SE3(Eigen::Vector3d::Zero(), SO3::exp({0, 0, world.yaw}));
    const int dim = world.is_3d ? 3 : 2;
    const auto add = [&](Eigen::Vector3d z, std::optional<std::int64_t> id) {
      z[1] *= world.mirrored;
      const Eigen::Vector3d sigma(world.stated_range, world.stated_angle, world.stated_angle);
      const Eigen::VectorXd variances = sigma.head(dim).array().square();
      frame.sightings.seen.push_back({z.head(dim), variances.asDiagonal()});
      frame.ids.push_back(id);
    };
    const double keep = world.lasting > 0 ? std::exp(-4 * kStep / 3) : 0;
    for (double& l : lasting) {
      if (world.lasting > 0)
        l = keep * l + world.lasting * std::sqrt(1 - keep * keep) * normal(random);
    }
    for (std::size_t k = 0; k < things.size(); ++k) {
      Eigen::Vector3d z = to_polar(Eigen::Vector3d(sensor.inverse() * things[k]));
      const bool ahead = std::abs(std::remainder(z[1] + world.yaw, 2 * M_PI)) < 1.2;
      if (z[0] > 10 || z[0] < 0.5 || !ahead || uniform(random) > 0.7) continue;
      if (ids[k] < 0 || (world.tracker && i - last[k] > 40)) ids[k] = next++;
      last[k] = i;
      z[0] += lasting[k] + std::hypot(world.range_m, world.range_share * z[0]) * normal(random);
      z[1] += world.angle * normal(random);
      if (world.is_3d) z[2] += world.angle * normal(random);
      add(z, world.has_ids ? std::optional<std::int64_t>(ids[k]) : std::nullopt);
    }
    if (0.5 * (1 + uniform(random)) < world.clutter) {
      add({5 + 4 * uniform(random), uniform(random) - world.yaw, 0}, std::nullopt);
    }
    log.frames.push_back(frame);
  }
  return log;
}

}  // namespace hybrid
