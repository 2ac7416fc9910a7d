// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>

#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/pose_graph/breaks.h"
#include "libhybrid/pose_graph/vertex_id.h"
#include "libhybrid/solvers/starts.h"

namespace hybrid {
namespace {

constexpr std::size_t kNamed = 10;  // most vertices listed in a message

/// Ids of the keys missing from `values`, as text; empty if there are none.
std::string missing_text(const std::vector<Key>& keys, const Values& values) {
  std::vector<Key> missing;
  for (Key key : keys) {
    if (!values.contains(key)) missing.push_back(key);
  }
  std::sort(missing.begin(), missing.end());
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, missing.size()); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ", ", vertex_name(missing[i].index()));
  }
  if (missing.size() > kNamed) text += fmt::format(", ... ({} in all)", missing.size());
  return text;
}

/// Tells closures from odometry. Where they are in question, odometry that says nothing is one.
void find_closures(bool in_question, Input& input) {
  const OdometryEdges is_odometry(input.graph);
  const std::vector<bool> is_break =
      in_question ? bound_breaks(input.graph) : std::vector<bool>(input.graph.edge_count());
  const auto add = [&](const auto& edges) {
    for (const auto& edge : edges) {
      const bool breaks = is_break[input.is_closure.size()];
      input.is_closure.push_back(breaks || !is_odometry(edge.from, edge.to));
      if (!breaks) continue;
      input.breaks.push_back(
          fmt::format("{} {}", vertex_name(edge.from.index()), vertex_name(edge.to.index())));
    }
  };
  add(input.graph.poses2);
  add(input.graph.poses3);
}

}  // namespace

std::vector<Key> Input::poses() const {
  std::vector<Key> poses;
  for (Key key : initial.keys()) {
    if (key.letter() == key_letter::kPose) poses.push_back(key);
  }
  std::sort(poses.begin(), poses.end());
  return poses;
}

Input read_input(const std::string& path, const std::string& start,
                 std::optional<std::uint64_t> shuffle, bool repair_information, bool in_question) {
  Input input;
  try {
    input.graph = read_graph(path, {repair_information});
  } catch (const InformationError& e) {
    throw Error(fmt::format("{}{}", e.what(),
                            repair_information ? ""
                                               : "; --repair-information takes the nearest "
                                                 "matrix that is"));
  }
  if (in_question) erase_copies(input.graph);
  find_closures(in_question, input);
  if (shuffle) {
    if (input.graph.alternatives_count() == 0) {
      throw Error(path + ": has no edge with several hypotheses; leave --shuffle out");
    }
    input.first_hypotheses = shuffle_hypotheses(input.graph, *shuffle);
  }
  input.first_hypotheses.resize(input.graph.alternatives_count());
  try {
    input.initial = initialize_from_odometry(input.graph);  // throws if not connected
  } catch (const Error& e) {
    throw Error(
        fmt::format("{}: {}; a graph of several parts has no common frame", path, e.what()));
  }
  if (input.poses().empty()) throw Error(path + ": holds no pose");
  input.start = "odometry";
  if (start == "auto" || start == "file") {
    const std::string missing = missing_text(input.initial.keys(), input.graph.values);
    if (missing.empty()) {
      input.initial = input.graph.values;
      input.start = "file";
    } else if (start == "file") {
      throw Error(
          fmt::format("{}: has no VERTEX line for vertex {}; use --start odometry", path, missing));
    }
  }
  input.factors = to_factors(input.graph, input.initial);
  if (start == "chordal" || start == "tree") {
    input.initial = pose_graph_start(input.graph, start);
  }
  if (start != "auto") input.start = start;
  return input;
}

}  // namespace hybrid
