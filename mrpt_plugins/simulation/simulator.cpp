// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/simulator.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/simulation/laser.h"
#include "mrpt_plugins/simulation/random.h"
#include "mrpt_plugins/simulation/robot_path.h"

namespace hybrid {
namespace {

constexpr int kPlacementTries = 10000;

std::vector<SimulatedLandmark> place_landmarks(const Scenario::World& world, Random& random) {
  std::vector<SimulatedLandmark> landmarks;
  const auto too_near = [&](const std::array<double, 3>& p) {
    return std::any_of(landmarks.begin(), landmarks.end(), [&](const SimulatedLandmark& other) {
      return std::hypot(p[0] - other.position[0], p[1] - other.position[1],
                        p[2] - other.position[2]) < world.min_spacing;
    });
  };
  for (int i = 0; i < world.landmarks; ++i) {
    std::array<double, 3> position{};
    int tries = 0;
    do {
      if (++tries > kPlacementTries) {
        throw Error(
            fmt::format("[world] only {} of {} landmarks fit into the box: make it larger "
                        "or min_spacing smaller",
                        i, world.landmarks));
      }
      for (std::size_t axis = 0; axis < 3; ++axis) {
        position[axis] = quantised(random.uniform(world.min_corner[axis], world.max_corner[axis]));
      }
    } while (too_near(position));
    landmarks.push_back({i, position, static_cast<std::size_t>(i) % world.classes.size()});
  }
  return landmarks;
}

/// Whether the wheels slip, and which share of the measured motion is real.
struct SlipState {
  bool on = false;
  double share = 1;

