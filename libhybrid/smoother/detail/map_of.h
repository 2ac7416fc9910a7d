// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "libhybrid/smoother/detail/pose_charts.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// The map of a smoother as the charts of its tree see it. Where variables were is noted before
/// they move.
class IncrementalSmoother::MapOf : public MapVariables {
 public:
  explicit MapOf(const IncrementalSmoother& smoother)
      : smoother_(smoother),
        charts_(make_charts(smoother.map_kind_, smoother.values(), nullptr, *this)) {}
  explicit MapOf(IncrementalSmoother& smoother)
      : smoother_(smoother),
        change_(&smoother),
        charts_(make_charts(smoother.map_kind_, smoother.values(), &smoother.estimate_, *this)) {}

  Charts* charts() const { return charts_.get(); }

  bool is_held(int slot) const override {
    const std::vector<int>& own = smoother_.terms_.of_variable(slot);
    return std::any_of(own.begin(), own.end(), [this](int t) {
      return smoother_.terms_[t].alive && smoother_.terms_[t].holds;
    });
  }

  void before_change(int slot) const override {
    if (change_->slot_stamp_[slot] == change_->old_stamp_) return;
    change_->slot_stamp_[slot] = change_->old_stamp_;
    const double* x = smoother_.values().data(slot);
    Place& old = change_->old_;
    old.slots.push_back(slot);
    old.numbers.insert(old.numbers.end(), x, x + smoother_.values().type(slot).size);
  }

 private:
  const IncrementalSmoother& smoother_;
  IncrementalSmoother* change_ = nullptr;
  std::unique_ptr<Charts> charts_;
};

}  // namespace hybrid
