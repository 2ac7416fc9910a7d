// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/fixes/fix_model.h"

#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "libhybrid/factors/linear_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

constexpr double kImpossible = std::numeric_limits<double>::infinity();

template <int N>
HybridFactorPtr step_of(const FixModel& model, const Key* before, Key error, DiscreteKey mode,
                        double time) {
  using Vector = Eigen::Matrix<double, N, 1>;
  std::vector<MixtureComponent> components;
  for (int i = 0; i < kErrorModes; ++i) {
    const auto what = static_cast<ErrorMode>(i);
    if (before != nullptr && goes_on(what)) {
      const Eigen::Matrix<double, N, N> F =
          kept_share(model, time, is_biased(what)) * Eigen::Matrix<double, N, N>::Identity();
      components.push_back({std::make_shared<LinearMotion<N>>(
          *before, error, F, Vector::Zero(),
          Noise::isotropic(N, std::sqrt(added_variance(model, time))))});
    } else {
      components.push_back({std::make_shared<Prior<Vector>>(
          error, Vector(Vector::Zero()),
          Noise::isotropic(N, std::sqrt(new_variance(model, is_biased(what)))))});
    }
  }
  return std::make_shared<Mixture>(std::vector<DiscreteKey>{mode}, std::move(components));
}

}  // namespace

double added_variance(const FixModel& model, double time) {
  constexpr double kLeast = 1e-8;  // m^2
  const double forgotten = -std::expm1(-2 * time / model.lasts);
  return std::max(kLeast, model.good_sigma * model.good_sigma * forgotten);
}

double kept_share(const FixModel& model, double time, bool biased) {
  return std::sqrt(std::max(0.0, 1 - added_variance(model, time) / new_variance(model, biased)));
}

double new_variance(const FixModel& model, bool biased) {
  const double good = model.good_sigma * model.good_sigma;
  return biased ? good + model.bias_sigma * model.bias_sigma : good;
}

double false_cost(const FixModel& model, int size) {
  const double height = size == 3 ? std::log(model.false_reach / 10) : 0;
  return -std::log(model.false_share) + 2 * std::log(model.false_reach) + height;
}

double mode_cost(const FixModel& model, const ErrorMode* before, ErrorMode mode, double time) {
  const double biased_share = model.bias_lasts / (model.bias_lasts + model.good_lasts);
  if (before == nullptr) {
    if (goes_on(mode)) return kImpossible;
    return -std::log(is_biased(mode) ? biased_share : 1 - biased_share);
  }
  if (goes_on(mode) && is_biased(mode) != is_biased(*before)) return kImpossible;
  const double ends = is_biased(*before) ? model.bias_lasts : model.good_lasts;
  const double stays = std::exp(-time / ends);
  if (is_biased(mode) != is_biased(*before)) return -std::log(1 - stays);
  const double same = std::exp(-time / model.renewed);
  return -std::log(stays * (goes_on(mode) ? same : 1 - same));
}

Table mode_table(const FixModel& model, const DiscreteKey* before, DiscreteKey mode, double time) {
  std::vector<double> costs;
  for (int from = 0; from < (before != nullptr ? kErrorModes : 1); ++from) {
    const auto past = static_cast<ErrorMode>(from);
    for (int to = 0; to < kErrorModes; ++to) {
      costs.push_back(
          mode_cost(model, before != nullptr ? &past : nullptr, static_cast<ErrorMode>(to), time));
    }
  }
  if (before == nullptr) return {{mode}, std::move(costs)};
  return {{*before, mode}, std::move(costs)};
}

HybridFactorPtr error_step(const FixModel& model, const Key* before, Key error, DiscreteKey mode,
                           double time, int size) {
  return size == 2 ? step_of<2>(model, before, error, mode, time)
                   : step_of<3>(model, before, error, mode, time);
}

}  // namespace hybrid
