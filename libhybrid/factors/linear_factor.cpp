// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/linear_factor.h"

namespace hybrid {
namespace {

std::vector<Key> keys_of(const std::vector<LinearFactor::Term>& terms) {
  std::vector<Key> keys;
  for (const LinearFactor::Term& term : terms) keys.push_back(term.key);
  return keys;
}

std::vector<VariableType> types_of(const std::vector<LinearFactor::Term>& terms) {
  std::vector<VariableType> types;
  for (const LinearFactor::Term& term : terms) {
    types.push_back(vector_type(static_cast<int>(term.A.cols())));
  }
  return types;
}

}  // namespace

LinearFactor::LinearFactor(const std::vector<Term>& terms, const Eigen::VectorXd& b,
                           const Noise& noise)
    : ContinuousFactor(keys_of(terms), types_of(terms), static_cast<int>(b.size())),
      A_(b.size(), cols()),
      log_normalizer_(noise.log_normalizer()) {
  const auto fail = [&](const std::string& why) {
    throw Error(describe(name(), keys()) + ": " + why);
  };
  if (terms.empty()) fail("it has no variable");
  if (noise.dim() != b.size()) fail("its noise has another dimension than its measurement");
  int column = 0;
  for (const Term& term : terms) {
    if (term.A.rows() != b.size() || term.A.cols() == 0) {
      fail("the matrix of " + to_string(term.key) + " does not fit its measurement");
    }
    A_.middleCols(column, term.A.cols()) = term.A;
    column += static_cast<int>(term.A.cols());
  }
  if (!A_.allFinite() || !b.allFinite()) fail("a number of it is not finite");
  A_ = (noise.sqrt_information() * A_).eval();
  b_ = noise.sqrt_information() * b;
}

Eigen::VectorXd LinearFactor::whitened_residual(const double* const* x) const {
  Eigen::VectorXd residual = -b_;
  int column = 0;
  for (std::size_t i = 0; i < types().size(); ++i) {
    const int dim = types()[i].dim;
    residual += A_.middleCols(column, dim) * Eigen::Map<const Eigen::VectorXd>(x[i], dim);
    column += dim;
  }
  return residual;
}

double LinearFactor::cost(const double* const* x) const {
  return 0.5 * whitened_residual(x).squaredNorm();
}

double LinearFactor::linearize(const double* const* x, double* r, double* J) const {
  Eigen::Map<Eigen::VectorXd> residual(r, rows());
  residual = whitened_residual(x);
  Eigen::Map<Eigen::MatrixXd>(J, rows(), cols()) = A_;
  return 0.5 * residual.squaredNorm();
}

}  // namespace hybrid
