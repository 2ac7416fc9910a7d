// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/simulation/robot_path.h"

namespace HYBRID_API hybrid {

/// A scenario to simulate. Lengths in metres, angles in radians, times in seconds.
struct Scenario {
  std::uint64_t seed = 1;        ///< of noise
  std::uint64_t world_seed = 1;  ///< of the places of the landmarks
  bool is_3d = false;
  bool pairs = true;    ///< Format: actions and sensory frames, or observations only.
  bool classed = true;  ///< CObservationClassedBearingRange, or MRPT's CObservationBearingRange.

  struct World {
    int landmarks = 0;
    std::vector<std::string> classes;
    std::array<double, 3> min_corner{}, max_corner{};
    double min_spacing = 0;
  } world;

  DrivenPath path;

  struct Odometry {
    double sigma_translation = 0, sigma_yaw = 0, sigma_tilt = 0;
    /// Systematic errors of the wheels: the motion is scale_translation and scale_rotation times
    /// the measured one, plus drift [rad] per measured metre (in 2-D only).
    double scale_translation = 1, scale_rotation = 1, drift = 0;
  } odometry;

  /// Slip of the wheels: only a share of the measured motion is real.
  struct Slip {
    double start = 0;  ///< probability per frame; 0: never
    double stay = 0;   ///< probability per frame that slip continues
    double min_share = 1, max_share = 1;
    double sigma_yaw = 0;
  } slip;

  /// Things that move among the landmarks.
  struct Movers {
    int count = 0;
    double speed = 0;         ///< at first, in a random direction [m/s]
    double acceleration = 0;  ///< by which each component changes within a second [m/s]
  } movers;

  struct Sensor {
    mrpt::poses::CPose3D pose;
    double min_range = 0, max_range = 0, fov_yaw = 0, fov_pitch = 0;
    double sigma_range = 0, sigma_yaw = 0, sigma_pitch = 0;
    double detection_probability = 1, spurious_per_frame = 0;
    bool known_ids = true, true_ids = true;
    /// Row: true class; column: reported class; rows sum to 1.
    std::vector<std::vector<double>> confusion;
  } sensor;

  /// A straight wall from x y to x y [m].
  using Wall = std::array<double, 4>;

  /// A planar laser in a floor plan; none where it has no rays.
  struct Laser {
    int rays = 0;
    mrpt::poses::CPose3D pose;
    double fov = 0, max_range = 0, sigma_range = 0;
    std::vector<Wall> walls, glass;
    double glass_seen = 0;     ///< probability that a ray returns from glass
    double person_radius = 0;  ///< of things that move, which are discs [m]
  } laser;

  /// What happens now and then, and lasts a while: never where `every` is 0.
  struct Spells {
    double every = 0;  ///< mean time from the end of one to the next
    double shortest = 0, longest = 0;
  };

  /// A receiver of satellites on the robot; none where the period is 0.
  struct Fixes {
    double period = 0, delay = 0;  ///< of the stamps
    GeodeticPoint datum;           ///< of the world, whose x is east
    std::array<double, 3> antenna{};
    double sigma = 0;                     ///< of a single fix, along each axis
    double lasting_sigma = 0, lasts = 0;  ///< of what fixes have in common, and how long
    Spells biased;                        ///< runs with a bias besides
    double min_bias = 0, max_bias = 0, bias_walk = 0;
    double false_share = 0, false_reach = 0;
    Spells outages;
    int stated_quality = 1;  ///< as GGA numbers it
    double stated_sigma = 0;
  } fixes;

  /// Another robot in the same world, which the sensor names by an id.
  struct Other {
    std::int32_t id = 0;
    double period = 0;  ///< between its poses [s]
    std::vector<mrpt::poses::CPose3D> path;
  };
  std::vector<Other> others;

  /// Whether the robot looks for landmarks: it does not where there are none and a laser is.
  bool has_detector() const { return world.landmarks > 0 || laser.rays == 0; }
};

/// A robot of a world with several, by the name of its section [robot.NAME].
struct NamedScenario {
  std::string name;
  Scenario scenario;
};

/// Declares and reads all keys; throws Error naming file, section and key. Call
/// IniFile::reject_unknown() afterwards.
Scenario read_scenario(IniFile& ini);

/// The robots that sections [robot.NAME] describe, in one world, where they see each other: `id` is
/// that by which the others know one, and SECTION.KEY any value of its own. `fresh` opens the INI
/// anew. Empty where there is no such section. Throws Error as read_scenario does.
std::vector<NamedScenario> read_robots(IniFile& ini,
                                       const std::function<std::unique_ptr<IniFile>()>& fresh);

}  // namespace hybrid
