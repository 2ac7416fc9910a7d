// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Maps a CARMEN log of laser scans: the path at every scan as a TUM file, a picture of the scans
// under the path, and the time that it took.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <exception>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/scans/scan_mapper.h"

namespace hybrid {
namespace {

struct LogEntry {
  LaserScan scan;
  SE2 odometry;
};

/// FLASER lines: number of rays, ranges, pose of the laser, odometry, time, host, time.
std::vector<LogEntry> read_carmen(const std::string& file, double field_of_view, double max_range) {
  std::ifstream in(file);
  if (!in) throw Error("cannot read " + file);
  std::vector<LogEntry> entries;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string name;
    std::size_t count = 0;
    if (!(words >> name >> count) || name != "FLASER") continue;
    LogEntry entry;
    entry.scan.ranges.resize(count);
    for (float& range : entry.scan.ranges) {
      words >> range;
      if (range >= max_range) range = std::numeric_limits<float>::quiet_NaN();
    }
    std::array<double, 6> pose{};
    for (double& x : pose) words >> x;
    words >> entry.scan.time;
    if (!words) continue;
    entry.odometry = SE2(pose[3], pose[4], pose[5]);
    entry.scan.first_angle = -0.5 * field_of_view;
    // An even number of rays lacks the last one.
    const std::size_t steps = count % 2 == 0 ? count : count - 1;
    entry.scan.angle_step = field_of_view / double(std::max<std::size_t>(steps, 1));
    entry.scan.max_range = max_range;
    entries.push_back(std::move(entry));
  }
  return entries;
}

void write_tum(const std::string& file, const std::vector<LogEntry>& log,
               const std::vector<SE2>& path) {
  std::ofstream out(file);
  char line[200];
  for (std::size_t i = 0; i < path.size(); ++i) {
    const double half = 0.5 * path[i].angle();
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f 0 0 0 %.9f %.9f\n", log[i].scan.time,
                  path[i].x(), path[i].y(), std::sin(half), std::cos(half));
    out << line;
  }
}

/// A grey picture (PGM) of how often rays end at each place.
void write_picture(const std::string& file, const std::vector<LogEntry>& log,
                   const std::vector<SE2>& path, double resolution) {
  Eigen::Array2d low(1e9, 1e9);
  Eigen::Array2d high = -low;
  for (const SE2& pose : path) {
    low = low.min(pose.translation().array());
    high = high.max(pose.translation().array());
  }
  low -= 12.0;
  high += 12.0;
  const int width = static_cast<int>((high.x() - low.x()) / resolution);
  const int height = static_cast<int>((high.y() - low.y()) / resolution);
  std::vector<int> hits(static_cast<std::size_t>(width) * height, 0);
  std::vector<bool> way(hits.size(), false);
  const auto place = [&](const Eigen::Vector2d& p) -> long {
    const int x = static_cast<int>((p.x() - low.x()) / resolution);
    const int y = height - 1 - static_cast<int>((p.y() - low.y()) / resolution);
    if (x < 0 || y < 0 || x >= width || y >= height) return -1;
    return static_cast<long>(y) * width + x;
  };
  ScanPointOptions dense;
  dense.spacing = 0.0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    for (const SurfacePoint& point : scan_points(log[i].scan, dense)) {
      const long k = place(path[i] * point.position);
      if (k >= 0) ++hits[k];
    }
    const long k = place(path[i].translation());
    if (k >= 0) way[k] = true;
  }
  std::ofstream out(file, std::ios::binary);
  out << "P5\n" << width << " " << height << "\n255\n";
  for (std::size_t k = 0; k < hits.size(); ++k) {
    const int dark = static_cast<int>(60.0 * std::log2(1.0 + hits[k]));
    out.put(static_cast<char>(way[k] ? 170 : std::max(0, 255 - dark)));
  }
}

double cpu_seconds() {
  return double(std::clock()) / CLOCKS_PER_SEC;
}

