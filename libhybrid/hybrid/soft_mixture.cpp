// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/soft_mixture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/key_letters.h"

namespace hybrid {
namespace {

/// A mixture of the components, which collects and checks their variables.
Mixture as_mixture(const std::vector<MixtureComponent>& components) {
  for (const MixtureComponent& c : components) {
    if (!std::isfinite(c.constant)) throw Error("a component of a soft mixture has no weight");
  }
  return {{{Key(key_letter::kComponent, 0), static_cast<int>(components.size())}}, components};
}

int stacked_rows(const std::vector<MixtureComponent>& components) {
  int rows = 1;
  for (const MixtureComponent& c : components) rows += c.factor == nullptr ? 0 : c.factor->rows();
  return rows;
}

/// -T log sum exp(-c / T).
double soft_minimum(const Eigen::VectorXd& c, double temperature) {
  const double least = c.minCoeff();
  if (!std::isfinite(least)) return least;
  return least - temperature * std::log((-(c.array() - least) / temperature).exp().sum());
}

Eigen::VectorXd soft_weights(const Eigen::VectorXd& c, double temperature) {
  const Eigen::VectorXd g = (-(c.array() - c.minCoeff()) / temperature).exp();
  return g / g.sum();
}

}  // namespace

SoftMixture::SoftMixture(std::vector<MixtureComponent> components, double temperature)
    : ContinuousFactor(as_mixture(components).keys(), as_mixture(components).types(),
                       stacked_rows(components)),
      components_(std::move(components)),
      temperature_(temperature) {
  if (keys().empty()) throw Error("a soft mixture needs a component over continuous variables");
  if (!(temperature > 0.0) || !std::isfinite(temperature)) {
    throw Error("the temperature of a soft mixture must be positive, got " +
                std::to_string(temperature));
  }
  Eigen::VectorXd base(components_.size());
  for (std::size_t k = 0; k < components_.size(); ++k) {
    const MixtureComponent& c = components_[k];
    base[static_cast<Eigen::Index>(k)] =
        c.constant + (c.factor == nullptr ? 0.0 : c.factor->log_normalizer());
    positions_.emplace_back();
    if (c.factor == nullptr) continue;
    for (Key key : c.factor->keys()) {
      positions_[k].push_back(
          static_cast<int>(std::find(keys().begin(), keys().end(), key) - keys().begin()));
    }
  }
  log_normalizer_ = soft_minimum(base, temperature_);
  int column = 0;
  for (const VariableType& type : types()) {
    columns_.push_back(column);
    column += type.dim;
  }
}

double SoftMixture::component_cost(std::size_t k, const double* const* x) const {
  const Component component{components_[k].factor.get(), positions_[k].data(),
                            components_[k].constant};
  return hybrid::component_cost(component, x);
}

Eigen::VectorXd SoftMixture::costs(const double* const* x) const {
  Eigen::VectorXd c(components_.size());
  for (std::size_t k = 0; k < components_.size(); ++k) {
    c[static_cast<Eigen::Index>(k)] = component_cost(k, x);
  }
  return c;
}

double SoftMixture::cost(const double* const* x) const {
  return soft_minimum(costs(x), temperature_) - log_normalizer_;
}

Eigen::VectorXd SoftMixture::weights(const Values& values) const {
  return soft_weights(costs(gather(keys(), types(), values).data()), temperature_);
}

double SoftMixture::linearize(const double* const* x, double* r, double* J) const {
  const Eigen::VectorXd c = costs(x);
  const Eigen::VectorXd g = soft_weights(c, temperature_);
  const double cost = soft_minimum(c, temperature_) - log_normalizer_;
  Eigen::Map<Eigen::VectorXd> residual(r, rows());
  Eigen::Map<Eigen::MatrixXd> jacobian(J, rows(), cols());
  jacobian.setZero();
  std::vector<const double*> own;
  int row = 0;
  for (std::size_t k = 0; k < components_.size(); ++k) {
    if (components_[k].factor == nullptr) continue;
    const ContinuousFactor& factor = *components_[k].factor;
    own.clear();
    for (int position : positions_[k]) own.push_back(x[position]);
    Eigen::VectorXd part(factor.rows());
    Eigen::MatrixXd block(factor.rows(), factor.cols());
    factor.linearize(own.data(), part.data(), block.data());
    const double root = std::sqrt(g[static_cast<Eigen::Index>(k)]);
    residual.segment(row, factor.rows()) = root * part;
    int column = 0;
    for (std::size_t i = 0; i < positions_[k].size(); ++i) {
      const int dim = factor.types()[i].dim;
      jacobian.block(row, columns_[positions_[k][i]], factor.rows(), dim) =
          root * block.middleCols(column, dim);
      column += dim;
    }
    row += factor.rows();
  }
  residual[row] = 0.0;
  residual[row] = std::sqrt(std::max(0.0, 2.0 * cost - residual.squaredNorm()));
  return cost;
}

}  // namespace hybrid
