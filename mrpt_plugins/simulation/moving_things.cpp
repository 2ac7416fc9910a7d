// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/moving_things.h"

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

/// One coordinate of a position and of a velocity, a time step later.
void advance(double low, double high, double dt, double& at, double& velocity) {
  at += velocity * dt;
  if (at < low || at > high) velocity = -velocity;
  at = std::clamp(at, low, high);
}

}  // namespace

std::vector<SimulatedMover> draw_movers(const Scenario& scenario, std::size_t frames,
                                        Random& random) {
  const Scenario::World& world = scenario.world;
  const double dt = scenario.path.period;
  std::vector<SimulatedMover> movers;
  for (int m = 0; m < scenario.movers.count; ++m) {
    SimulatedMover mover;
    mover.id = world.landmarks + m;
    mover.class_index = static_cast<std::size_t>(m) % world.classes.size();
    std::array<double, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      at[axis] = random.uniform(world.min_corner[axis], world.max_corner[axis]);
    }
    const double heading = random.uniform(-M_PI, M_PI);
    std::array<double, 2> velocity{scenario.movers.speed * std::cos(heading),
                                   scenario.movers.speed * std::sin(heading)};
    for (std::size_t i = 0; i < frames; ++i) {
      mover.path.push_back({quantised(at[0]), quantised(at[1]), quantised(at[2])});
      for (std::size_t axis = 0; axis < 2; ++axis) {
        velocity[axis] += random.normal(scenario.movers.acceleration * std::sqrt(dt));
        advance(world.min_corner[axis], world.max_corner[axis], dt, at[axis], velocity[axis]);
      }
    }
    movers.push_back(std::move(mover));
  }
  return movers;
}

}  // namespace hybrid
