// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/plaza.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "mrpt_plugins/input/text_table.h"

namespace hybrid {
namespace {

struct BeaconRange {
  double range, sigma;
  std::optional<std::int64_t> beacon;  // none: one of several
};

/// A pose of the graph, and what leads to it and is seen from it.
struct GraphPose {
  mrpt::poses::CPose3D truth;
  std::optional<OdometryIncrement> motion;
  std::vector<BeaconRange> ranges;
};

struct Graph {
  std::vector<GraphPose> poses;
  std::map<std::int64_t, Eigen::Vector2d> beacons;
};

/// The number in "X12" or "L3".
std::int64_t index_of(const TextRow& row, std::size_t column, char kind) {
  const std::string& word = row.words[column];
  const bool digits = word.size() > 1 && std::all_of(word.begin() + 1, word.end(),
                                                     [](char c) { return c >= '0' && c <= '9'; });
  if (word[0] != kind || !digits || word.size() > 9) {
    row.fail(fmt::format("column {}: '{}' is not a variable {}0, {}1, ...", column + 1, word, kind,
                         kind));
  }
  return std::stoll(word.substr(1));
}

GraphPose& pose_of(const TextRow& row, std::size_t column, Graph& graph) {
  const auto i = static_cast<std::size_t>(index_of(row, column, 'X'));
  if (i >= graph.poses.size()) row.fail(fmt::format("no variable {}", row.words[column]));
  return graph.poses[i];
}

void read_variable(const TextRow& row, Graph& graph) {
  row.expect_columns(6, 7, "Variable Pose SE2 Xi x y angle, or Variable Landmark R2 Li x y");
  if (row.words[1] == "Landmark") {
    graph.beacons[index_of(row, 3, 'L')] = {row.number(4), row.number(5)};
    return;
  }
  row.expect_columns(7, 7, "Variable Pose SE2 Xi x y angle");
  if (index_of(row, 3, 'X') != static_cast<std::int64_t>(graph.poses.size())) {
    row.fail("poses out of order");
  }
  graph.poses.push_back(
      {mrpt::poses::CPose3D(row.number(4), row.number(5), 0, row.number(6), 0, 0), {}, {}});
}

void read_motion(const TextRow& row, Graph& graph) {
  row.expect_columns(17, 17, "Factor SE2Relative... Xi Xj x y angle covariance and 9 numbers");
  if (index_of(row, 3, 'X') != index_of(row, 2, 'X') + 1) row.fail("not from a pose to the next");
  Eigen::Matrix3d covariance;
  for (int i = 0; i < 9; ++i)
    covariance(i / 3, i % 3) = row.number(8 + static_cast<std::size_t>(i));
  pose_of(row, 3, graph).motion =
      planar_motion(row.number(4), row.number(5), row.number(6), covariance);
}

/// Column of a word, or Error.
std::size_t find_word(const TextRow& row, const char* word) {
  const auto it = std::find(row.words.begin(), row.words.end(), word);
  if (it == row.words.end() || it + 1 == row.words.end()) {
    row.fail(fmt::format("no '{}' with a value", word));
  }
  return static_cast<std::size_t>(it - row.words.begin());
}

void read_ambiguous_range(const TextRow& row, Graph& graph, LogWriter& log) {
  row.expect_columns(12, 1000,
                     "Factor Ambiguous... Observer Xi Observed L... Observation r Sigma s");
  const std::size_t first = find_word(row, "Observed") + 1, last = find_word(row, "Weights");
  for (std::size_t i = first; i < last; ++i) {
    if (graph.beacons.count(index_of(row, i, 'L')) == 0) row.fail("range to an unknown beacon");
  }
  if (last - first < graph.beacons.size()) {
    log.drop("hypotheses widened: range to some of the beacons, taken as one to any");
  }
  pose_of(row, 3, graph)
      .ranges.push_back({row.number(find_word(row, "Observation") + 1),
                         row.number(find_word(row, "Sigma") + 1), std::nullopt});
}

Graph read_graph(const std::string& path, LogWriter& log) {
  Graph graph;
  TextTable table(path);
  while (const auto row = table.next()) {
    row->expect_columns(6, 1000, "Variable ... or Factor ...");
    const std::string& kind = row->words[1];
    if (row->words[0] == "Variable") {
      read_variable(*row, graph);
    } else if (kind == "SE2RelativeGaussianLikelihoodFactor") {
      read_motion(*row, graph);
    } else if (kind == "SE2R2RangeGaussianLikelihoodFactor") {
      pose_of(*row, 2, graph)
          .ranges.push_back({row->number(4), row->number(5), index_of(*row, 3, 'L')});
    } else if (kind == "AmbiguousDataAssociationFactor") {
      read_ambiguous_range(*row, graph, log);
    } else if (kind.find("Prior") == std::string::npos) {
      row->fail(fmt::format("unknown factor {}", kind));
    }
  }
  return graph;
}

/// The beacon of a range of the same length at the same pose of the graph with all identities.
std::optional<std::int64_t> true_beacon(const BeaconRange& range, const GraphPose& known) {
  for (const BeaconRange& r : known.ranges) {
    if (std::abs(r.range - range.range) < 1e-6) return r.beacon;
  }
  return std::nullopt;
}

}  // namespace

ImportReport import_plaza(const PlazaOptions& options, const std::string& output) {
  LogWriter log(output);
  const Graph graph = read_graph(options.graph, log);
  const Graph known = options.identities.empty() ? Graph() : read_graph(options.identities, log);
  for (std::size_t i = 0; i < graph.poses.size(); ++i) {
    const GraphPose& pose = graph.poses[i];
    auto seen = mrpt::obs::CObservationBeaconRanges::Create();
    seen->sensorLabel = "RADIO";
    seen->maxSensorDistance = 0;
    for (const BeaconRange& range : pose.ranges) {
      mrpt::obs::CObservationBeaconRanges::TMeasurement m;
      m.sensedDistance = static_cast<float>(range.range);
      m.beaconID =
          range.beacon ? static_cast<std::int32_t>(*range.beacon) : mrpt::obs::INVALID_BEACON_ID;
      seen->stdError = static_cast<float>(range.sigma);
      const auto id = range.beacon || i >= known.poses.size() ? range.beacon
                                                              : true_beacon(range, known.poses[i]);
      if (id) log.true_association(seen->sensedData.size(), *id);
      seen->sensedData.push_back(m);
    }
    std::optional<OdometryIncrement> motion = pose.motion;
    if (motion) {
      const Eigen::Vector3d factor(options.inflate, options.inflate, 1);
      const Eigen::Matrix3d stated = planar_part(motion->covariance);
      motion->covariance = planar_to_6d(factor.asDiagonal() * stated * factor.asDiagonal());
    }
    log.add({static_cast<double>(i) * options.period, motion, {seen}, pose.truth});
  }
  for (const auto& [id, place] : graph.beacons) log.true_landmark(id, {place.x(), place.y(), 0});
  return log.finish();
}

}  // namespace hybrid
