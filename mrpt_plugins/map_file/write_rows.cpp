// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "mrpt_plugins/map_file/detail/map_rows.h"

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

std::int64_t number_of(std::size_t n) {
  return static_cast<std::int64_t>(n);
}

std::int64_t in_thousandths(double value) {
  return std::llround(1e3 * value);
}

void write_landmark(const MapLandmark& l, Statement& landmark, Statement& classes,
                    Statement& size) {
  const Eigen::Vector3d& p = l.position;
  const Eigen::Matrix3d& C = l.covariance;
  run(landmark, l.id, l.session, p.x(), p.y(), p.z(), C(0, 0), C(0, 1), C(0, 2), C(1, 1), C(1, 2),
      C(2, 2), l.existence, l.sightings);
  for (std::size_t c = 0; c < l.class_probabilities.size(); ++c) {
    run(classes, l.id, number_of(c), l.class_probabilities[c]);
  }
  const bool is_single = l.size.extent == 0 && l.size.things == 1;
  if (!is_single) run(size, l.id, l.size.extent, l.size.things);
}

void write_prior(const MapRecord& record, Statement& statement) {
  const int dim = record.dim();
  for (std::size_t i = 0; i < record.prior.rows.size(); ++i) {
    const SparseRow& row = record.prior.rows[i];
    for (std::size_t k = 0; k < row.variables.size(); ++k) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      R.topLeftCorner(dim, dim) = row.R.middleCols(dim * static_cast<Eigen::Index>(k), dim);
      const auto given = static_cast<std::size_t>(row.variables[k]);
      run(statement, record.landmarks[i].id, number_of(k), record.landmarks[given].id, R(0, 0),
          R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2));
    }
  }
}

void write_local_maps(const MapRecord& record, Database& database) {
  Statement row(database, "INSERT INTO local_map VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  Statement surface(database, "INSERT INTO surface VALUES (?, ?, ?, ?, ?, ?)");
  std::map<int, std::size_t> count;  // by session
  for (const MapLocalMap& map : record.local_maps) {
    const Eigen::Matrix3d& C = map.covariance;
    const std::size_t number = count[map.session]++;
    run(row, map.session, number_of(number), map.pose.x(), map.pose.y(), map.pose.z(), C(0, 0),
        C(0, 1), C(0, 2), C(1, 1), C(1, 2), C(2, 2));
    for (std::size_t i = 0; i < map.surfaces.size(); ++i) {
      const MapSurface& s = map.surfaces[i];
      surface.bind(1, map.session);
      surface.bind(2, number_of(number));
      surface.bind(3, number_of(i));
      surface.bind(4, in_thousandths(s.position.x()));
      surface.bind(5, in_thousandths(s.position.y()));
      if (s.direction) {
        surface.bind(6, in_thousandths(*s.direction));
      } else {
        surface.bind(6);
      }
      surface.exec();
      surface.reset();
    }
  }
}

bool same(const MapKeyframe& a, const MapKeyframe& b) {
  return a.row == b.row && a.time == b.time && a.robot == b.robot &&
         a.T_map_robot.matrix() == b.T_map_robot.matrix();
}

/// Sessions whose keyframes are those of the file, to be left as they are: an orientation that is
/// read and written again may differ in its last bit.
std::set<int> same_keyframes(const MapRecord& record, const MapRecord& before) {
  std::set<int> out;
  for (const MapSession& s : record.sessions) {
    const auto old = std::find_if(before.sessions.begin(), before.sessions.end(),
                                  [&](const MapSession& b) { return b.id == s.id; });
    if (old == before.sessions.end() || !old->complete || !s.complete) continue;
    if (std::equal(s.keyframes.begin(), s.keyframes.end(), old->keyframes.begin(),
                   old->keyframes.end(), same)) {
      out.insert(s.id);
    }
  }
  return out;
}

void forget_keyframes(Database& database, const std::set<int>& kept) {
  std::vector<int> there;
  {
    Statement rows(database, "SELECT DISTINCT session FROM keyframe");
    while (rows.executeStep()) there.push_back(rows.getColumn(0).getInt());
  }
  Statement forget(database, "DELETE FROM keyframe WHERE session = ?");
  for (const int id : there) {
    if (kept.count(id) == 0) run(forget, id);
  }
}

}  // namespace

