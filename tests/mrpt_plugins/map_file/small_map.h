// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Map files that others have made or changed.

#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <random>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/map_file/map_file.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {

/// Runs SQL on a file, not by way of the library.
inline void run_sql(const std::string& file, const std::string& sql) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(file.c_str(), &database), SQLITE_OK);
  char* message = nullptr;
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &message), SQLITE_OK) << message;
  sqlite3_free(message);
  sqlite3_close(database);
}

/// Three landmarks of two classes, seen in two sessions, the second of two robots.
inline MapRecord small_map() {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  MapRecord map;
  map.class_names = {"tree", "pole"};
  map.origin = {36.7, -4.5, 90, 12, true};
  for (int i = 0; i < 3; ++i) {
    MapLandmark l;
    l.id = 10 * i;
    l.session = 1;
    l.position = {normal(random), normal(random), 0};
    l.covariance.topLeftCorner(2, 2) = 0.01 * Eigen::Matrix2d::Identity();
    l.class_probabilities = {0.25, 0.75};
    l.existence = 5;
    l.sightings = 7;
    if (i == 1) l.size = {0.25, 3};
    map.landmarks.push_back(l);
  }
  map.prior = sparsify(0.01 * Eigen::MatrixXd::Identity(6, 6), 2);
  for (int id = 1; id <= 2; ++id) {
    MapSession s;
    s.id = id;
    s.mode = id == 1 ? "build" : "extend";
    s.complete = true;
    s.inputs = {{"a.rawlog", "0123"}};
    if (id == 2) s.robots = {"anna", "bert"};
    for (std::size_t i = 0; i < 50; ++i) {
      MapKeyframe k;
      k.row = i;
      k.time = static_cast<double>(i);
      k.robot = id == 2 ? i % 2 : 0;
      const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
      k.T_map_robot = Eigen::Translation3d(normal(random), 1, 2) * q.normalized();
      s.keyframes.push_back(k);
    }
    map.sessions.push_back(s);
    MapLocalMap local;
    local.session = id;
    local.pose << normal(random), normal(random), 0.3;
    local.covariance = 0.01 * Eigen::Matrix3d::Identity();
    for (int n = 0; n < 40; ++n) {
      local.surfaces.push_back({{0.1 * n, -2.345}, std::nullopt});
      if (n % 2 == 0) local.surfaces.back().direction = -1.571;
    }
    map.local_maps.insert(map.local_maps.end(), {local, local});
    map.local_maps.back().parent = {map.local_maps.size() - 2, 1e-4 * Eigen::Matrix3d::Identity()};
    MapLocalCloud cloud;
    cloud.session = id;
    cloud.T_map_anchor = {SE3({normal(random), 2, 3}, SO3::exp(Eigen::Vector3d(0.1, 0.2, 0.3))),
                          0.01 * SE3::Jacobian::Identity()};
    cloud.spacing = 0.15;
    for (int n = 0; n < 40; ++n) {
      cloud.points.push_back(
          {Eigen::Vector3f(0.25F * float(n), -2.5F, 40), Eigen::Vector3f::Zero()});
      if (n % 2 == 0) cloud.points.back().normal = Eigen::Vector3f(0, 0, -1);
    }
    map.local_clouds.insert(map.local_clouds.end(), {cloud, cloud});
  }
  return map;
}

/// All numbers of a map.
inline std::vector<double> numbers_of(const MapRecord& map) {
  std::vector<double> out;
  for (const MapLandmark& l : map.landmarks) {
    out.insert(out.end(), l.position.begin(), l.position.end());
    out.insert(out.end(), l.covariance.reshaped().begin(), l.covariance.reshaped().end());
    out.insert(out.end(), l.class_probabilities.begin(), l.class_probabilities.end());
    out.insert(out.end(), {double(l.id), l.existence, double(l.sightings), double(l.session)});
    out.insert(out.end(), {l.size.extent, double(l.size.things)});
  }
  for (const MapLocalMap& local : map.local_maps) {
    out.push_back(local.session);
    out.insert(out.end(), local.pose.begin(), local.pose.end());
    out.insert(out.end(), local.covariance.reshaped().begin(), local.covariance.reshaped().end());
    if (local.parent) {
      const Eigen::Matrix3d& C = local.parent->covariance;
      out.push_back(double(local.parent->place));
      out.insert(out.end(), C.reshaped().begin(), C.reshaped().end());
    }
    for (const MapSurface& s : local.surfaces) {
      out.insert(out.end(), {s.position.x(), s.position.y(), s.direction.value_or(9)});
    }
  }
  for (const MapLocalCloud& local : map.local_clouds) {
    const Eigen::Matrix4d T = local.T_map_anchor.motion.matrix();
    const SE3::Jacobian& C = local.T_map_anchor.covariance;
    out.insert(out.end(), T.reshaped().begin(), T.reshaped().end());
    out.insert(out.end(), C.reshaped().begin(), C.reshaped().end());
    out.insert(out.end(), {double(local.session), local.spacing});
    for (const MapCloudPoint& p : local.points) {
      out.insert(out.end(), p.position.begin(), p.position.end());
      out.insert(out.end(), p.normal.begin(), p.normal.end());
    }
  }
  for (const MapSession& s : map.sessions) {
    for (const MapKeyframe& k : s.keyframes) {
      const Eigen::Matrix4d& T = k.T_map_robot.matrix();
      out.insert(out.end(), T.reshaped().begin(), T.reshaped().end());
      out.insert(out.end(), {double(k.row), k.time, double(k.robot)});
    }
  }
  return out;
}

class MapFileTest : public ScratchFolder {
 protected:
  void SetUp() override { MapFile(at("a.hmap")).replace(small_map()); }
  /// Expects that neither reading nor changing a file begins, for a reason that names it.
  void expect_refused(const std::string& name, const std::string& part) const {
    const auto message_of = [&](const auto& open) -> std::string {
      try {
        open();
      } catch (const Error& e) {
        return e.what();
      }
      return "no error";
    };
    const std::string before = std::filesystem::is_regular_file(at(name)) ? read(name) : "";
    for (const std::string& message : {message_of([&] { read_map(at(name)); }),
                                       message_of([&] { const MapFile file(at(name)); })}) {
      EXPECT_NE(message.find(part), std::string::npos) << message;
      EXPECT_EQ(message.rfind(at(name), 0), 0U) << message;
    }
    EXPECT_TRUE(before.empty() || read(name) == before);
  }
  void expect_refused_after(const std::string& sql, const std::string& part) const {
    SCOPED_TRACE(sql);
    const std::string sound = read("a.hmap");
    run_sql(at("a.hmap"), sql);
    expect_refused("a.hmap", part);
    write("a.hmap", sound);
  }
};

}  // namespace hybrid
