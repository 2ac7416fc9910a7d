// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/markov.h"

#include <cmath>
#include <string>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

constexpr double kTolerance = 1e-6;

void check_probabilities(const Eigen::VectorXd& p, const std::string& what) {
  for (int i = 0; i < p.size(); ++i) {
    if (!(p[i] >= 0.0) || !std::isfinite(p[i])) {
      throw Error(what + " holds " + std::to_string(p[i]) + ", which is no probability");
    }
  }
  if (std::abs(p.sum() - 1.0) > kTolerance) {
    throw Error(what + " must sum to 1, its sum is " + std::to_string(p.sum()));
  }
}

std::vector<double> row_major(const Eigen::MatrixXd& m) {
  std::vector<double> out(m.size());
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      out.data(), m.rows(), m.cols()) = m;
  return out;
}

void check_modes(const MarkovChain& chain, DiscreteKey mode) {
  if (mode.cardinality == chain.modes()) return;
  throw Error("mode variable " + to_string(mode.key) + " has " + std::to_string(mode.cardinality) +
              " values, but the Markov chain has " + std::to_string(chain.modes()) + " modes");
}

}  // namespace

void check(const MarkovChain& chain) {
  const int n = chain.modes();
  if (n == 0) throw Error("a Markov chain needs at least one mode");
  if (chain.transition.rows() != n || chain.transition.cols() != n) {
    throw Error("the transition matrix of " + std::to_string(n) + " modes must be " +
                std::to_string(n) + " x " + std::to_string(n) + ", got " +
                std::to_string(chain.transition.rows()) + " x " +
                std::to_string(chain.transition.cols()));
  }
  check_probabilities(chain.initial, "the initial distribution of the modes");
  for (int i = 0; i < n; ++i) {
    check_probabilities(chain.transition.row(i),
                        "row " + std::to_string(i + 1) + " of the transition matrix");
  }
}

MarkovChain sticky_chain(int modes, double stay) {
  if (modes < 1) throw Error("a Markov chain needs at least one mode");
  const double leave = modes > 1 ? (1.0 - stay) / (modes - 1) : 0.0;
  MarkovChain chain;
  chain.initial = Eigen::VectorXd::Constant(modes, 1.0 / modes);
  chain.transition = Eigen::MatrixXd::Constant(modes, modes, leave);
  chain.transition.diagonal().setConstant(modes > 1 ? stay : 1.0);
  check(chain);
  return chain;
}

std::vector<Table> chain_tables(const MarkovChain& chain, const std::vector<DiscreteKey>& modes) {
  check(chain);
  std::vector<Table> tables;
  tables.reserve(modes.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    check_modes(chain, modes[i]);
    if (i > 0) {
      tables.push_back(transition_table(modes[i - 1], modes[i], row_major(chain.transition)));
    } else {
      tables.push_back(
          prior_table(modes[0], {chain.initial.data(), chain.initial.data() + chain.modes()}));
    }
  }
  return tables;
}

Table chain_step(const MarkovChain& chain, DiscreteKey from, DiscreteKey to) {
  check(chain);
  check_modes(chain, from);
  check_modes(chain, to);
  return transition_table(from, to, row_major(chain.transition));
}

MarkovCounts::MarkovCounts(int modes)
    : starts(Eigen::VectorXd::Zero(modes)), changes(Eigen::MatrixXd::Zero(modes, modes)) {}

MarkovChain MarkovCounts::chain(double prior) const {
  MarkovChain chain;
  chain.initial = starts.array() + prior;
  chain.initial /= chain.initial.sum();
  chain.transition = changes.array() + prior;
  for (int i = 0; i < chain.modes(); ++i) chain.transition.row(i) /= chain.transition.row(i).sum();
  check(chain);
  return chain;
}

}  // namespace hybrid