int run(const std::string& file, const std::string& prefix, bool use_odometry, double field_of_view,
        double max_range, std::size_t most, bool no_closures) {
  const std::vector<LogEntry> log = read_carmen(file, field_of_view * M_PI / 180.0, max_range);
  ScanMapperOptions options;
  if (no_closures) options.closures.most_maps = 0;
  ScanMapper mapper(options);
  std::vector<double> times;
  const double begin = cpu_seconds();
  for (std::size_t i = 0; i < std::min(most, log.size()); ++i) {
    const double before = cpu_seconds();
    std::optional<SE2> motion;
    if (use_odometry && i > 0) motion = log[i - 1].odometry.between(log[i].odometry);
    mapper.add(log[i].scan, motion);
    times.push_back(cpu_seconds() - before);
  }
  const double online = cpu_seconds() - begin;
  write_tum(prefix + "_online.tum", log, mapper.path());
  mapper.finish();
  const double total = cpu_seconds() - begin;
  write_tum(prefix + ".tum", log, mapper.path());
  write_picture(prefix + ".pgm", log, mapper.path(), 0.05);
  std::size_t accepted = 0;
  std::ofstream closures(prefix + "_closures.csv");
  const std::vector<ClosureDecision> decisions = mapper.decisions();
  for (std::size_t k = 0; k < mapper.closures().size(); ++k) {
    const ScanClosure& closure = mapper.closures()[k];
    const SE2 now = mapper.pose(closure.from).between(mapper.pose(closure.to));
    const Eigen::Vector3d off = closure.pose.motion.between(now).log();
    accepted += mapper.status(k) == ClosureStatus::kAccepted ? 1 : 0;
    closures << closure.from << "," << closure.to << "," << closure.modes << "," << closure.inliers
             << "," << static_cast<int>(mapper.status(k)) << "," << decisions[k].inlier_probability
             << "," << decisions[k].chi_square << "," << off.head<2>().norm() << "," << off.z()
             << "," << std::sqrt(closure.pose.covariance(0, 0)) << ","
             << std::sqrt(closure.pose.covariance(1, 1)) << ","
             << std::sqrt(closure.pose.covariance(2, 2)) << "\n";
  }
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return 1e3 * times[static_cast<std::size_t>(share * double(times.size() - 1))];
  };
  std::printf("%zu scans, %zu keyframes, %zu local maps, %zu closures, %zu accepted, %zu lost\n",
              times.size(), mapper.tracker().keyframes().size(),
              mapper.tracker().local_maps().size(), mapper.closures().size(), accepted,
              mapper.tracker().lost());
  std::printf("odometry noise scales %.2f %.2f\n",
              mapper.tracker().odometry_noise().translation_scale(),
              mapper.tracker().odometry_noise().rotation_scale());
  std::printf("cpu %.1f s, online %.1f s; a scan: median %.2f, p99 %.2f, most %.2f ms\n", total,
              online, at(0.5), at(0.99), at(1.0));
  return 0;
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) {
  CLI::App app("Maps a CARMEN log of laser scans by libhybrid/scans.");
  std::string log, prefix = "scans";
  double field_of_view = 180.0, max_range = 49.9;
  std::size_t most = std::numeric_limits<std::size_t>::max();
  bool no_odometry = false, no_closures = false;
  app.add_option("log", log, "CARMEN log with FLASER lines")->required();
  app.add_option("-o", prefix, "prefix of the files written");
  app.add_option("--fov", field_of_view, "field of view [degrees]");
  app.add_option("--max-range", max_range, "longer rays have no return [m]");
  app.add_option("--scans", most, "number of scans to use");
  app.add_flag("--no-odometry", no_odometry, "use scans alone");
  app.add_flag("--no-closures", no_closures, "search for no closures");
  CLI11_PARSE(app, argc, argv);
  try {
    return hybrid::run(log, prefix, !no_odometry, field_of_view, max_range, most, no_closures);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench-scans: %s\n", error.what());
    return 1;
  }
}
