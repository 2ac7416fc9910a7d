// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/known_place.h"
#include "libhybrid/landmarks/known_map.h"
#include "libhybrid/maps/sparse_gaussian.h"

namespace HYBRID_API hybrid {

/// A landmark of a stored map; `covariance` is that of its position alone.
struct MapLandmark : KnownLandmark {
  int session = 0;  ///< that made it
};

/// A landmark of a session that is not complete.
struct DraftLandmark {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  std::optional<int> class_index;
  int sightings = 0;
};

/// A keyframe of a stored map.
struct MapKeyframe {
  std::size_t row = 0;    ///< step of the log
  double time = 0;        ///< [s]
  std::size_t robot = 0;  ///< in MapSession::robots
  Eigen::Isometry3d T_map_robot = Eigen::Isometry3d::Identity();
};

/// One run over one log, or over those of several robots.
struct MapSession {
  int id = 0;
  std::string mode;           ///< build, extend, localize or join
  bool complete = false;      ///< else the log was not mapped to its end
  std::string version;        ///< of the program
  std::string command;        ///< its name and arguments
  std::string configuration;  ///< settings in effect, JSON
  /// Files and their SHA-256, of logs that of what they hold decompressed.
  std::vector<std::pair<std::string, std::string>> inputs;
  std::vector<std::string> logs;       ///< the SHA-256 of those inputs that are logs
  std::vector<double> class_prior;     ///< of landmarks that it made; empty: all classes alike
  std::vector<std::string> robots;     ///< their names; empty where there is but one without a name
  std::vector<MapKeyframe> keyframes;  ///< of all robots, in the order of time
};

/// A piece of a surface that laser scans saw.
struct MapSurface {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< in the frame of its local map [m]
  std::optional<double> direction = {};  ///< of its normal there [rad]; nothing where not known
};

/// What the scans of a stretch of a session saw, in the frame of its first keyframe.
struct MapLocalMap {
  int session = 0;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();        ///< x, y [m] and angle [rad] in the map
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of that, in its tangent
  std::optional<PlaceParent<SE2>> parent = {};
  std::vector<MapSurface> surfaces;
};

/// A place on a surface that clouds of points saw.
struct MapCloudPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< in the frame of its local cloud [m]
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();    ///< unit; zero where it is not known
};

/// What the clouds of a stretch of a session saw, in the frame of its first keyframe.
struct MapLocalCloud {
  int session = 0;
  KnownPlace<SE3> T_map_anchor;
  double spacing = 0;  ///< between the points [m]
  std::vector<MapCloudPoint> points;
};

/// The place of a map on the globe.
struct MapOrigin {
  double latitude = 0, longitude = 0;  ///< of its origin, WGS 84 [deg]
  double direction = 0;                ///< of its x axis, counter-clockwise from east [deg]
  double altitude = 0;                 ///< above the ellipsoid [m]
  bool by_fixes = false;  ///< so that what the map says of its places holds on earth too

  bool operator==(const MapOrigin& o) const {
    return latitude == o.latitude && longitude == o.longitude && direction == o.direction &&
           altitude == o.altitude && by_fixes == o.by_fixes;
  }
};

/// Latitude, longitude and direction as stated by hand; nothing for no numbers.
std::optional<MapOrigin> stated_origin(const std::vector<double>& numbers);

/// All that a map file holds.
struct MapRecord {
  bool is_3d = false;
  bool identified = false;  ///< the ids of the landmarks are those of the log
  std::vector<std::string> class_names;
  std::optional<MapOrigin> origin;     ///< nothing where not known
  std::vector<MapLandmark> landmarks;  ///< by ascending id
  SparseGaussian prior;                ///< of their positions, in this order
  std::vector<MapSession> sessions;
  std::vector<MapLocalMap> local_maps;      ///< by ascending session
  std::vector<MapLocalCloud> local_clouds;  ///< by ascending session

  int dim() const { return is_3d ? 3 : 2; }
};

/// Whether a landmark is more likely there than not.
inline bool exists(const MapLandmark& landmark) {
  return landmark.existence > 0;
}

/// Whether there is anything in a map that a robot can find its place by.
inline bool holds_places(const MapRecord& map) {
  return !map.landmarks.empty() || !map.local_maps.empty() || !map.local_clouds.empty();
}

/// Joint covariance of all landmarks, dim rows for each.
inline Eigen::MatrixXd joint_covariance(const MapRecord& map) {
  return map.prior.covariance();
}

/// Removes the local maps of a session. Those that are known beside one of them are known beside
/// none any more.
void forget_local_maps(MapRecord& map, int session);

/// The landmarks as what is known before the first keyframe of a session.
KnownMap known_map(const MapRecord& map);

}  // namespace hybrid
