// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Odometry by the clouds of a 3-D lidar, as others find it: KISS-ICP and small_gicp, each with its
// authors' settings, with one thread and without other odometry. The poses are a TUM file, which
// `hybrid-import clouds --odometry` takes, so that hybrid-replay judges them as it judges its own.
#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <kiss_icp/pipeline/KissICP.hpp>
#include <memory>
#include <small_gicp/ann/gaussian_voxelmap.hpp>
#include <small_gicp/ann/incremental_voxelmap.hpp>
#include <small_gicp/factors/gicp_factor.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/registration/reduction.hpp>
#include <small_gicp/registration/registration.hpp>
#include <small_gicp/util/downsampling.hpp>
#include <small_gicp/util/normal_estimation.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/stopwatch.h"

namespace {

using hybrid::bench::Distribution;
using hybrid::bench::Stopwatch;
using Cloud = std::vector<Eigen::Vector3d>;

struct Options {
  std::string peer = "kiss-icp";
  double voxel = 1.0;        ///< edge of the cubes of the map [m]; all have 1 m for cars
  double max_range = 100.0;  ///< [m]
  bool steady = false;       ///< small_gicp starts where a steady motion leads, as KISS-ICP does
};

/// A pose for each cloud, in the frame of the first.
class Odometry {
 public:
  virtual ~Odometry() = default;
  virtual Eigen::Isometry3d add(const Cloud& cloud) = 0;
};

/// Points to points with an adaptive threshold, from a steady motion.
class KissIcp : public Odometry {
 public:
  explicit KissIcp(const Options& options) : pipeline_(settings(options)) {}

  Eigen::Isometry3d add(const Cloud& cloud) override {
    pipeline_.RegisterFrame(cloud, {});
    return Eigen::Isometry3d(pipeline_.pose().matrix());
  }

 private:
  static kiss_icp::pipeline::KISSConfig settings(const Options& options) {
    kiss_icp::pipeline::KISSConfig out;
    out.voxel_size = options.voxel;
    out.max_range = options.max_range;
    out.deskew = false;
    out.max_num_threads = 1;
    return out;
  }

  kiss_icp::pipeline::KissICP pipeline_;
};

/// Distributions to distributions of a map, with the settings of small_gicp's odometry_benchmark:
/// 20 neighbours of a point, points a quarter of a cube apart. It starts from the last pose there,
/// and from a steady motion in its kitti_odometry.py.
template <class Map>
class SmallGicp : public Odometry {
 public:
  explicit SmallGicp(const Options& options) : options_(options), map_(options.voxel) {}

  Eigen::Isometry3d add(const Cloud& cloud) override {
    const auto points =
        small_gicp::voxelgrid_sampling(small_gicp::PointCloud(near(cloud)), 0.25 * options_.voxel);
    small_gicp::estimate_covariances(*points, 20);
    if (map_.size() > 0) {
      const Eigen::Isometry3d start = options_.steady ? pose_ * motion_ : pose_;
      const small_gicp::Registration<small_gicp::GICPFactor, small_gicp::SerialReduction> align;
      Eigen::Isometry3d found = align.align(map_, *points, map_, start).T_target_source;
      // A steady motion would double the error of a rotation that is not quite one with every
      // cloud.
      found.linear() = Eigen::Quaterniond(found.linear()).normalized().toRotationMatrix();
      motion_ = pose_.inverse() * found;
      pose_ = found;
    }
    map_.insert(*points, pose_);
    return pose_;
  }

 private:
  Cloud near(const Cloud& cloud) const {
    Cloud out;
    for (const Eigen::Vector3d& point : cloud) {
      if (point.norm() < options_.max_range) out.push_back(point);
    }
    return out;
  }

  Options options_;
  Map map_;
  Eigen::Isometry3d pose_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d motion_ = Eigen::Isometry3d::Identity();
};

std::unique_ptr<Odometry> make_odometry(const Options& options) {
  using Points = small_gicp::IncrementalVoxelMap<small_gicp::FlatContainerCov>;
  if (options.peer == "kiss-icp") return std::make_unique<KissIcp>(options);
  if (options.peer == "small-gicp") return std::make_unique<SmallGicp<Points>>(options);
  return std::make_unique<SmallGicp<small_gicp::GaussianVoxelMap>>(options);
}

std::vector<std::string> names_of_clouds(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".bin") names.push_back(entry.path().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// KITTI's form: x, y, z and intensity, 32 bits each.
Cloud read_cloud(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + name);
  Cloud cloud;
  for (float row[4]; in.read(reinterpret_cast<char*>(row), sizeof row);) {
    cloud.emplace_back(row[0], row[1], row[2]);
  }
  return cloud;
}

/// First numbers of the rows of a TUM file, or without a file 0, 0.1 and so on [s].
std::vector<double> times_of_clouds(const std::string& file, std::size_t count) {
  std::vector<double> times;
  std::ifstream in(file);
  for (std::string line; !file.empty() && std::getline(in, line);) {
    std::istringstream words(line);
    if (double time; words >> time) times.push_back(time);
  }
  for (std::size_t i = 0; file.empty() && i < count; ++i) times.push_back(0.1 * double(i));
  if (times.size() != count) throw std::runtime_error("not a time for each cloud: " + file);
  return times;
}

void write_row(std::ofstream& out, double time, const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.rotation());
  const Eigen::Vector3d t = pose.translation();
  char line[256];
  std::snprintf(line, sizeof line, "%.9f %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n", time, t.x(),
                t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  out << line;
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app("A path by the clouds of a 3-D lidar, found by KISS-ICP or small_gicp");
  Options options;
  std::string folder, times_file, output;
  app.add_option("FOLDER", folder, "Clouds F.bin in KITTI's form")->required();
  app.add_option("--peer", options.peer, "small-gicp keeps points in its map, small-vgicp means")
      ->check(CLI::IsMember({"kiss-icp", "small-gicp", "small-vgicp"}));
  app.add_option("--times", times_file, "TUM file with a row for each cloud");
  app.add_option("--voxel", options.voxel, "Edge of the cubes of the map [m]");
  app.add_option("--max-range", options.max_range, "Points farther away are dropped [m]");
  app.add_flag("--steady", options.steady, "small_gicp starts where a steady motion leads");
  app.add_option("-o,--output", output, "TUM file to write")->required();
  CLI11_PARSE(app, argc, argv);

  const std::vector<std::string> names = names_of_clouds(folder);
  const std::vector<double> times = times_of_clouds(times_file, names.size());
  const std::unique_ptr<Odometry> odometry = make_odometry(options);
  std::ofstream out(output);
  std::vector<double> seconds;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Cloud cloud = read_cloud(names[i]);
    const Stopwatch watch;
    const Eigen::Isometry3d pose = odometry->add(cloud);
    seconds.push_back(watch.elapsed().cpu);
    write_row(out, times[i], pose);
  }
  if (!out.flush()) throw std::runtime_error("cannot write " + output);
  const Distribution d = hybrid::bench::distribution(seconds);
  std::printf("%s: %zu clouds, median %.1f ms, p95 %.1f ms\n", options.peer.c_str(), names.size(),
              1e3 * d.p50, 1e3 * d.p95);
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-clouds: %s\n", e.what());
  return 1;
}
