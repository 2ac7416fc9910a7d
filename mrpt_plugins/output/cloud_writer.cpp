// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/cloud_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "mrpt_plugins/output/closure_csv.h"

namespace hybrid {
namespace {

constexpr float kWall = 0.5F;        // cosine between a normal and the vertical
constexpr double kFinest = 0.05;     // m, of a cell
constexpr double kMostCells = 2000;  // along a side

void append(std::string& out, const Eigen::Vector3f& v) {
  char bytes[3 * sizeof(float)];
  std::memcpy(bytes, v.data(), sizeof bytes);
  out.append(bytes, sizeof bytes);
}

std::string rows_of(const std::vector<CloudPoint>& points) {
  std::string out;
  out.reserve(points.size() * sizeof(CloudPoint));
  for (const CloudPoint& point : points) {
    append(out, point.position);
    append(out, point.normal);
  }
  return out;
}

}  // namespace

std::string cloud_ply(const std::vector<CloudPoint>& points) {
  std::string out =
      fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    out += fmt::format("property float {}\n", name);
  }
  return out + "end_header\n" + rows_of(points);
}

std::string cloud_pcd(const std::vector<CloudPoint>& points) {
  return fmt::format(
             "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\n"
             "SIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH {0}\nHEIGHT 1\n"
             "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {0}\nDATA binary\n",
             points.size()) +
         rows_of(points);
}

GridMap cloud_grid(const std::vector<CloudPoint>& points) {
  Eigen::AlignedBox2d box;
  for (const CloudPoint& point : points) {
    if (std::abs(point.normal.z()) < kWall) box.extend(point.position.head<2>().cast<double>());
  }
  GridMap out;
  if (box.isEmpty()) return out;
  out.resolution = std::max(kFinest, box.sizes().maxCoeff() / kMostCells);
  out.corner = box.min();
  out.width = static_cast<int>(box.sizes().x() / out.resolution) + 1;
  out.height = static_cast<int>(box.sizes().y() / out.resolution) + 1;
  out.cells.assign(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height),
                   GridMap::kUnknown);
  for (const CloudPoint& point : points) {
    if (!(std::abs(point.normal.z()) < kWall)) continue;
    const Eigen::Vector2d at =
        (point.position.head<2>().cast<double>() - out.corner) / out.resolution;
    const auto x = static_cast<std::size_t>(at.x()), y = static_cast<std::size_t>(at.y());
    out.cells[y * static_cast<std::size_t>(out.width) + x] = GridMap::kOccupied;
  }
  return out;
}

std::string cloud_closures_csv(const std::vector<MeasuredClosure<SE3>>& closures) {
  std::string out = fmt::format("i,j,{},inliers,modes,x,y,z,yaw,pitch,roll\n", kDecisionColumns);
  for (const MeasuredClosure<SE3>& c : closures) {
    const Eigen::Vector3d t = c.T_from_to.translation();
    const Eigen::Matrix3d R = c.T_from_to.rotation().matrix();
    const double pitch = std::asin(std::clamp(-R(2, 0), -1.0, 1.0));
    fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{},{},{},{},{},{}\n", c.from, c.to,
                   decision_cells(c.decision), c.inliers, c.modes, t.x(), t.y(), t.z(),
                   std::atan2(R(1, 0), R(0, 0)), pitch, std::atan2(R(2, 1), R(2, 2)));
  }
  return out;
}

}  // namespace hybrid
