// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "mrpt_plugins/simulation/moving_things.h"
#include "mrpt_plugins/simulation/receiver.h"
#include "mrpt_plugins/simulation/scenario.h"

namespace HYBRID_API hybrid {

struct SimulatedLandmark {
  std::int64_t id = 0;
  std::array<double, 3> position{};
  std::size_t class_index = 0;
};

struct SimulatedDetection {
  double range = 0, yaw = 0, pitch = 0;
  std::int64_t true_id = -1;  ///< -1: spurious.
  bool moves = false;         ///< true_id is that of a mover, which no sensor tells
  std::int32_t robot = -1;    ///< id of the robot that it is, else -1
  std::size_t reported_class = 0;
};

/// Odometry and detections of one pose of the path. `motion` is the noisy motion from the last
/// pose, (x y z yaw pitch roll).
struct SimulatedFrame {
  std::array<double, 6> motion{};
  bool slips = false;                          ///< whether the wheels slipped during the motion
  std::vector<SimulatedDetection> detections;  ///< In order of yaw.
  std::vector<float> scan;                     ///< of the laser; 0 where a ray has no return [m]
};

struct Simulation {
  std::vector<SimulatedLandmark> landmarks;
  std::vector<SimulatedMover> movers;
  std::vector<mrpt::poses::CPose3D> path;
  std::vector<SimulatedFrame> frames;
  std::vector<SimulatedFix> fixes;  ///< in order of their stamps
};

/// Draws world, odometry and detections; throws Error if the landmarks do not fit their box.
Simulation simulate(const Scenario& scenario);

/// The probability of each true class given the reported one, with equal priors: the column of the
/// confusion matrix, normalised.
std::vector<float> class_scores(const std::vector<std::vector<double>>& confusion,
                                std::size_t reported_class);

/// Writes F.rawlog (`log_path`), F_ground_truth.txt, F_ground_truth_robot_path.txt and, if wheels
/// may slip, F_ground_truth_modes.txt, if things move, F_ground_truth_movers.csv, and with a
/// receiver F_ground_truth_fixes.csv; all appear together. Returns the paths. Throws Error naming
/// the file that fails.
std::vector<std::string> write_simulation(const Simulation& simulation, const Scenario& scenario,
                                          const std::string& log_path);

}  // namespace hybrid
