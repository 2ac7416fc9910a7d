// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/plaza.h"

#include <fmt/format.h>
#include <mrpt/obs/CObservationBeaconRanges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "libhybrid/io/escaped.h"
#include "libhybrid/io/parse_number.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/detail/stated_noise.h"

namespace hybrid {
namespace {

struct BeaconRange {
  double range, sigma;
  std::optional<std::int64_t> beacon;  // none: ambiguous between several
};

/// A pose of the graph, with the motion to it and the ranges measured there.
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
  const std::string_view word = row[column];
  std::uint32_t index = 0;
  if (word.substr(0, 1) != std::string_view(&kind, 1) || !parse_number(word.substr(1), index)) {
    row.fail(column,
             fmt::format("{} is not a variable {}0, {}1, ...", in_quotes(word), kind, kind));
  }
  return index;
}

GraphPose& pose_of(const TextRow& row, std::size_t column, Graph& graph) {
  const auto i = static_cast<std::size_t>(index_of(row, column, 'X'));
  if (i >= graph.poses.size()) row.fail(column, "no variable " + in_quotes(row[column]));
  return graph.poses[i];
}

void read_variable(const TextRow& row, Graph& graph) {
  if (row[1] == "Landmark") {
    row.expect(6, "Variable Landmark R2 Li x y");
    graph.beacons[index_of(row, 3, 'L')] = {row.coordinate(4), row.coordinate(5)};
    return;
  }
  row.expect(7, "Variable Pose SE2 Xi x y angle, or Variable Landmark R2 Li x y");
  if (index_of(row, 3, 'X') != static_cast<std::int64_t>(graph.poses.size())) {
    row.fail(3, "poses out of order");
  }
  graph.poses.push_back(
      {mrpt::poses::CPose3D(row.coordinate(4), row.coordinate(5), 0, row.coordinate(6), 0, 0),
       {},
       {}});
}

void read_motion(const TextRow& row, Graph& graph) {
  row.expect(17, "Factor SE2Relative... Xi Xj x y angle covariance and 9 numbers");
  if (index_of(row, 3, 'X') != index_of(row, 2, 'X') + 1)
    row.fail(3, "not from a pose to the next");
  Eigen::Matrix3d covariance;
  for (int i = 0; i < 9; ++i)
    covariance(i / 3, i % 3) = row.number(8 + static_cast<std::size_t>(i));
  check_covariance(row, 8, covariance);
  pose_of(row, 3, graph).motion =
      planar_motion(row.coordinate(4), row.coordinate(5), row.coordinate(6), covariance);
}

/// Reads a range to one of n beacons: 12 + 2n words.
void read_ambiguous_range(const TextRow& row, Graph& graph, LogWriter& log) {
  constexpr const char* kForm =
      "Factor Ambiguous... Observer Xi Observed L... Weights w... Binary ... Observation r Sigma s";
  const std::size_t n = row.size() < 12 ? 0 : (row.size() - 12) / 2;
  if (n == 0 || row.size() != 12 + 2 * n || row[2] != "Observer" || row[4] != "Observed" ||
      row[5 + n] != "Weights" || row[8 + 2 * n] != "Observation" || row[10 + 2 * n] != "Sigma") {
    row.fail(std::string("expected: ") + kForm);
  }
  for (std::size_t i = 5; i < 5 + n; ++i) {
    if (graph.beacons.count(index_of(row, i, 'L')) == 0) row.fail(i, "range to an unknown beacon");
  }
  row.numbers(6 + n, 6 + 2 * n);
  if (n < graph.beacons.size()) {
    log.drop("hypotheses widened: range to some of the beacons, taken as one to any");
  }
  pose_of(row, 3, graph)
      .ranges.push_back({row.coordinate(9 + 2 * n), stated_sigma(row, 11 + 2 * n), std::nullopt});
}

Graph read_graph(const std::string& path, LogWriter& log) {
  Graph graph;
  TextReader table(path);
  while (const auto row = table.next()) {
    row->expect(6, row->size(), "Variable ... or Factor ...");
    const std::string_view kind = (*row)[1];
    if ((*row)[0] == "Variable") {
      read_variable(*row, graph);
    } else if (kind == "SE2RelativeGaussianLikelihoodFactor") {
      read_motion(*row, graph);
    } else if (kind == "SE2R2RangeGaussianLikelihoodFactor") {
      row->expect(6, "Factor SE2R2Range... Xi Lj range sigma");
      pose_of(*row, 2, graph)
          .ranges.push_back({row->coordinate(4), stated_sigma(*row, 5), index_of(*row, 3, 'L')});
    } else if (kind == "AmbiguousDataAssociationFactor") {
      read_ambiguous_range(*row, graph, log);
    } else if (kind.find("Prior") == std::string::npos) {
      row->fail(1, "unknown factor " + in_quotes(kind));
    }
  }
  return graph;
}

/// The beacon of the equal range at the same pose in the graph with known identities.
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
    log.used(static_cast<double>(i + 1) / static_cast<double>(graph.poses.size()));
    log.add({static_cast<double>(i) * options.period, motion, {seen}, pose.truth});
  }
  log.note_end(options.graph);
  if (!options.identities.empty()) log.note_end(options.identities);
  for (const auto& [id, place] : graph.beacons) log.true_landmark(id, {place.x(), place.y(), 0});
  return log.finish();
}

}  // namespace hybrid
