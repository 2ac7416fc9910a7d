// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/mixture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hybrid {
namespace {

/// Union of the variables of all components, in order of appearance.
std::vector<Key> union_of_keys(const std::vector<MixtureComponent>& components) {
  std::vector<Key> keys;
  for (const MixtureComponent& component : components) {
    if (component.factor == nullptr) continue;
    for (Key key : component.factor->keys()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  return keys;
}

std::vector<VariableType> types_of(const std::vector<Key>& keys,
                                   const std::vector<MixtureComponent>& components) {
  std::vector<VariableType> types(keys.size());
  for (const MixtureComponent& component : components) {
    if (component.factor == nullptr) continue;
    for (std::size_t i = 0; i < component.factor->keys().size(); ++i) {
      const Key key = component.factor->keys()[i];
      VariableType& type = types[std::find(keys.begin(), keys.end(), key) - keys.begin()];
      if (type.dim != 0 && type != component.factor->types()[i]) {
        throw Error("components of a mixture take " + to_string(key) + " as " + to_string(type) +
                    " and as " + to_string(component.factor->types()[i]));
      }
      type = component.factor->types()[i];
    }
  }
  return types;
}

/// The largest information of a weak outlier model, as a share of that of the inlier.
constexpr double kWeakShare = 1e-6;

/// Compares the geometric means of the variances of the rows, which follow from the normalisers.
bool is_weak(const ContinuousFactor* outlier, const ContinuousFactor* inlier) {
  if (outlier == nullptr || inlier == nullptr || outlier->rows() != inlier->rows()) return false;
  const double wider = outlier->log_normalizer() - inlier->log_normalizer();
  return 2.0 * wider / outlier->rows() > -std::log(kWeakShare);
}

}  // namespace

Mixture::Mixture(std::vector<DiscreteKey> discrete_keys, std::vector<MixtureComponent> components)
    : HybridFactor(union_of_keys(components), types_of(union_of_keys(components), components),
                   std::move(discrete_keys)),
      components_(std::move(components)) {
  if (components_.size() != joint_size(this->discrete_keys())) {
    throw Error("a mixture over " + std::to_string(joint_size(this->discrete_keys())) +
                " joint values has " + std::to_string(components_.size()) + " components");
  }
  positions_.resize(components_.size());
  for (std::size_t c = 0; c < components_.size(); ++c) {
    if (!(components_[c].constant > -std::numeric_limits<double>::infinity())) {
      throw Error("component " + std::to_string(c) + " of a mixture over " +
                  names_of(this->discrete_keys()) + " has the constant " +
                  std::to_string(components_[c].constant) +
                  "; it must be a number, or infinity where it is impossible");
    }
    if (components_[c].factor == nullptr) continue;
    for (Key key : components_[c].factor->keys()) {
      positions_[c].push_back(std::find(keys().begin(), keys().end(), key) - keys().begin());
    }
  }
}

Component Mixture::component(std::size_t index) const {
  const MixtureComponent& c = components_[index];
  return {c.factor.get(), positions_[index].data(), c.constant, c.weak, static_cast<int>(index)};
}

Component Mixture::given(const Assignment& assignment) const {
  return component(joint_index(discrete_keys(), assignment));
}

std::vector<Table> Mixture::given(const double* const* x) const {
  std::vector<double> costs;
  costs.reserve(components_.size());
  for (std::size_t c = 0; c < components_.size(); ++c) {
    costs.push_back(component_cost(component(c), x));
  }
  std::vector<Table> tables;
  tables.emplace_back(discrete_keys(), std::move(costs));
  return tables;
}

HybridFactorPtr make_outlier_mixture(DiscreteKey switch_key, ContinuousFactorPtr inlier,
                                     ContinuousFactorPtr outlier, double inlier_weight,
                                     double outlier_weight) {
  if (!(inlier_weight > 0.0) || !(outlier_weight > 0.0)) {
    throw Error("weights of the mixture of " + to_string(switch_key.key) + " must be positive");
  }
  std::vector<MixtureComponent> components;
  const bool weak = is_weak(outlier.get(), inlier.get());
  components.push_back({std::move(inlier), -std::log(inlier_weight), false});
  components.push_back({std::move(outlier), -std::log(outlier_weight), weak});
  return std::make_shared<Mixture>(std::vector<DiscreteKey>{switch_key}, std::move(components));
}

}  // namespace hybrid
