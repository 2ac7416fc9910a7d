// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Time of a cost evaluation and of a linearisation of every factor, over a working set of 256
// factors that fits into the second-level cache. Two of them also by AutoDiffFactor.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "libhybrid/factors/auto_diff_factor.h"
#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/range.h"
#include "tests/support/random.h"

namespace {

using namespace hybrid;
using Eigen::Vector2d;
using Eigen::Vector3d;
using hybrid::testing::Random;

constexpr int kCount = 256;

/// The residual of BetweenSE2 on stored poses: x, y, cos, sin.
struct Motion {
  SE2 z;

  template <class S>
  Eigen::Matrix<S, 3, 1> operator()(const Eigen::Matrix<S, 4, 1>& a,
                                    const Eigen::Matrix<S, 4, 1>& b) const {
    using std::atan2;
    const S dx = b[0] - a[0], dy = b[1] - a[1];
    const S x = a[2] * dx + a[3] * dy - z.x(), y = a[2] * dy - a[3] * dx - z.y();
    const S cos = a[2] * b[2] + a[3] * b[3], sin = a[2] * b[3] - a[3] * b[2];
    const double c = z.rotation().cos(), s = z.rotation().sin();
    return {c * x + s * y, c * y - s * x, atan2(c * sin - s * cos, c * cos + s * sin)};
  }
};
using AutoBetween = AutoDiffFactor<3, Motion, SE2, SE2>;

/// The residual of BearingRange<SE2>.
struct Sighting {
  Vector2d z;

  template <class S>
  Eigen::Matrix<S, 2, 1> operator()(const Eigen::Matrix<S, 4, 1>& pose,
                                    const Eigen::Matrix<S, 2, 1>& point) const {
    using std::atan2;
    using std::sqrt;
    const S dx = point[0] - pose[0], dy = point[1] - pose[1];
    const S x = pose[2] * dx + pose[3] * dy, y = pose[2] * dy - pose[3] * dx;
    const double c = std::cos(z[1]), s = std::sin(z[1]);
    return {sqrt(x * x + y * y) - z[0], atan2(c * y - s * x, c * x + s * y)};
  }
};
using AutoSighting = AutoDiffFactor<2, Sighting, SE2, Vector2d>;

/// Factors and the storage of their variables, gathered as in a solver.
struct Workload {
  std::vector<ContinuousFactorPtr> factors;
  std::vector<Values> values;
  std::vector<std::vector<const double*>> x;
};

Noise make_noise(Random& random, int dim, bool full) {
  return full ? random.noise(dim, 0.1) : Noise::isotropic(dim, 0.1);
}

template <class A, class B, class Make>
Workload workload(Make&& make) {
  Random random;
  Workload w;
  w.values.reserve(kCount);
  for (int i = 0; i < kCount; ++i) {
    const A a = random.value<A>();
    const B b = random.value<B>();
    Values values;
    values.insert(Key('a', 0), a);
    values.insert(Key('b', 0), b);
    w.factors.push_back(make(random, a, b));
    w.values.push_back(std::move(values));
    w.x.push_back(gather(w.factors.back()->keys(), w.factors.back()->types(), w.values.back()));
  }
  return w;
}

void linearize(benchmark::State& state, const Workload& w) {
  double r[8];
  double J[8 * 16];
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(w.factors[i]->linearize(w.x[i].data(), r, J));
    benchmark::DoNotOptimize(J);
    i = (i + 1) % kCount;
  }
}

void cost(benchmark::State& state, const Workload& w) {
  int i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(w.factors[i]->cost(w.x[i].data()));
    i = (i + 1) % kCount;
  }
}

void add(const std::string& name, Workload w) {
  const auto shared = std::make_shared<Workload>(std::move(w));
  benchmark::RegisterBenchmark(("linearize/" + name).c_str(),
                               [shared](benchmark::State& state) { linearize(state, *shared); });
  benchmark::RegisterBenchmark(("cost/" + name).c_str(),
                               [shared](benchmark::State& state) { cost(state, *shared); });
}

/// Adds a measured motion near the true one, as in a graph that has nearly converged.
template <class Factor, class Group>
void add_between(const std::string& name, bool full) {
  add(name + (full ? "/full" : "/isotropic"),
      workload<Group, Group>([full](Random& random, const Group& a, const Group& b) {
        const Group z = a.inverse() * b * Group::exp(random.vector<Group::kDim>(0.1));
        return std::make_shared<Factor>(Key('a', 0), Key('b', 0), z,
                                        make_noise(random, Group::kDim, full));
      }));
}

template <class Pose>
void add_sensors(const std::string& suffix) {
  using Point = typename Pose::Point;
  constexpr int kDim = Point::RowsAtCompileTime;
  const Key a('a', 0);
  const Key b('b', 0);
  add("bearing-range/" + suffix, workload<Pose, Point>([=](Random& random, auto&, auto&) {
        Point z = random.vector<kDim>();
        z[0] = std::abs(z[0]);
        return std::make_shared<BearingRange<Pose>>(a, b, z, Noise::isotropic(kDim, 0.1));
      }));
  add("bearing/" + suffix, workload<Pose, Point>([=](Random& random, auto&, auto&) {
        return std::make_shared<Bearing<Pose>>(a, b, random.vector<kDim - 1>(),
                                               Noise::isotropic(kDim - 1, 0.1));
      }));
  add("range/" + suffix, workload<Pose, Point>([=](Random&, auto&, auto&) {
        return std::make_shared<Range<Pose, Point>>(a, b, 1.0, Noise::isotropic(1, 0.1));
      }));
  add("position/" + suffix, workload<Pose, Point>([=](Random& random, auto&, auto&) {
        return std::make_shared<Position<Pose>>(a, random.value<Point>(),
                                                Noise::isotropic(kDim, 0.1));
      }));
  add("prior/" + suffix, workload<Pose, Point>([=](Random& random, auto& pose, auto&) {
        return std::make_shared<Prior<Pose>>(a, pose * random.value<Pose>(0.1),
                                             Noise::isotropic(Pose::kDim, 0.1));
      }));
}

void add_auto_diff() {
  const Key a('a', 0);
  const Key b('b', 0);
  add("between-plain/SE2/auto-diff",
      workload<SE2, SE2>([=](Random& random, const SE2& from, const SE2& to) {
        const SE2 z = from.inverse() * to * SE2::exp(random.vector<3>(0.1));
        return std::make_shared<AutoBetween>(std::array<Key, 2>{a, b}, Motion{z},
                                             Noise::isotropic(3, 0.1));
      }));
  add("bearing-range/SE2/auto-diff", workload<SE2, Vector2d>([=](Random& random, auto&, auto&) {
        Vector2d z = random.vector<2>();
        z[0] = std::abs(z[0]);
        return std::make_shared<AutoSighting>(std::array<Key, 2>{a, b}, Sighting{z},
                                              Noise::isotropic(2, 0.1));
      }));
}

}  // namespace

int main(int argc, char** argv) {
  for (bool full : {false, true}) {
    add_between<BetweenSE2, SE2>("between-plain/SE2", full);
    add_between<Between<SE2>, SE2>("between/SE2", full);
    add_between<Between<SE3>, SE3>("between/SE3", full);
  }
  add_sensors<SE2>("SE2");
  add_sensors<SE3>("SE3");
  add_auto_diff();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
