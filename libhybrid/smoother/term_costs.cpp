// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/term_costs.h"

#include <array>
#include <cmath>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/core/prefetch.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/smoother/detail/pose_charts.h"

namespace hybrid {
namespace {

/// Terms whose factors are loaded ahead: the time of some evaluations is that of a load.
constexpr std::size_t kAhead = 4;
/// Of a factor between two variables with their noise; of larger ones the beginning.
constexpr std::size_t kFactorBytes = 256;

/// Begins to load what the next few of some terms need: most of the time of a refresh is spent
/// waiting for memory.
void fetch_ahead(const std::vector<int>& list, std::size_t k, const LinearModels& models) {
  const Terms& terms = models.terms();
  if (k + 2 * kAhead < list.size()) terms.prefetch(list[k + 2 * kAhead]);
  if (k + kAhead >= list.size()) return;
  const Term& term = terms[list[k + kAhead]];
  prefetch(term.component.factor, kFactorBytes);
  if (term.tree_factor >= 0) models.tree().system().prefetch(term.tree_factor);
}

/// What the linear model of a term says of its cost at the values, less constants.
double model_cost(const Term& term, const Values& values, MapKind kind, const BayesTree& tree) {
  constexpr int kFew = 32;
  std::array<double, kFew> few;
  const ContinuousFactor& factor = *term.component.factor;
  std::vector<double> many(factor.cols() > kFew ? factor.cols() : 0);
  double* steps = many.empty() ? few.data() : many.data();
  steps_from(kind, tree.chart_of(term.tree_factor), factor.types(),
             TermPointers(term, values).data(), steps);
  return tree.system().linear_cost(term.tree_factor, steps);
}

}  // namespace

void TermCosts::refresh(const std::vector<int>& terms, const Values& values, MapKind kind,
                        LinearModels& models) {
  note_work(kWorkOfTerm * double(terms.size()));
  errors_.clear();
  model_error_ = 0.0;
  double change = 0.0;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    fetch_ahead(terms, k, models);
    const int t = terms[k];
    if (!models.terms()[t].alive) continue;
    Term& term = models.terms().edit(t);
    const double cost = evaluate(term, values);
    if (std::isfinite(cost) && std::isfinite(term.cost)) {
      change += cost - term.cost;
    } else {
      cost_.subtract(term.cost);
      cost_.add(cost);
    }
    term.cost = cost;
    if (term.hybrid != nullptr) stale_.push_back(t);
    if (term.tree_factor < 0) continue;
    const double error =
        cost - term.constant - term.model_offset - model_cost(term, values, kind, models.tree());
    model_error_ += error - term.model_error;
    term.model_error = std::isfinite(error) ? error : 0.0;
    errors_.emplace_back(std::isfinite(error) ? std::abs(error) : INFINITY, t);
  }
  cost_.add(change);
}

void TermCosts::choose_off(double limit, const Terms& terms) {
  off_.clear();
  open_ = 0.0;
  for (const auto& [error, t] : errors_) {
    if (error <= limit || t >= terms.count() || !terms[t].alive) continue;
    open_ += error;
    off_.push_back(t);
  }
}

std::vector<int> TermCosts::take_stale() {
  sort_unique(stale_);
  return std::exchange(stale_, {});
}

void TermCosts::roll_back(Mark&& mark) noexcept {
  cost_ = mark.cost;
  constant_ = mark.constant;
  off_ = std::move(mark.off);
  stale_ = std::move(mark.stale);
  errors_.clear();
}

}  // namespace hybrid
