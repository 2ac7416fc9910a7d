// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/settings/map_options.h"

#include <cmath>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {

namespace {

StartOptions read_start(IniSection& map) {
  StartOptions o;
  std::vector<double>& pose = o.pose;
  map.read("start", pose,
           "pose of the first keyframe in the map, x y yaw or x y z yaw pitch roll [m, deg]; "
           "empty: found by landmarks or laser scans",
           kCoordinate);
  for (std::size_t i = pose.size() / 2 + pose.size() % 2; i < pose.size(); ++i) {
    pose[i] *= M_PI / 180;
  }
  if (!pose.empty() && pose.size() != 3 && pose.size() != 6) {
    map.fail("start", "needs three numbers, or six in space");
  }
  o.sigma_m =
      map.get("start_sigma_m", 1.0, "standard deviation of that position [m]", kSigmaMetres);
  o.sigma_rad = map.degrees("start_sigma_deg", 10.0, "and of that orientation", kSigmaDegrees);
  return o;
}

}  // namespace

MapOptions read_map_options(IniFile& ini, const ReplayRequest& request) {
  MapOptions o;
  IniSection map = ini.section("map");
  o.file = map.path("file", "", "the map file to make or go on with, .hmap; empty: none");
  if (!request.map.empty()) o.file = request.map;
  o.mode = map.choice("mode", "auto", {"auto", "build", "extend", "localize"},
                      "what a log does to the map file: build a new one; extend the one there is; "
                      "localize in it and leave it as it is; auto: extend where there is one");
  if (!request.map_mode.empty()) o.mode = request.map_mode;
  map.read("commit_every", o.commit_every, "keyframes between two writes to the map file",
           {1, 1e6});
  map.read("localize_odds", o.odds,
           "evidence that a place in the map needs, against chance and against any other",
           {1, 1e12});
  o.start = read_start(map);
  const std::vector<double> origin =
      map.get("origin", std::vector<double>(),
              "latitude and longitude of the origin of the map and direction of its x axis "
              "[deg, counter-clockwise from east], for GeoJSON; empty: as fixes tell, if "
              "they do",
              kTurn);
  if (!origin.empty() &&
      (origin.size() != 3 || std::abs(origin[0]) > 90 || std::abs(origin[1]) > 180)) {
    map.fail("origin", "needs latitude, longitude and direction in degrees");
  }
  o.origin = stated_origin(origin);
  return o;
}

std::optional<KnownStart> given_start(const StartOptions& options, bool is_3d) {
  const std::vector<double>& s = options.pose;
  if (s.empty()) return std::nullopt;
  const bool planar = s.size() == 3;
  const mrpt::poses::CPose3D pose(s[0], s[1], planar ? 0 : s[2], planar ? s[2] : s[3],
                                  planar ? 0 : s[4], planar ? 0 : s[5]);
  const int n = is_3d ? 6 : 3, position = is_3d ? 3 : 2;
  Eigen::VectorXd variances(n);
  variances.head(position).setConstant(options.sigma_m * options.sigma_m);
  variances.tail(n - position).setConstant(options.sigma_rad * options.sigma_rad);
  return KnownStart{to_isometry(pose), variances.asDiagonal()};
}

}  // namespace hybrid
