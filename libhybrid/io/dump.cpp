// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/detail/dump.h"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

namespace hybrid {
namespace {

void write_handle(std::ostream& out, Handle handle) {
  static constexpr char kKind[] = {'c', 'd', 'h'};
  out << kKind[static_cast<int>(handle.kind)] << '#' << handle.index << '.' << handle.generation
      << ' ';
}

void write_discrete(std::ostream& out, const std::vector<DiscreteKey>& keys) {
  for (const DiscreteKey& key : keys) out << ' ' << key.key << ':' << key.cardinality;
}

}  // namespace

std::string dump(const HybridGraph& graph, const Estimate* estimate) {
  std::ostringstream out;
  graph.continuous().for_each([&](Handle handle, const ContinuousFactorPtr& factor) {
    write_handle(out, handle);
    out << factor->name();
    for (Key key : factor->keys()) out << ' ' << key;
    if (estimate != nullptr) out << " cost " << factor->cost(estimate->values);
    out << '\n';
  });
  graph.discrete().for_each([&](Handle handle, const Table& table) {
    write_handle(out, handle);
    out << "table";
    write_discrete(out, table.keys());
    if (estimate != nullptr) out << " cost " << table.cost(estimate->assignment);
    out << '\n';
  });
  graph.hybrid().for_each([&](Handle handle, const HybridFactorPtr& factor) {
    write_handle(out, handle);
    out << factor->name();
    for (Key key : factor->keys()) out << ' ' << key;
    out << " |";
    write_discrete(out, factor->discrete_keys());
    if (estimate != nullptr) {
      const Component component = factor->given(estimate->assignment);
      out << " component " << component.index << (component.weak ? " (weak)" : "") << " cost "
          << factor->cost(estimate->values, estimate->assignment);
    }
    out << '\n';
  });
  return out.str();
}

std::string dump(const Estimate& estimate) {
  std::ostringstream out;
  std::vector<Key> keys = estimate.values.keys();
  std::sort(keys.begin(), keys.end());
  for (Key key : keys) {
    const VariableType type = estimate.values.type(key);
    out << key << ' ' << to_string(type) << ':';
    if (type == Variable<SE2>::type()) {
      const SE2 pose = estimate.values.at<SE2>(key);
      out << ' ' << pose.x() << ' ' << pose.y() << ' ' << pose.angle();
    } else if (type == Variable<SO2>::type()) {
      out << ' ' << estimate.values.at<SO2>(key).angle();
    } else {
      const double* x = estimate.values.data(key);
      for (int i = 0; i < type.size; ++i) out << ' ' << x[i];
    }
    out << '\n';
  }
  std::vector<std::pair<Key, int>> discrete(estimate.assignment.begin(), estimate.assignment.end());
  std::sort(discrete.begin(), discrete.end());
  for (const auto& [key, value] : discrete) out << key << " = " << value << '\n';
  return out.str();
}

}  // namespace hybrid
