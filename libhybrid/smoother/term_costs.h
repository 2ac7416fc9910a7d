// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/smoother/cost_sum.h"
#include "libhybrid/smoother/linear_models.h"
#include "libhybrid/smoother/map_kind.h"

namespace HYBRID_API hybrid {

/// What terms cost at the estimate in all, and by how much their linear models are off.
class TermCosts {
 public:
  double value() const { return cost_.value(); }
  /// The part of it that does not depend on the variables.
  double constant() const { return constant_.value(); }

  void enter(const Term& term) {
    cost_.add(term.cost);
    constant_.add(term.constant);
  }
  void leave(const Term& term) {
    cost_.subtract(term.cost);
    constant_.subtract(term.constant);
  }
  /// Brings the costs of some terms up to date, and notes by how much their models are off.
  void refresh(const std::vector<int>& terms, const Values& values, MapKind kind,
               LinearModels& models);
  /// By which costs have risen more than their models at the last refresh.
  double model_error() const { return model_error_; }

  /// Lists, of the terms of the last refresh, those whose model is off by more than `limit`.
  void choose_off(double limit, const Terms& terms);
  /// Terms to linearise again in the next update.
  bool any_off() const { return !off_.empty(); }
  std::vector<int> take_off() { return std::exchange(off_, {}); }
  void set_off(const std::vector<int>& terms) { off_ = terms; }
  /// By how much the models of those are off in all.
  double open() const { return open_; }
  /// Forgets which are off, and by how much.
  void forget_errors() {
    errors_.clear();
    off_.clear();
  }

  void add_stale(int t) { stale_.push_back(t); }
  /// Hybrid terms that came or whose variables have moved since this was asked last, each once.
  std::vector<int> take_stale();

  struct Mark {
    CostSum cost, constant;
    std::vector<int> off, stale;
  };
  Mark mark() const { return {cost_, constant_, off_, stale_}; }
  void roll_back(Mark&& mark) noexcept;

 private:
  CostSum cost_, constant_;
  std::vector<std::pair<double, int>> errors_;  // of models, and the terms, at the last refresh
  double model_error_ = 0.0;
  std::vector<int> off_;
  double open_ = 0.0;
  std::vector<int> stale_;
};

}  // namespace hybrid
