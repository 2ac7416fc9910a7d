// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "libhybrid/smoother/detail/pose_charts.h"
#include "libhybrid/smoother/places.h"
#include "libhybrid/smoother/terms.h"

namespace hybrid {

/// The map of a smoother as the charts of its tree see it. Where variables were is noted before
/// they move.
class MapOf : public MapVariables {
 public:
  MapOf(MapKind kind, const JournaledValues& estimate, const Terms& terms)
      : values_(estimate.get()),
        terms_(terms),
        charts_(make_charts(kind, values_, nullptr, *this)) {}
  MapOf(MapKind kind, JournaledValues& estimate, const Terms& terms, MovedVariables& moved)
      : values_(estimate.get()),
        terms_(terms),
        moved_(&moved),
        charts_(make_charts(kind, values_, &estimate, *this)) {}

  Charts* charts() const { return charts_.get(); }

  bool is_held(int slot) const override {
    const std::vector<int>& own = terms_.of_variable(slot);
    return std::any_of(own.begin(), own.end(),
                       [this](int t) { return terms_[t].alive && terms_[t].holds; });
  }
  void before_change(int slot) const override { moved_->note(slot, values_); }

 private:
  const Values& values_;
  const Terms& terms_;
  MovedVariables* moved_ = nullptr;
  std::unique_ptr<Charts> charts_;
};

}  // namespace hybrid
