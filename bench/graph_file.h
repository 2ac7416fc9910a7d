// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <fstream>
#include <sstream>
#include <string>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"

namespace hybrid {

struct BenchGraph {
  HybridGraph graph;
  Estimate initial;
};

inline BenchGraph read_bench_graph(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw Error("cannot open " + file);
  BenchGraph g;
  std::vector<std::pair<std::pair<int, int>, SE3>> motions;
  std::vector<std::pair<std::pair<int, int>, SE2>> motions2;
  std::string line, tag;
  while (std::getline(in, line)) {
    std::istringstream s(line);
    s >> tag;
    int i, j;
    if (tag == "VERTEX_SE2") {
      double x, y, t;
      s >> i >> x >> y >> t;
      g.initial.values.insert(Key{'x', std::uint64_t(i)}, SE2(x, y, t));
    } else if (tag == "VERTEX_SE3:QUAT") {
      Eigen::Vector3d t;
      Eigen::Quaterniond q;
      s >> i >> t[0] >> t[1] >> t[2] >> q.x() >> q.y() >> q.z() >> q.w();
      g.initial.values.insert(Key{'x', std::uint64_t(i)}, SE3(t, q.normalized()));
    } else if (tag == "EDGE_SE2") {
      double x, y, t;
      Eigen::Matrix3d m;
      s >> i >> j >> x >> y >> t;
      for (int a = 0; a < 3; ++a)
        for (int b = a; b < 3; ++b) s >> m(a, b), m(b, a) = m(a, b);
      g.graph.emplace<BetweenSE2>(Key{'x', std::uint64_t(i)}, Key{'x', std::uint64_t(j)},
                                  SE2(x, y, t), Noise::information(m));
      motions2.push_back({{i, j}, SE2(x, y, t)});
    } else if (tag == "EDGE_SE3:QUAT") {
      Eigen::Vector3d t;
      Eigen::Quaterniond q;
      Eigen::Matrix<double, 6, 6> m;
      s >> i >> j >> t[0] >> t[1] >> t[2] >> q.x() >> q.y() >> q.z() >> q.w();
      for (int a = 0; a < 6; ++a)
        for (int b = a; b < 6; ++b) s >> m(a, b), m(b, a) = m(a, b);
      // g2o's rotation error is half the rotation vector.
      g.graph.emplace<Between<SE3>>(Key{'x', std::uint64_t(i)}, Key{'x', std::uint64_t(j)},
                                    SE3(t, q.normalized()), Noise::information(m));
    }
  }
  if (g.initial.values.empty()) {
    g.initial.values.insert(Key{'x', 0}, SE2());
    for (auto& [ij, z] : motions2) {
      const Key b{'x', std::uint64_t(ij.second)}, a{'x', std::uint64_t(ij.first)};
      if (!g.initial.values.contains(b)) g.initial.values.insert(b, g.initial.values.at<SE2>(a) * z);
    }
  }
  const Key first{'x', 0};
  if (g.initial.values.type(first).kind == VariableKind::kSE2) {
    g.graph.emplace<Prior<SE2>>(first, g.initial.values.at<SE2>(first), Noise::isotropic(3, 1e-2));
  } else {
    g.graph.emplace<Prior<SE3>>(first, g.initial.values.at<SE3>(first), Noise::isotropic(6, 1e-2));
  }
  return g;
}

}  // namespace hybrid
