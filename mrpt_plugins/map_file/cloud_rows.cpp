// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <SQLiteCpp/Statement.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>

#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/map_file/detail/map_cells.h"
#include "mrpt_plugins/map_file/detail/map_database.h"
#include "mrpt_plugins/map_file/detail/map_rows.h"
#include "mrpt_plugins/map_file/detail/map_schema.h"

// The bytes of a point are three numbers of four bytes, its position [mm], and three of one byte,
// its normal in 127ths; those of a covariance are its rows. All are little endian, as every machine
// is that this runs on.

namespace hybrid {
namespace {

constexpr std::size_t kPointBytes = 15;
constexpr double kMillimetres = 1e3;
constexpr float kNormalScale = 127;

std::string encoded(const MapCloudPoint& point) {
  std::string out(kPointBytes, '\0');
  for (int i = 0; i < 3; ++i) {
    const auto p = static_cast<std::int32_t>(
        std::lround(kMillimetres * static_cast<double>(point.position[i])));
    const auto n = static_cast<std::int8_t>(std::lround(kNormalScale * point.normal[i]));
    std::memcpy(&out[4 * static_cast<std::size_t>(i)], &p, 4);
    std::memcpy(&out[12 + static_cast<std::size_t>(i)], &n, 1);
  }
  return out;
}

MapCloudPoint decoded_point(const char* bytes) {
  MapCloudPoint out;
  for (int i = 0; i < 3; ++i) {
    std::int32_t p = 0;
    std::int8_t n = 0;
    std::memcpy(&p, bytes + 4 * i, 4);
    std::memcpy(&n, bytes + 12 + i, 1);
    out.position[i] = static_cast<float>(p / kMillimetres);
    out.normal[i] = static_cast<float>(n) / kNormalScale;
  }
  return out;
}

MapLocalCloud decoded_cloud(MapCells& row) {
  MapLocalCloud out;
  out.session = row.count(0);
  double pose[SE3::kSize];  // x y z qx qy qz qw
  for (int i = 0; i < SE3::kSize; ++i) pose[i] = row.real(2 + i);
  out.T_map_anchor.motion = SE3::load(pose);
  Matrix6d& C = out.T_map_anchor.covariance;
  const std::string covariance = row.bytes(9, sizeof(double) * 36);
  if (covariance.size() != sizeof(double) * 36) {
    throw Error(fmt::format("a local cloud of session {} has no covariance", out.session));
  }
  std::memcpy(C.data(), covariance.data(), covariance.size());
  out.spacing = row.real(10);
  const std::string points = row.bytes(11, kPointBytes);
  out.points.reserve(points.size() / kPointBytes);
  for (std::size_t i = 0; i < points.size(); i += kPointBytes) {
    out.points.push_back(decoded_point(points.data() + i));
  }
  return out;
}

}  // namespace

void write_local_clouds(SQLite::Database& database, const MapRecord& record) {
  SQLite::Statement row(database,
                        "INSERT INTO local_cloud VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  std::map<int, std::int64_t> count;  // by session
  for (const MapLocalCloud& cloud : record.local_clouds) {
    std::string points;
    points.reserve(cloud.points.size() * kPointBytes);
    for (const MapCloudPoint& point : cloud.points) points += encoded(point);
    double pose[SE3::kSize];  // x y z qx qy qz qw
    cloud.T_map_anchor.motion.store(pose);
    const Matrix6d& C = cloud.T_map_anchor.covariance;
    row.bind(1, cloud.session);
    row.bind(2, count[cloud.session]++);
    for (int i = 0; i < SE3::kSize; ++i) row.bind(3 + i, pose[i]);
    row.bind(10, C.data(), static_cast<int>(sizeof(double) * 36));
    row.bind(11, cloud.spacing);
    row.bind(12, points.data(), static_cast<int>(points.size()));
    row.exec();
    row.reset();
  }
}

void read_local_clouds(SQLite::Database& database, MapRecord& out) {
  if (pragma(database, "user_version") < map_schema::kFirstWithClouds) return;
  std::map<int, std::int64_t> count;  // by session
  for (const MapSession& session : out.sessions) count[session.id] = 0;
  MapCells rows(database, "local_cloud",
                "SELECT session, number, x, y, z, qx, qy, qz, qw, covariance, spacing, points "
                "FROM local_cloud ORDER BY session, number");
  while (rows.next()) {
    MapLocalCloud cloud = decoded_cloud(rows);
    const auto next = count.find(cloud.session);
    if (next == count.end() || rows.whole(1) != next->second++) {
      throw Error(fmt::format("local clouds of session {} are not of their form", cloud.session));
    }
    out.local_clouds.push_back(std::move(cloud));
  }
}

}  // namespace hybrid
