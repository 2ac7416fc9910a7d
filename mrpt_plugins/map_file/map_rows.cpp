// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/map_file/detail/map_rows.h"

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string>
#include <tuple>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

using SQLite::Database;
using SQLite::Statement;

/// Runs one statement with its parameters, to be used again.
template <class... Values>
void run(Statement& statement, const Values&... values) {
  int place = 0;
  (statement.bind(++place, values), ...);
  statement.exec();
  statement.reset();
}

std::int64_t number(std::size_t n) {
  return static_cast<std::int64_t>(n);
}

std::map<std::string, std::string> read_kind(Database& database) {
  std::map<std::string, std::string> kind;
  Statement rows(database, "SELECT name, value FROM map");
  while (rows.executeStep()) kind[rows.getColumn(0).getString()] = rows.getColumn(1).getString();
  return kind;
}

std::optional<double> read_number(Database& database, const std::string& name) {
  Statement row(database, "SELECT value FROM map WHERE name = ?");
  row.bind(1, name);
  return row.executeStep() ? std::make_optional(row.getColumn(0).getDouble()) : std::nullopt;
}

void read_sessions(Database& database, MapRecord& out) {
  std::map<int, std::size_t> place;
  Statement sessions(database,
                     "SELECT id, mode, complete, version, command, configuration FROM session "
                     "ORDER BY id");
  while (sessions.executeStep()) {
    MapSession s;
    s.id = sessions.getColumn(0).getInt();
    s.mode = sessions.getColumn(1).getString();
    s.complete = sessions.getColumn(2).getInt() != 0;
    s.version = sessions.getColumn(3).getString();
    s.command = sessions.getColumn(4).getString();
    s.configuration = sessions.getColumn(5).getString();
    place[s.id] = out.sessions.size();
    out.sessions.push_back(std::move(s));
  }
  const auto session_of = [&](int id) -> MapSession& {
    const auto it = place.find(id);
    if (it == place.end()) throw Error(fmt::format("rows of a session {} that is not there", id));
    return out.sessions[it->second];
  };
  Statement inputs(database, "SELECT session, path, sha256 FROM input ORDER BY session, number");
  while (inputs.executeStep()) {
    session_of(inputs.getColumn(0).getInt())
        .inputs.emplace_back(inputs.getColumn(1).getString(), inputs.getColumn(2).getString());
  }
  const bool knows_robots = database.execAndGet("PRAGMA user_version").getInt() > 1;
  if (knows_robots) {
    Statement robots(database, "SELECT session, number, name FROM robot ORDER BY session, number");
    while (robots.executeStep()) {
      MapSession& session = session_of(robots.getColumn(0).getInt());
      if (robots.getColumn(1).getInt64() != number(session.robots.size())) {
        throw Error(fmt::format("session {} lacks robot {}", session.id, session.robots.size()));
      }
      session.robots.push_back(robots.getColumn(2).getString());
    }
  }
  Statement keyframes(database,
                      fmt::format("SELECT session, number, row, time, x, y, z, qx, qy, qz, qw, {} "
                                  "FROM keyframe ORDER BY session, number",
                                  knows_robots ? "robot" : "0"));
  while (keyframes.executeStep()) {
    const auto real = [&](int column) { return keyframes.getColumn(column).getDouble(); };
    MapSession& session = session_of(keyframes.getColumn(0).getInt());
    MapKeyframe k;
    if (keyframes.getColumn(1).getInt64() != number(session.keyframes.size())) {
      throw Error(
          fmt::format("session {} lacks keyframe {}", session.id, session.keyframes.size()));
    }
    k.row = static_cast<std::size_t>(keyframes.getColumn(2).getInt64());
    k.time = real(3);
    const Eigen::Quaterniond q(real(10), real(7), real(8), real(9));
    if (!(std::abs(q.norm() - 1) < 1e-6)) {
      throw Error(fmt::format("keyframe {} of session {} has no orientation",
                              session.keyframes.size(), session.id));
    }
    k.T_map_robot = Eigen::Translation3d(real(4), real(5), real(6)) * q.normalized();
    const std::int64_t robot = keyframes.getColumn(11).getInt64();
    if (robot < 0 || robot >= std::max<std::int64_t>(1, number(session.robots.size()))) {
      throw Error(fmt::format("keyframe {} of session {} is of a robot {} that is not there",
                              session.keyframes.size(), session.id, robot));
    }
    k.robot = static_cast<std::size_t>(robot);
    session.keyframes.push_back(k);
  }
}

