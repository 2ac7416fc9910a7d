// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/detail/map_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/maps/map_faults.h"
#include "mrpt_plugins/bridge/robot_sections.h"
#include "mrpt_plugins/map_file/detail/map_cells.h"
#include "mrpt_plugins/map_file/detail/map_database.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

namespace hybrid {
namespace {

using SQLite::Database;

constexpr std::int64_t kLastLandmark = (std::int64_t{1} << 56) - 1;  // what a Key holds
constexpr int kMostClasses = 10000;  // some half of those of the largest set of labelled pictures
constexpr double kMostLoss = 1e6;    // [nat], where a prior says nothing any more
constexpr std::int64_t kMostSurfaces = 100000;  // of a local map, ten centimetres apart
constexpr std::int64_t kFarthest = 100000;      // [mm], what a local map reaches
constexpr std::int64_t kHalfTurn = 3142;        // [mrad]
constexpr double kMostAltitude = 1e7;           // [m]
constexpr double kMostTurn = 1e6;               // [deg], beyond which angles are not angles

std::int64_t number(std::size_t n) {
  return static_cast<std::int64_t>(n);
}

MapCells property(Database& database, const std::string& name) {
  return {database, "map", fmt::format("SELECT value AS {0} FROM map WHERE name = '{0}'", name)};
}

std::int64_t read_whole(Database& database, const char* name, int least, int most) {
  MapCells row = property(database, name);
  if (!row.next()) throw Error(fmt::format("does not say its '{}'", name));
  return row.whole(0, least, most);
}

std::optional<double> read_number(Database& database, const char* name, double least, double most) {
  MapCells row = property(database, name);
  if (!row.next()) return std::nullopt;
  const double value = row.real(0);
  if (value >= least && value <= most) return value;
  throw Error(fmt::format("its {} is {:g}, not from {:g} to {:g}", name, value, least, most));
}

/// Which robots a session was of: their names become those of files.
std::string robot_name(const MapSession& session, const std::string& name) {
  if (!is_robot_name(name)) {
    throw Error(fmt::format("session {}: {} is no name of a robot", session.id, escaped(name)));
  }
  if (std::find(session.robots.begin(), session.robots.end(), name) != session.robots.end()) {
    throw Error(fmt::format("session {} has two robots named {}", session.id, name));
  }
  return name;
}

/// The numbers of a list in an INI.
std::vector<double> numbers_in(const std::string& text) {
  std::istringstream words(text);
  std::vector<double> out;
  for (double x = 0; words >> x;) out.push_back(x);
  return out;
}

/// What the settings in effect say of a session: which of its files are logs, and the prior of
/// classes. Those that are not of the form that programs write say nothing.
void read_settings(MapSession& session) {
  const auto settings = nlohmann::json::parse(session.configuration, nullptr, false);
  if (!settings.is_object()) return;
  std::set<std::string> logs;
  for (const auto& [section, keys] : settings.items()) {
    if (!keys.is_object()) continue;
    for (const auto& [key, value] : keys.items()) {
      if (!value.is_string()) continue;
      const auto text = value.template get<std::string>();
      if (key == "rawlog") logs.insert(std::filesystem::path(text).filename().string());
      if (key == "class_prior" && !text.empty()) session.class_prior = numbers_in(text);
    }
  }
  double sum = 0;
  for (const double p : session.class_prior) sum += p;
  for (double& p : session.class_prior) p /= sum;
  const bool sound = std::all_of(session.class_prior.begin(), session.class_prior.end(),
                                 [](double p) { return p >= 0 && p <= 1; });
  if (!sound) session.class_prior.clear();
  for (const auto& [path, sha256] : session.inputs) {
    if (logs.count(std::filesystem::path(path).filename().string()) > 0) {
      session.logs.push_back(sha256);
    }
  }
}

void read_keyframe(MapCells& row, MapSession& session) {
  MapKeyframe k;
  if (row.whole(1) != number(session.keyframes.size())) {
    throw Error(fmt::format("session {} lacks keyframe {}", session.id, session.keyframes.size()));
  }
  k.row = static_cast<std::size_t>(row.whole(2, 0, std::numeric_limits<std::int64_t>::max()));
  k.time = row.real(3);
  const Eigen::Quaterniond q(row.real(10), row.real(7), row.real(8), row.real(9));
  if (!(std::abs(q.norm() - 1) < 1e-6)) {
    throw Error(fmt::format("keyframe {} of session {} has no orientation",
                            session.keyframes.size(), session.id));
  }
  k.T_map_robot = Eigen::Translation3d(row.real(4), row.real(5), row.real(6)) * q.normalized();
  const std::int64_t robot = row.whole(11);
  if (robot >= std::max<std::int64_t>(1, number(session.robots.size()))) {
    throw Error(fmt::format("keyframe {} of session {} is of a robot {} that is not there",
                            session.keyframes.size(), session.id, robot));
  }
  k.robot = static_cast<std::size_t>(robot);
  session.keyframes.push_back(k);
}

void read_sessions(Database& database, MapRecord& out) {
  std::map<int, std::size_t> place;
  MapCells sessions(database, "session",
                    "SELECT id, mode, complete, version, command, configuration FROM session "
                    "ORDER BY id");
  while (sessions.next()) {
    MapSession s;
    s.id = static_cast<int>(sessions.whole(0, 1));
    s.mode = sessions.text(1);
    s.complete = sessions.whole(2, 0, 1) != 0;
    s.version = sessions.text(3);
    s.command = sessions.text(4);
    s.configuration = sessions.text(5);
    place[s.id] = out.sessions.size();
    out.sessions.push_back(std::move(s));
  }
  const auto session_of = [&](MapCells& row) -> MapSession& {
    const int id = row.count(0);
    const auto it = place.find(id);
    if (it == place.end()) throw Error(fmt::format("rows of a session {} that is not there", id));
    return out.sessions[it->second];
  };
  MapCells inputs(database, "input",
                  "SELECT session, path, sha256 FROM input ORDER BY session, number");
  while (inputs.next()) session_of(inputs).inputs.emplace_back(inputs.text(1), inputs.text(2));
  for (MapSession& session : out.sessions) read_settings(session);
  const bool knows_robots = pragma(database, "user_version") > 1;
  if (knows_robots) {
    MapCells robots(database, "robot",
                    "SELECT session, number, name FROM robot ORDER BY session, number");
    while (robots.next()) {
      MapSession& session = session_of(robots);
      if (robots.whole(1) != number(session.robots.size())) {
        throw Error(fmt::format("session {} lacks robot {}", session.id, session.robots.size()));
      }
      session.robots.push_back(robot_name(session, robots.text(2)));
    }
  }
  MapCells keyframes(database, "keyframe",
                     fmt::format("SELECT session, number, row, time, x, y, z, qx, qy, qz, qw, {} "
                                 "FROM keyframe ORDER BY session, number",
                                 knows_robots ? "robot" : "0"));
  while (keyframes.next()) read_keyframe(keyframes, session_of(keyframes));
}

std::map<std::int64_t, std::size_t> read_landmarks(Database& database, MapRecord& out) {
  std::map<std::int64_t, std::size_t> place;
  MapCells rows(database, "landmark",
                "SELECT id, session, x, y, z, xx, xy, xz, yy, yz, zz, existence, sightings "
                "FROM landmark ORDER BY id");
  while (rows.next()) {
    MapLandmark l;
    l.id = rows.whole(0, 0, kLastLandmark);
    l.session = rows.count(1);
    l.position = Eigen::Vector3d{rows.real(2), rows.real(3), rows.real(4)};
    const double xx = rows.real(5), xy = rows.real(6), xz = rows.real(7), yy = rows.real(8),
                 yz = rows.real(9), zz = rows.real(10);
    l.covariance << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    l.existence = rows.real(11);
    l.sightings = rows.count(12);
    const bool known = std::any_of(out.sessions.begin(), out.sessions.end(),
                                   [&](const MapSession& s) { return s.id == l.session; });
    if (!known) {
      throw Error(fmt::format("landmark {} is of a session {} that is not there", l.id, l.session));
    }
    place[l.id] = out.landmarks.size();
    out.landmarks.push_back(std::move(l));
  }
  return place;
}

std::size_t landmark_at(const std::map<std::int64_t, std::size_t>& place, std::int64_t id) {
  const auto it = place.find(id);
  if (it == place.end()) throw Error(fmt::format("rows of a landmark {} that is not there", id));
  return it->second;
}

void read_classes(Database& database, const std::map<std::int64_t, std::size_t>& place,
                  MapRecord& out) {
  MapCells names(database, "class", "SELECT number, name FROM class ORDER BY number");
  while (names.next()) {
    if (names.whole(0, 0, kMostClasses - 1) != number(out.class_names.size())) {
      throw Error(fmt::format("class {} has no name", out.class_names.size()));
    }
    out.class_names.push_back(names.text(1));
  }
  MapCells rows(database, "landmark_class",
                "SELECT landmark, class, probability FROM landmark_class ORDER BY landmark, class");
  while (rows.next()) {
    MapLandmark& l = out.landmarks[landmark_at(place, rows.whole(0, 0, kLastLandmark))];
    const std::int64_t c = rows.whole(1);
    const double p = rows.real(2);
    if (c != number(l.class_probabilities.size()) || c >= number(out.class_names.size())) {
      throw Error(fmt::format("landmark {} has class probabilities that make no sense", l.id));
    }
    l.class_probabilities.push_back(p);
  }
  for (const MapLandmark& l : out.landmarks) {
    if (!l.class_probabilities.empty() && l.class_probabilities.size() != out.class_names.size()) {
      throw Error(fmt::format("landmark {} lacks the probability of a class", l.id));
    }
  }
}

void read_prior(Database& database, const std::map<std::int64_t, std::size_t>& place,
                MapRecord& out) {
  const int dim = out.dim();
  out.prior.dim = dim;
  out.prior.rows.resize(out.landmarks.size());
  MapCells rows(database, "prior",
                "SELECT landmark, number, given, r11, r12, r13, r21, r22, r23, r31, r32, r33 "
                "FROM prior ORDER BY landmark, number");
  while (rows.next()) {
    const std::size_t i = landmark_at(place, rows.whole(0, 0, kLastLandmark));
    const std::size_t given = landmark_at(place, rows.whole(2, 0, kLastLandmark));
    SparseRow& row = out.prior.rows[i];
    const std::size_t k = row.variables.size();
    if (rows.whole(1) != number(k) || (k == 0 ? given != i : given >= i)) {
      throw Error(fmt::format("the prior of landmark {} is not of its form", out.landmarks[i].id));
    }
    row.variables.push_back(static_cast<int>(given));
    row.R.conservativeResize(dim, dim * static_cast<Eigen::Index>(k + 1));
    for (int a = 0; a < dim; ++a) {
      for (int b = 0; b < dim; ++b) {
        row.R(a, dim * static_cast<Eigen::Index>(k) + b) = rows.real(3 + 3 * a + b);
      }
    }
  }
  for (std::size_t i = 0; i < out.prior.rows.size(); ++i) {
    const SparseRow& row = out.prior.rows[i];
    if (row.variables.empty() || !(row.R.leftCols(dim).diagonal().minCoeff() > 0)) {
      throw Error(fmt::format("landmark {} has no prior", out.landmarks[i].id));
    }
  }
}

void read_sizes(Database& database, const std::map<std::int64_t, std::size_t>& place,
                MapRecord& out) {
  if (pragma(database, "user_version") < map_schema::kFirstWithSizes) return;
  MapCells rows(database, "landmark_size",
                "SELECT landmark, extent, things FROM landmark_size ORDER BY landmark");
  while (rows.next()) {
    MapLandmark& l = out.landmarks[landmark_at(place, rows.whole(0, 0, kLastLandmark))];
    l.size.extent = rows.real(1);
    l.size.things = rows.count(2);
  }
}

/// Local maps and their surfaces: lengths are in millimetres, directions in milliradians.
void read_local_maps(Database& database, MapRecord& out) {
  if (pragma(database, "user_version") < map_schema::kFirstWithScans) return;
  std::map<std::pair<int, std::int64_t>, std::size_t> place;
  std::map<int, std::int64_t> count;  // by session
  for (const MapSession& session : out.sessions) count[session.id] = 0;
  MapCells maps(database, "local_map",
                "SELECT session, number, x, y, angle, xx, xy, xa, yy, ya, aa "
                "FROM local_map "
                "ORDER BY session, number");
  while (maps.next()) {
    MapLocalMap map;
    map.session = maps.count(0);
    const auto next = count.find(map.session);
    if (next == count.end() || maps.whole(1) != next->second) {
      throw Error(fmt::format("local maps of session {} are not of their form", map.session));
    }
    place[{map.session, next->second++}] = out.local_maps.size();
    map.pose = Eigen::Vector3d{maps.real(2), maps.real(3), maps.real(4)};
    const double xx = maps.real(5), xy = maps.real(6), xa = maps.real(7), yy = maps.real(8),
                 ya = maps.real(9), aa = maps.real(10);
    map.covariance << xx, xy, xa, xy, yy, ya, xa, ya, aa;
    out.local_maps.push_back(std::move(map));
  }
  MapCells rows(database, "surface",
                "SELECT session, map, number, x, y, direction FROM surface "
                "ORDER BY session, map, number");
  while (rows.next()) {
    const auto of = place.find({rows.count(0), rows.whole(1)});
    if (of == place.end()) throw Error("rows of a local map that is not there");
    std::vector<MapSurface>& surfaces = out.local_maps[of->second].surfaces;
    if (rows.whole(2, 0, kMostSurfaces - 1) != number(surfaces.size())) {
      throw Error(fmt::format("a local map of session {} lacks surface {}", rows.count(0),
                              surfaces.size()));
    }
    MapSurface surface;
    surface.position = Eigen::Vector2d{1e-3 * double(rows.whole(3, -kFarthest, kFarthest)),
                                       1e-3 * double(rows.whole(4, -kFarthest, kFarthest))};
    if (!rows.is_null(5)) surface.direction = 1e-3 * double(rows.whole(5, -kHalfTurn, kHalfTurn));
    surfaces.push_back(surface);
  }
}

}  // namespace

void refuse_faults(const MapRecord& record) {
  const std::vector<std::string> faults = faults_of(record);
  if (faults.empty()) return;
  throw Error("is no sound map: " + faults.front() +
              (faults.size() > 1 ? fmt::format(", and {} more", faults.size() - 1) : ""));
}

std::optional<MapOrigin> read_origin(Database& database) {
  const auto latitude = read_number(database, "latitude", -90, 90);
  const auto longitude = read_number(database, "longitude", -180, 180);
  const auto direction = read_number(database, "direction", -kMostTurn, kMostTurn);
  const auto altitude = read_number(database, "altitude", -kMostAltitude, kMostAltitude);
  const auto by_fixes = read_number(database, "by_fixes", 0, 1);
  if (latitude && longitude && direction) {
    return MapOrigin{*latitude, *longitude, *direction, altitude.value_or(0),
                     by_fixes.value_or(0) == 1};
  }
  if (latitude || longitude || direction) throw Error("has a part of an origin only");
  return std::nullopt;
}

MapRecord read_rows(Database& database) {
  MapRecord out;
  out.is_3d = read_whole(database, "dimension", 2, 3) == 3;
  out.identified = read_whole(database, "identified", 0, 1) == 1;
  read_sessions(database, out);
  const auto place = read_landmarks(database, out);
  read_classes(database, place, out);
  read_sizes(database, place, out);
  read_prior(database, place, out);
  read_local_maps(database, out);
  read_local_clouds(database, out);
  read_parents(database, out);
  out.prior.loss = read_number(database, "loss", 0, kMostLoss).value_or(0);
  out.origin = read_origin(database);
  refuse_faults(out);
  check_checksum(database);
  return out;
}

}  // namespace hybrid