void write_kind(Database& database, const MapRecord& record) {
  Statement map(database, "INSERT OR REPLACE INTO map VALUES (?, ?)");
  run(map, std::string("dimension"), record.dim());
  run(map, std::string("identified"), record.identified ? 1 : 0);
  run(map, std::string("loss"), record.prior.loss);
  if (!record.origin) return;
  run(map, std::string("latitude"), record.origin->latitude);
  run(map, std::string("longitude"), record.origin->longitude);
  run(map, std::string("direction"), record.origin->direction);
  if (!record.origin->by_fixes) return;
  run(map, std::string("altitude"), record.origin->altitude);
  run(map, std::string("by_fixes"), 1);
}

void write_session(Database& database, const MapSession& session) {
  Statement row(database, "INSERT INTO session VALUES (?, ?, ?, ?, ?, ?)");
  run(row, session.id, session.mode, session.complete ? 1 : 0, session.version, session.command,
      session.configuration);
  Statement input(database, "INSERT INTO input VALUES (?, ?, ?, ?)");
  for (std::size_t i = 0; i < session.inputs.size(); ++i) {
    run(input, session.id, number_of(i), session.inputs[i].first, session.inputs[i].second);
  }
  Statement robot(database, "INSERT INTO robot VALUES (?, ?, ?)");
  for (std::size_t i = 0; i < session.robots.size(); ++i) {
    run(robot, session.id, number_of(i), session.robots[i]);
  }
}

void write_keyframes(Database& database, int session,
                     const std::vector<std::pair<std::size_t, MapKeyframe>>& keyframes) {
  Statement row(database,
                "INSERT OR REPLACE INTO keyframe VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  for (const auto& [n, k] : keyframes) {
    const Eigen::Vector3d p = k.T_map_robot.translation();
    const Eigen::Quaterniond q(k.T_map_robot.linear());
    run(row, session, number_of(n), number_of(k.row), k.time, p.x(), p.y(), p.z(), q.x(), q.y(),
        q.z(), q.w(), number_of(k.robot));
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

void write_rows(Database& database, const MapRecord& record, const MapRecord& before) {
  const std::set<int> kept = same_keyframes(record, before);
  database.exec("PRAGMA defer_foreign_keys = ON");  // sessions come back under their keyframes
  forget_keyframes(database, kept);
  for (const char* table :
       {"draft", "place_parent", "local_cloud", "surface", "local_map", "prior", "landmark_size",
        "landmark_class", "landmark", "robot", "input", "class", "session"}) {
    database.exec(fmt::format("DELETE FROM {}", table));
  }
  database.exec("DELETE FROM map WHERE name <> 'checksum'");
  write_kind(database, record);
  Statement name(database, "INSERT INTO class VALUES (?, ?)");
  for (std::size_t c = 0; c < record.class_names.size(); ++c) {
    run(name, number_of(c), record.class_names[c]);
  }
  for (const MapSession& session : record.sessions) {
    write_session(database, session);
    if (kept.count(session.id) > 0) continue;
    std::vector<std::pair<std::size_t, MapKeyframe>> keyframes;
    for (const MapKeyframe& k : session.keyframes) keyframes.emplace_back(keyframes.size(), k);
    write_keyframes(database, session.id, keyframes);
  }
  Statement landmark(database,
                     "INSERT INTO landmark VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  Statement classes(database, "INSERT INTO landmark_class VALUES (?, ?, ?)");
  Statement size(database, "INSERT INTO landmark_size VALUES (?, ?, ?)");
  for (const MapLandmark& l : record.landmarks) write_landmark(l, landmark, classes, size);
  Statement prior(database, "INSERT INTO prior VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  write_prior(record, prior);
  write_local_maps(record, database);
  write_local_clouds(database, record);
  write_parents(database, record);
}

}  // namespace hybrid
