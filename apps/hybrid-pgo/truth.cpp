// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/truth.h"

#include <fmt/format.h>

#include <cctype>
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

std::vector<PosePair> pair_with_truth(const std::string& file, const std::vector<Key>& poses,
                                      const Values& estimate) {
  const std::vector<CPose3D> rows = read_rows(file, poses);
  if (rows.size() != poses.size()) {
    throw Error(fmt::format("{}: has {} poses, the graph {}", file, rows.size(), poses.size()));
  }
  std::vector<PosePair> pairs;
  const CPose3D first = to_mrpt(estimate, poses.front());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    pairs.push_back({to_mrpt(estimate, poses[i]), first + (rows[i] - rows.front())});
  }
  return pairs;
}

}  // namespace hybrid