  void advance(const Scenario::Slip& slip, Random& random) {
    if (slip.start == 0) return;
    const bool before = on;
    on = random.uniform() < (on ? slip.stay : slip.start);
    if (on && !before) share = random.uniform(slip.min_share, slip.max_share);
    if (!on) share = 1;
  }
};

/// The motion as measured by wheels without noise; in 2-D with their systematic errors.
mrpt::poses::CPose3D by_wheels(mrpt::poses::CPose3D motion, const Scenario& scenario,
                               const SlipState& slip) {
  const auto& o = scenario.odometry;
  const double scale = 1 / (slip.share * o.scale_translation);
  if (scale != 1)
    motion.setFromValues(scale * motion.x(), scale * motion.y(), scale * motion.z(), motion.yaw(),
                         motion.pitch(), motion.roll());
  if (o.scale_rotation == 1 && o.drift == 0) return motion;
  const double turn = (motion.yaw() - o.drift * motion.norm()) / o.scale_rotation;
  return {motion.x(), motion.y(), 0, turn, 0, 0};
}

std::array<double, 6> noisy_motion(const mrpt::poses::CPose3D& true_motion,
                                   const Scenario& scenario, const SlipState& slip,
                                   Random& random) {
  const auto& o = scenario.odometry;
  const mrpt::poses::CPose3D motion = by_wheels(true_motion, scenario, slip);
  const auto noisy = [&](double value, double sigma) {
    return quantised(value + random.normal(sigma));
  };
  std::array<double, 6> measured{};
  measured[0] = noisy(motion.x(), o.sigma_translation);
  measured[1] = noisy(motion.y(), o.sigma_translation);
  measured[3] = noisy(motion.yaw(), o.sigma_yaw);
  if (scenario.is_3d) {
    measured[2] = noisy(motion.z(), o.sigma_translation);
    measured[4] = noisy(motion.pitch(), o.sigma_tilt);
    measured[5] = noisy(motion.roll(), o.sigma_tilt);
  }
  if (slip.on) measured[3] = noisy(measured[3], scenario.slip.sigma_yaw);
  return measured;
}

bool in_view(double range, double yaw, double pitch, const Scenario& scenario) {
  const auto& s = scenario.sensor;
  return range >= s.min_range && range <= s.max_range && std::abs(yaw) <= s.fov_yaw / 2 &&
         (!scenario.is_3d || std::abs(pitch) <= s.fov_pitch / 2);
}

/// Where another robot is, between two of its poses; nothing where its path has ended.
std::optional<mrpt::math::TPoint3D> place_of(const Scenario::Other& other, double time) {
  const double at = time / other.period;
  const auto i = static_cast<std::size_t>(at);
  if (i >= other.path.size() || (i + 1 == other.path.size() && at > static_cast<double>(i))) {
    return std::nullopt;
  }
  const auto a = other.path[i].translation();
  if (i + 1 == other.path.size()) return a;
  return a + (other.path[i + 1].translation() - a) * (at - static_cast<double>(i));
}

std::vector<SimulatedDetection> detect(const mrpt::poses::CPose3D& T_map_sensor, double time,
                                       const Simulation& world, std::size_t frame,
                                       const Scenario& scenario, Random& random) {
  const auto& s = scenario.sensor;
  std::vector<SimulatedDetection> detections;
  const auto see = [&](const mrpt::math::TPoint3D& p, const std::vector<double>& reported) {
    double range = 0, yaw = 0, pitch = 0;
    T_map_sensor.sphericalCoordinates(p, range, yaw, pitch);
    if (!in_view(range, yaw, pitch, scenario)) return false;
    if (random.uniform() >= s.detection_probability) return false;
    SimulatedDetection d;
    d.range = std::max(1e-3, range + random.normal(s.sigma_range));
    d.yaw = yaw + random.normal(s.sigma_yaw);
    d.pitch = scenario.is_3d ? pitch + random.normal(s.sigma_pitch) : 0;
    d.reported_class = random.index(reported);
    detections.push_back(d);
    return true;
  };
  const std::vector<double> any(s.confusion.size(), 1.0);
  for (const SimulatedLandmark& landmark : world.landmarks) {
    const auto& p = landmark.position;
    if (see({p[0], p[1], p[2]}, s.confusion[landmark.class_index])) {
      detections.back().true_id = landmark.id;
    }
  }
  for (const SimulatedMover& mover : world.movers) {
    const auto& p = mover.path[frame];
    if (see({p[0], p[1], p[2]}, s.confusion[mover.class_index])) {
      detections.back().true_id = mover.id;
      detections.back().moves = true;
    }
  }
  for (const Scenario::Other& other : scenario.others) {
    const auto place = place_of(other, time);
    if (place && see(*place, any)) detections.back().robot = other.id;
  }
  for (int i = random.poisson(s.spurious_per_frame); i > 0; --i) {
    SimulatedDetection d;
    d.range = random.uniform(s.min_range, s.max_range);
    d.yaw = random.uniform(-s.fov_yaw / 2, s.fov_yaw / 2);
    d.pitch = scenario.is_3d ? random.uniform(-s.fov_pitch / 2, s.fov_pitch / 2) : 0;
    d.reported_class = random.index(any);
    detections.push_back(d);
  }
  for (SimulatedDetection& d : detections) {
    d.range = quantised(d.range);
    d.yaw = quantised(d.yaw);
    d.pitch = quantised(d.pitch);
  }
  // An order without information about the landmarks.
  std::stable_sort(detections.begin(), detections.end(),
                   [](const auto& a, const auto& b) { return a.yaw < b.yaw; });
  return detections;
}

}  // namespace

Simulation simulate(const Scenario& scenario) {
  Random random(scenario.seed);
  Simulation simulation;
  if (scenario.world_seed == scenario.seed) {
    simulation.landmarks = place_landmarks(scenario.world, random);
  } else {
    Random places(scenario.world_seed);
    simulation.landmarks = place_landmarks(scenario.world, places);
  }
  simulation.path = robot_path(scenario.path, scenario.is_3d);
  simulation.movers = draw_movers(scenario, simulation.path.size(), random);
  SlipState slip;
  Random rays(~scenario.seed);  // its own, so that a laser changes nothing else
  for (std::size_t i = 0; i < simulation.path.size(); ++i) {
    SimulatedFrame frame;
    if (i > 0) {
      slip.advance(scenario.slip, random);
      frame.slips = slip.on;
      frame.motion =
          noisy_motion(simulation.path[i] - simulation.path[i - 1], scenario, slip, random);
    }
    if (scenario.has_detector()) {
      frame.detections =
          detect(simulation.path[i] + scenario.sensor.pose,
                 static_cast<double>(i) * scenario.path.period, simulation, i, scenario, random);
    }
    frame.scan = simulated_scan(scenario.laser, simulation.path[i] + scenario.laser.pose,
                                simulation.movers, i, rays);
    simulation.frames.push_back(std::move(frame));
  }
  simulation.fixes = draw_fixes(scenario, simulation.path);
  return simulation;
}

std::vector<float> class_scores(const std::vector<std::vector<double>>& confusion,
                                std::size_t reported_class) {
  double sum = 0;
  for (const auto& row : confusion) sum += row[reported_class];
  std::vector<float> scores;
  for (const auto& row : confusion) {
    scores.push_back(static_cast<float>(row[reported_class] / sum));
  }
  return scores;
}

}  // namespace hybrid