std::map<std::int64_t, std::size_t> read_landmarks(Database& database, MapRecord& out) {
  std::map<std::int64_t, std::size_t> place;
  Statement rows(database,
                 "SELECT id, session, x, y, z, xx, xy, xz, yy, yz, zz, existence, sightings "
                 "FROM landmark ORDER BY id");
  while (rows.executeStep()) {
    const auto real = [&](int column) { return rows.getColumn(column).getDouble(); };
    MapLandmark l;
    l.id = rows.getColumn(0).getInt64();
    l.session = rows.getColumn(1).getInt();
    l.position << real(2), real(3), real(4);
    l.covariance << real(5), real(6), real(7), real(6), real(8), real(9), real(7), real(9),
        real(10);
    l.existence = real(11);
    l.sightings = rows.getColumn(12).getInt();
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
  Statement names(database, "SELECT number, name FROM class ORDER BY number");
  while (names.executeStep()) {
    if (names.getColumn(0).getInt64() != number(out.class_names.size())) {
      throw Error(fmt::format("class {} has no name", out.class_names.size()));
    }
    out.class_names.push_back(names.getColumn(1).getString());
  }
  Statement rows(
      database, "SELECT landmark, class, probability FROM landmark_class ORDER BY landmark, class");
  while (rows.executeStep()) {
    MapLandmark& l = out.landmarks[landmark_at(place, rows.getColumn(0).getInt64())];
    const std::int64_t c = rows.getColumn(1).getInt64();
    const double p = rows.getColumn(2).getDouble();
    if (c != number(l.class_probabilities.size()) || c >= number(out.class_names.size()) ||
        !(p >= 0 && p <= 1)) {
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
  Statement rows(database,
                 "SELECT landmark, number, given, r11, r12, r13, r21, r22, r23, r31, r32, r33 "
                 "FROM prior ORDER BY landmark, number");
  while (rows.executeStep()) {
    const std::size_t i = landmark_at(place, rows.getColumn(0).getInt64());
    const std::size_t given = landmark_at(place, rows.getColumn(2).getInt64());
    SparseRow& row = out.prior.rows[i];
    const std::size_t k = row.variables.size();
    if (rows.getColumn(1).getInt64() != number(k) || (k == 0 ? given != i : given >= i)) {
      throw Error(fmt::format("the prior of landmark {} is not of its form", out.landmarks[i].id));
    }
    row.variables.push_back(static_cast<int>(given));
    row.R.conservativeResize(dim, dim * static_cast<Eigen::Index>(k + 1));
    for (int a = 0; a < dim; ++a) {
      for (int b = 0; b < dim; ++b) {
        row.R(a, dim * static_cast<Eigen::Index>(k) + b) =
            rows.getColumn(3 + 3 * a + b).getDouble();
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

void write_landmark(const MapLandmark& l, Statement& landmark, Statement& classes) {
  const Eigen::Vector3d& p = l.position;
  const Eigen::Matrix3d& C = l.covariance;
  run(landmark, l.id, l.session, p.x(), p.y(), p.z(), C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2),
      C(2, 2), l.existence, l.sightings);
  for (std::size_t c = 0; c < l.class_probabilities.size(); ++c) {
    run(classes, l.id, number(c), l.class_probabilities[c]);
  }
}

void write_prior(const MapRecord& record, Statement& statement) {
  const int dim = record.dim();
  for (std::size_t i = 0; i < record.prior.rows.size(); ++i) {
    const SparseRow& row = record.prior.rows[i];
    for (std::size_t k = 0; k < row.variables.size(); ++k) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      R.topLeftCorner(dim, dim) = row.R.middleCols(dim * static_cast<Eigen::Index>(k), dim);
      const auto given = static_cast<std::size_t>(row.variables[k]);
      run(statement, record.landmarks[i].id, number(k), record.landmarks[given].id, R(0, 0),
          R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2));
    }
  }
}

}  // namespace

MapRecord read_rows(Database& database) {
  MapRecord out;
  const auto kind = read_kind(database);
  const auto get = [&](const char* name) {
    const auto it = kind.find(name);
    if (it == kind.end()) throw Error(fmt::format("does not say its '{}'", name));
    return it->second;
  };
  const std::string dimension = get("dimension");
  if (dimension != "2" && dimension != "3") {
    throw Error(fmt::format("is of dimension '{}', neither 2 nor 3", dimension));
  }
  out.is_3d = dimension == "3";
  out.identified = get("identified") == "1";
  read_sessions(database, out);
  const auto place = read_landmarks(database, out);
  read_classes(database, place, out);
  read_prior(database, place, out);
  out.prior.loss = read_number(database, "loss").value_or(0);
  const auto latitude = read_number(database, "latitude");
  const auto longitude = read_number(database, "longitude");
  const auto direction = read_number(database, "direction");
  if (latitude && longitude && direction) out.origin = {*latitude, *longitude, *direction};
  return out;
}

void write_kind(Database& database, const MapRecord& record) {
  Statement map(database, "INSERT OR REPLACE INTO map VALUES (?, ?)");
  run(map, std::string("dimension"), record.dim());
  run(map, std::string("identified"), record.identified ? 1 : 0);
  run(map, std::string("loss"), record.prior.loss);
  if (record.origin.size() != 3) return;
  run(map, std::string("latitude"), record.origin[0]);
  run(map, std::string("longitude"), record.origin[1]);
  run(map, std::string("direction"), record.origin[2]);
}

void write_session(Database& database, const MapSession& session) {
  Statement row(database, "INSERT INTO session VALUES (?, ?, ?, ?, ?, ?)");
  run(row, session.id, session.mode, session.complete ? 1 : 0, session.version, session.command,
      session.configuration);
  Statement input(database, "INSERT INTO input VALUES (?, ?, ?, ?)");
  for (std::size_t i = 0; i < session.inputs.size(); ++i) {
    run(input, session.id, number(i), session.inputs[i].first, session.inputs[i].second);
  }
  Statement robot(database, "INSERT INTO robot VALUES (?, ?, ?)");
  for (std::size_t i = 0; i < session.robots.size(); ++i) {
    run(robot, session.id, number(i), session.robots[i]);
  }
}

void write_keyframes(Database& database, int session,
                     const std::vector<std::pair<std::size_t, MapKeyframe>>& keyframes) {
  Statement row(database,
                "INSERT OR REPLACE INTO keyframe VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const auto& [n, k] : keyframes) {
    const Eigen::Vector3d p = k.T_map_robot.translation();
    const Eigen::Quaterniond q(k.T_map_robot.linear());
    run(row, session, number(n), number(k.row), k.time, p.x(), p.y(), p.z(), q.x(), q.y(), q.z(),
        q.w(), number(k.robot));
  }
}

void write_drafts(Database& database, const std::vector<DraftLandmark>& landmarks) {
  database.exec("DELETE FROM draft");
  Statement row(database, "INSERT INTO draft VALUES (?, ?, ?, ?, ?, ?)");
  for (const DraftLandmark& l : landmarks) {
    row.bind(1, l.id);
    for (int i = 0; i < 3; ++i) row.bind(2 + i, l.position[i]);
    if (l.class_index)
      row.bind(5, *l.class_index);
    else
      row.bind(5);
    row.bind(6, l.sightings);
    row.exec();
    row.reset();
  }
}

void write_rows(Database& database, const MapRecord& record) {
  for (const char* table : {"draft", "prior", "landmark_class", "landmark", "keyframe", "robot",
                            "input", "class", "session", "map"}) {
    database.exec(fmt::format("DELETE FROM {}", table));
  }
  write_kind(database, record);
  Statement name(database, "INSERT INTO class VALUES (?, ?)");
  for (std::size_t c = 0; c < record.class_names.size(); ++c) {
    run(name, number(c), record.class_names[c]);
  }
  for (const MapSession& session : record.sessions) {
    write_session(database, session);
    std::vector<std::pair<std::size_t, MapKeyframe>> keyframes;
    for (const MapKeyframe& k : session.keyframes) keyframes.emplace_back(keyframes.size(), k);
    write_keyframes(database, session.id, keyframes);
  }
  Statement landmark(database,
                     "INSERT INTO landmark VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  Statement classes(database, "INSERT INTO landmark_class VALUES (?, ?, ?)");
  for (const MapLandmark& l : record.landmarks) write_landmark(l, landmark, classes);
  Statement prior(database, "INSERT INTO prior VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  write_prior(record, prior);
}

}  // namespace hybrid
