// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// What crosses the border of the shared library: classes derived here and used there, classes made
// there and recognised here, exceptions, and matrices allocated on one side and freed on the other.
#include <iostream>
#include <memory>

#include "libhybrid/hybrid.h"

namespace {

using namespace hybrid;

/// A level that is measured to be the square of a number.
class Square : public FactorOf<1, double> {
 public:
  Square(Key x, double measured) : FactorOf({x}, Noise::isotropic(1, 0.1)), measured_(measured) {}
  std::string name() const override { return "square"; }
  Residual evaluate(const double& x, Jacobian<double>* J) const override {
    if (J != nullptr) (*J)(0, 0) = 2 * x;
    return Residual(x * x - measured_);
  }

 private:
  double measured_;
};

int failures = 0;

void expect(bool holds, const char* what) {
  if (holds) return;
  ++failures;
  std::cerr << "not so: " << what << '\n';
}

}  // namespace

int main() {
  const Key x('x', 0), a('a', 0), b('a', 1);
  HybridGraph graph;
  graph.emplace<Square>(x, 9.0);
  Estimate initial;
  initial.values.insert(x, 2.0);
  const SolverResult result = levenberg_marquardt(graph, initial);
  expect(std::abs(result.values.at<double>(x) - 3) < 1e-6, "the library solves a factor of ours");
  expect(ContinuousMarginals(graph, {result.values, {}}).covariance(x).rows() == 1,
         "a matrix of the library is freed here");

  const auto loop = std::make_shared<BetweenSE2>(a, b, SE2(1, 0, 0), Noise::isotropic(3, 0.1));
  const HybridFactorPtr mixture = make_outlier_mixture({{'d', 0}, 2}, loop, loop, 0.9, 0.1);
  expect(dynamic_cast<const Mixture*>(mixture.get()) != nullptr,
         "a class made in the library is known here");

  bool thrown = false;
  try {
    initial.values.at<SE2>(Key('z', 9));
  } catch (const Error& error) {
    thrown = std::string(error.what()).find("z9") != std::string::npos;
  }
  expect(thrown, "an exception of the library is caught here by its type");
  return failures;
}
