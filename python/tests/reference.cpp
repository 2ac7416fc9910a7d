// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Prints the results of a few problems with all bits of every number. python/tests/test_bits.py
// states the same problems in Python and expects the same text.
#include <cmath>
#include <cstdio>

#include "libhybrid/baselines/gnc.h"
#include "libhybrid/closures/objective_bound.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/hybrid.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/registration/register.h"
#include "libhybrid/solvers/certificate.h"

namespace {

using namespace hybrid;

void print(const char* name, const double* x, std::size_t n) {
  std::printf("%s", name);
  for (std::size_t i = 0; i < n; ++i) std::printf(" %a", x[i]);
  std::printf("\n");
}

void print(const Values& values) {
  for (const Key key : values.keys()) {
    print(to_string(key).c_str(), values.data(key), values.type(key).size);
  }
}

/// A square of 4 m side, driven twice, with bearing-range landmarks that have a class.
struct World {
  HybridGraph graph;
  Estimate initial;

  World() {
    const Noise motion = Noise::diagonal(Eigen::Vector3d(0.05, 0.04, 0.01));
    const Noise polar = Noise::diagonal(Eigen::Vector2d(0.1, 0.02));
    graph.emplace<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 0.001));
    SE2 pose;
    initial.values.insert(Key('x', 0), pose);
    for (int i = 0; i < 8; ++i) {
      const SE2 step(1.0 + 0.01 * i, 0.02 * i, i % 2 == 0 ? 0.0 : 1.55);
      graph.emplace<BetweenSE2>(Key('x', i), Key('x', i + 1), step, motion);
      pose = pose * step * SE2(0.05, -0.03, 0.04);
      initial.values.insert(Key('x', i + 1), pose);
    }
    for (int k = 0; k < 3; ++k) {
      const DiscreteKey kind{Key('s', k), 2};
      initial.values.insert(Key('l', k), Eigen::Vector2d(1.0 + k, 2.0));
      initial.assignment.set(kind.key, 0);
      for (int i = k; i < 9; i += 2) {
        const Eigen::Vector2d z(2.0 + 0.1 * i, 0.5 - 0.2 * k);
        graph.add(make_semantic_bearing_range<SE2>(Key('x', i), Key('l', k), kind, z, polar,
                                                   {0.3 + 0.1 * k, 0.4}));
      }
    }
    const auto loop =
        std::make_shared<Between<SE2>>(Key('x', 0), Key('x', 8), SE2(0.1, 0.2, 0.05), motion);
    initial.assignment.set(Key('d', 0), 0);
    const auto wide = std::make_shared<Inflated>(loop, 1e7);
    graph.add(make_outlier_mixture({Key('d', 0), 2}, loop, wide, 0.9, 0.1));
  }
};

void batch(const World& world) {
  const AlternatingResult result = alternate(world.graph, world.initial);
  print(result.estimate.values);
  const double numbers[] = {result.report.objective, result.report.cost};
  print("objective", numbers, 2);
  const ContinuousMarginals marginals(world.graph, result.estimate);
  print("covariance", marginals.covariance(Key('x', 8)).data(), 9);
  const double evidence = log_evidence(world.graph, result.estimate).log.value();
  print("evidence", &evidence, 1);
  const AssignmentPosterior p = posterior(world.graph, result.estimate, {Key('d', 0)});
  print("posterior", p.at(Key('d', 0)).p.data(), 2);
  print("classes", discrete_marginals(world.graph, result.estimate.values).at(Key('s', 2)).data(),
        2);
}

void online(const World& world) {
  IncrementalSmoother smoother;
  Delta delta;
  world.graph.continuous().for_each([&](Handle, const auto& f) { delta.continuous.push_back(f); });
  world.graph.hybrid().for_each([&](Handle, const auto& f) { delta.hybrid.push_back(f); });
  delta.values = world.initial.values;
  smoother.update(delta);
  print(smoother.values());
  smoother.converge();
  print(smoother.values());
  print("joint", smoother.joint_covariance({Key('x', 3), Key('l', 1)}).data(), 25);
}

/// What is proven of a result of which the first closure is accepted.
void prove(const RobustProblem& problem, const RobustResult& result) {
  const std::vector<bool> accepted = accepted_closures(result.decisions);
  const ObjectiveBound bound = bound_objective(problem, result.values, accepted, {}, 20);
  const double bounds[] = {bound.bound, bound.gap, double(bound.solves), double(bound.complete)};
  print("bound", bounds, 4);
  std::vector<ContinuousFactorPtr> factors = problem.trusted;
  factors.push_back(problem.closures[0]);
  const Certificate found = certify(factors, result.values);
  const double proof[] = {found.min_eigenvalue, found.relative_gap, found.cost,
                          double(found.verified)};
  print("certificate", proof, 4);
}

/// A 3-D ring with two closures across it, one of them false.
void robust() {
  PoseGraph graph;
  const Noise noise = Noise::isotropic(6, 0.02);
  const auto turn = [](double a) { return SO3::exp({0.01, 0.02, a}); };
  for (int i = 0; i < 12; ++i) {
    graph.poses3.push_back(
        {Key('x', i), Key('x', i + 1), SE3({1.0, 0.01 * i, 0.0}, turn(0.5)), noise});
  }
  const Values start = initialize_from_odometry(graph);
  const SE3 across = start.at<SE3>(Key('x', 1)).between(start.at<SE3>(Key('x', 11)));
  graph.poses3.push_back(
      {Key('x', 1), Key('x', 11), across * SE3({0.01, 0.0, 0.02}, SO3()), noise});
  graph.poses3.push_back({Key('x', 0), Key('x', 6), SE3({9.0, 9.0, 9.0}, SO3()), noise});
  const RobustProblem problem = to_robust_problem(graph, start);
  for (const RobustResult& result : {select_closures(problem), solve_gnc(problem)}) {
    print(result.values);
    const double numbers[] = {result.objective, result.cost, double(result.decisions[0].accepted()),
                              double(result.decisions[1].accepted())};
    print("robust", numbers, 4);
    prove(problem, result);
  }
}

void clouds() {
  Points source, target;
  const SE3 T({0.05, -0.02, 0.03}, SO3::exp({0.02, 0.01, -0.03}));
  for (int i = 0; i < 30; ++i) {
    for (int j = 0; j < 30; ++j) {
      const double x = 0.1 * i, y = 0.1 * j;
      source.emplace_back(x, y, 0.125 * (x * x - y) + 0.25 * x * y * y);
      target.push_back(T * source.back());
    }
  }
  const RegistrationResult result = register_clouds(source, target);
  double x[SE3::kSize];
  result.T_target_source.store(x);
  print("T", x, SE3::kSize);
  print("rms", &result.rms, 1);
}

}  // namespace

int main() {
  const World world;
  batch(world);
  online(world);
  robust();
  clouds();
}
