// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/graph_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "libhybrid/core/error.h"
#include "libhybrid/io/read_graph.h"
#include "mrpt_plugins/input/ground_truth.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

/// The first line with something on it; throws Error for a file that has none.
std::string first_line(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw Error(file + ": cannot be read");
  std::string line;
  while (std::getline(in, line)) {
    const std::size_t at = line.find_first_not_of(" \t\r");
    if (at != std::string::npos && line[at] != '#' && line[at] != '%') return line.substr(at);
  }
  throw Error(file + ": holds no pose");
}

std::size_t count_words(const std::string& line) {
  std::istringstream in(line);
  std::string word;
  std::size_t count = 0;
  while (in >> word) ++count;
  return count;
}

std::vector<CPose3D> read_planar(const std::string& file) {
  std::vector<CPose3D> poses;
  std::ifstream in(file);
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::istringstream row(line.substr(0, line.find_first_of("#%")));
    row >> std::ws;
    if (row.eof()) continue;
    double x = 0, y = 0, angle = 0;
    if (!(row >> x >> y >> angle) || !(row >> std::ws).eof()) {
      throw Error(fmt::format("{}:{}: expected 'x y angle'", file, number));
    }
    poses.emplace_back(x, y, 0, angle, 0, 0);
  }
  return poses;
}

std::vector<CPose3D> read_by_id(const std::string& file, const std::vector<Key>& poses) {
  const PoseGraph graph = read_graph(file);
  const Values values = graph.values.empty() ? initialize_from_odometry(graph) : graph.values;
  std::vector<CPose3D> rows;
  for (Key key : poses) {
    if (!values.contains(key)) {
      throw Error(fmt::format("{}: has no pose for vertex {}", file, key.index()));
    }
    rows.push_back(to_mrpt(values, key));
  }
  return rows;
}

constexpr double kLongestGap = 2.0;  // seconds between true poses that are interpolated

/// All numbers of a file, by row; commas count as blanks.
std::vector<std::vector<double>> read_numbers(const std::string& file, std::size_t columns) {
  std::ifstream in(file);
  if (!in) throw Error(file + ": cannot be read");
  std::vector<std::vector<double>> rows;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream text(line.substr(0, line.find_first_of("#%")));
    text >> std::ws;
    if (text.eof()) continue;
    std::vector<double> row(columns);
    for (double& value : row) text >> value;
    if (!text || !(text >> std::ws).eof()) {
      throw Error(fmt::format("{}:{}: expected {} numbers", file, number, columns));
    }
    if (!rows.empty() && !(row[0] >= rows.back()[0])) {
      throw Error(fmt::format("{}:{}: times must rise", file, number));
    }
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw Error(file + ": holds no row");
  return rows;
}

/// Between two rows `time x y angle`.
CPose3D interpolate(const std::vector<double>& a, const std::vector<double>& b, double time) {
  const double share = b[0] > a[0] ? (time - a[0]) / (b[0] - a[0]) : 0.0;
  const double turn = std::remainder(b[3] - a[3], 2.0 * M_PI);
  return {a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2]), 0, a[3] + share * turn, 0, 0};
}

std::vector<CPose3D> read_rows(const std::string& file, const std::vector<Key>& poses) {
  const std::string line = first_line(file);
  if (std::isalpha(static_cast<unsigned char>(line[0])) != 0) return read_by_id(file, poses);
  if (std::filesystem::path(file).extension() == ".tum") {
    std::vector<CPose3D> rows;
    for (const TimedPose& pose : read_tum(file)) rows.push_back(pose.pose);
    return rows;
  }
  return count_words(line) == 3 ? read_planar(file) : read_true_path(file);
}

}  // namespace

CPose3D to_mrpt(const Values& values, Key key) {
  if (values.type(key) == Variable<SE2>::type()) {
    const SE2 pose = values.at<SE2>(key);
    return {pose.x(), pose.y(), 0, pose.angle(), 0, 0};
  }
  const SE3 pose = values.at<SE3>(key);
  return CPose3D::FromRotationAndTranslation(pose.rotation().quaternion().toRotationMatrix(),
                                             pose.translation());
}

std::map<Key, CPose3D> read_true_poses(const std::string& file, const std::string& times_file,
                                       const std::vector<Key>& poses) {
  std::map<Key, CPose3D> result;
  if (times_file.empty()) {
    const std::vector<CPose3D> rows = read_rows(file, poses);
    if (rows.size() != poses.size()) {
      throw Error(fmt::format("{}: has {} poses, the graph {}", file, rows.size(), poses.size()));
    }
    for (std::size_t i = 0; i < poses.size(); ++i) result.emplace(poses[i], rows[i]);
    return result;
  }
  const auto rows = read_numbers(file, 4);
  const auto times = read_numbers(times_file, 1);
  if (times.size() != poses.size()) {
    throw Error(fmt::format("{}: has {} times, the graph {} poses", times_file, times.size(),
                            poses.size()));
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const double time = times[i][0];
    const auto after = std::lower_bound(rows.begin(), rows.end(), time,
                                        [](const auto& row, double t) { return row[0] < t; });
    if (after == rows.begin() || after == rows.end()) continue;
    if ((*after)[0] - (*(after - 1))[0] > kLongestGap) continue;
    result.emplace(poses[i], interpolate(*(after - 1), *after, time));
  }
  if (result.empty())
    throw Error(fmt::format("{}: no true pose at any time of {}", file, times_file));
  return result;
}

std::vector<PosePair> pair_with_truth(const std::string& file, const std::vector<Key>& poses,
                                      const Values& estimate) {
  const std::map<Key, CPose3D> rows = read_true_poses(file, "", poses);
  std::vector<PosePair> pairs;
  const CPose3D first = to_mrpt(estimate, poses.front());
  for (Key key : poses) {
    pairs.push_back({to_mrpt(estimate, key), first + (rows.at(key) - rows.at(poses.front()))});
  }
  return pairs;
}

}  // namespace hybrid
