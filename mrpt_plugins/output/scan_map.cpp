// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/scan_map.h"

#include <fmt/format.h>
#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "mrpt_plugins/bridge/gzip_writer.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/input/scans.h"

namespace hybrid {
namespace {

constexpr double kReach = 30;  // m, up to where a ray counts
// Around what is seen. MRPT enlarges a grid that has fewer than 15, with a copy of it.
constexpr double kRimCells = 25;
constexpr double kNearMotion = 0.2;  // m
constexpr double kNearTurn = 10 * M_PI / 180;
constexpr float kOccupiedAbove = 0.65F, kFreeBelow = 0.196F;  // probabilities of ROS maps

bool is_near(const mrpt::poses::CPose3D& a, const mrpt::poses::CPose3D& b) {
  const Eigen::Isometry3d motion = to_isometry(a).inverse() * to_isometry(b);
  return motion.translation().norm() < kNearMotion &&
         Eigen::AngleAxisd(motion.linear()).angle() < kNearTurn;
}

/// How far the rays that count reach; 0 where none has a return.
double reach_of(const LaserScan& scan) {
  double reach = 0;
  for (const float range : scan.ranges) {
    if (std::isfinite(range)) reach = std::max(reach, static_cast<double>(range));
  }
  return std::min(reach, kReach);
}

/// Where the scans may see anything; empty where no ray has a return, or a pose is not finite.
Eigen::AlignedBox2d seen_box(const std::vector<KeyframeScans>& scans, const Trajectory& keyframes) {
  Eigen::AlignedBox2d box;
  double most = 0;
  for (const KeyframeScans& at : scans) {
    const Eigen::Isometry3d T_map_robot = to_isometry(keyframes[at.keyframe].pose);
    for (const LaserScan* scan : at.scans) {
      const Eigen::Vector2d from = (T_map_robot * scan->T_robot_sensor).translation().head<2>();
      const double reach = reach_of(*scan);
      if (!from.allFinite()) return {};
      box.extend(from + Eigen::Vector2d::Constant(reach));
      box.extend(from - Eigen::Vector2d::Constant(reach));
      most = std::max(most, reach);
    }
  }
  return most > 0 ? box : Eigen::AlignedBox2d();
}

double resolution_for(const Eigen::AlignedBox2d& box, double most_cells) {
  double resolution = GridMap().resolution;
  while (box.sizes().prod() / (resolution * resolution) > most_cells) resolution *= 2;
  return resolution;
}

GridMap::Cell cell_of(float free) {
  const float occupied = 1 - free;
  if (occupied > kOccupiedAbove) return GridMap::kOccupied;
  return occupied < kFreeBelow ? GridMap::kFree : GridMap::kUnknown;
}

/// The part of a grid that is known, with a rim.
GridMap converted(const mrpt::maps::COccupancyGridMap2D& grid) {
  constexpr int kKnownRim = 10;  // cells
  Eigen::AlignedBox2i known;
  const Eigen::Vector2i size(static_cast<int>(grid.getSizeX()), static_cast<int>(grid.getSizeY()));
  for (int y = 0; y < size.y(); ++y) {
    for (int x = 0; x < size.x(); ++x) {
      if (cell_of(grid.getCell(x, y)) != GridMap::kUnknown) known.extend(Eigen::Vector2i(x, y));
    }
  }
  if (known.isEmpty()) return {};
  const Eigen::Vector2i low = (known.min().array() - kKnownRim).max(0);
  const Eigen::Vector2i high = (known.max().array() + kKnownRim).min(size.array() - 1);
  GridMap out;
  out.resolution = static_cast<double>(grid.getResolution());
  out.corner =
      Eigen::Vector2d(static_cast<double>(grid.getXMin()), static_cast<double>(grid.getYMin())) +
      out.resolution * low.cast<double>();
  out.width = high.x() - low.x() + 1;
  out.height = high.y() - low.y() + 1;
  out.cells.reserve(static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  for (int y = low.y(); y <= high.y(); ++y) {
    for (int x = low.x(); x <= high.x(); ++x) out.cells.push_back(cell_of(grid.getCell(x, y)));
  }
  return out;
}

constexpr int kSimpleMapCompression = 6;

Matrix6d in_space(const Eigen::MatrixXd& covariance) {
  if (covariance.rows() == 6) return covariance;
  if (covariance.rows() == 3) return planar_to_6d(covariance);
  return Matrix6d::Zero();
}

}  // namespace

std::vector<KeyframeScans> drawn_keyframes(const ScanArchive& archive,
                                           const Trajectory& keyframes) {
  std::vector<KeyframeScans> out;
  std::map<std::size_t, std::size_t> last;  // of each robot, the keyframe drawn last
  for (const ScanArchive::Entry& entry : archive.entries()) {
    if (!entry.is_own || entry.scan.ranges.empty()) continue;
    if (!out.empty() && out.back().keyframe == entry.keyframe) {
      out.back().scans.push_back(&entry.scan);
      continue;
    }
    const std::size_t robot = archive.robot_of(entry.keyframe);
    const auto before = last.find(robot);
    if (before != last.end() &&
        is_near(keyframes[before->second].pose, keyframes[entry.keyframe].pose)) {
      continue;
    }
    last[robot] = entry.keyframe;
    out.push_back({entry.keyframe, {&entry.scan}});
  }
  return out;
}

GridMap draw_grid(const std::vector<KeyframeScans>& scans, const Trajectory& keyframes,
                  double most_cells) {
  const Eigen::AlignedBox2d box = seen_box(scans, keyframes);
  if (box.isEmpty()) return {};
  mrpt::maps::COccupancyGridMap2D grid;
  const double resolution = resolution_for(box, most_cells);
  const Eigen::Vector2d low = box.min().array() - kRimCells * resolution;
  const Eigen::Vector2d high = box.max().array() + kRimCells * resolution;
  grid.setSize(static_cast<float>(low.x()), static_cast<float>(high.x()),
               static_cast<float>(low.y()), static_cast<float>(high.y()),
               static_cast<float>(resolution), 0.5F);
  auto& options = grid.insertionOptions;
  options.maxDistanceInsertion = static_cast<float>(kReach);
  options.considerInvalidRangesAsFreeSpace = false;
  for (const KeyframeScans& at : scans) {
    for (const LaserScan* scan : at.scans) {
      grid.insertObservation(*to_mrpt(*scan), keyframes[at.keyframe].pose);
    }
  }
  return converted(grid);
}

std::string grid_pgm(const GridMap& grid) {
  constexpr char kShades[] = {static_cast<char>(205), static_cast<char>(254), 0};
  std::string out = fmt::format("P5\n{} {}\n255\n", grid.width, grid.height);
  for (int y = grid.height - 1; y >= 0; --y) {
    for (int x = 0; x < grid.width; ++x) out += kShades[grid.at(x, y)];
  }
  return out;
}

std::string grid_yaml(const GridMap& grid, const std::string& pgm) {
  return fmt::format(
      "image: {}\nmode: trinary\nresolution: {:.6g}\norigin: [{:.6f}, {:.6f}, 0.0]\nnegate: 0\n"
      "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
      pgm, grid.resolution, grid.corner.x(), grid.corner.y());
}

namespace {

void insert_at(std::size_t keyframe, const mrpt::obs::CSensoryFrame::Ptr& frame,
               const Trajectory& keyframes, const std::vector<Eigen::MatrixXd>& covariances,
               mrpt::maps::CSimpleMap& map) {
  const auto pose = std::make_shared<mrpt::poses::CPose3DPDFGaussian>(
      pose_pdf(keyframes[keyframe].pose, in_space(covariances[keyframe])));
  map.insert(mrpt::poses::CPose3DPDF::Ptr(pose), frame);
}

void save_simple_map(const OutputDirectory& out, const std::string& name,
                     const mrpt::maps::CSimpleMap& map) {
  out.save(name, [&](const std::string& path) {
    GzipWriter file(path, kSimpleMapCompression, out.folder() / name);
    mrpt::serialization::archiveFrom<mrpt::io::CStream>(file) << map;
    file.close();
  });
}

}  // namespace

void write_simple_map(const OutputDirectory& out, const std::string& name,
                      const std::vector<KeyframeScans>& scans, const Trajectory& keyframes,
                      const std::vector<Eigen::MatrixXd>& covariances) {
  mrpt::maps::CSimpleMap map;
  for (const KeyframeScans& at : scans) {
    const auto frame = mrpt::obs::CSensoryFrame::Create();
    for (const LaserScan* scan : at.scans) frame->insert(to_mrpt(*scan));
    insert_at(at.keyframe, frame, keyframes, covariances, map);
  }
  save_simple_map(out, name, map);
}

void write_simple_map(const OutputDirectory& out, const std::string& name,
                      std::vector<LocalView> views, const Trajectory& keyframes,
                      const std::vector<Eigen::MatrixXd>& covariances) {
  mrpt::maps::CSimpleMap map;
  for (LocalView& view : views) {
    const auto points = mrpt::maps::CSimplePointsMap::Create();
    points->reserve(view.points.size());
    for (const CloudPoint& point : view.points) {
      points->insertPoint(point.position.x(), point.position.y(), point.position.z());
    }
    view.points = {};  // large maps are in memory once
    const auto seen = mrpt::obs::CObservationPointCloud::Create();
    seen->timestamp = mrpt::Clock::fromDouble(keyframes[view.anchor].time);
    seen->sensorLabel = "cloud";
    seen->pointcloud = points;
    const auto frame = mrpt::obs::CSensoryFrame::Create();
    frame->insert(seen);
    insert_at(view.anchor, frame, keyframes, covariances, map);
  }
  save_simple_map(out, name, map);
}

}  // namespace hybrid
