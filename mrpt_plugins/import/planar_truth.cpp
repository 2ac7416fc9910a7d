// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/planar_truth.h"

#include <mrpt/math/wrap2pi.h>

namespace hybrid {

void PlanarTruth::advance() {
  before_ = after_;
  const auto row = table_.next();
  after_.reset();
  if (!row) return;
  row->expect(4, "time x y angle");
  after_ = Row{row->time(0), row->coordinate(1), row->coordinate(2), row->coordinate(3)};
  if (before_ && after_->time < before_->time) row->fail("time goes backwards");
}

std::optional<mrpt::poses::CPose3D> PlanarTruth::at(double time) {
  if (!before_) advance();
  while (!before_ || (after_ && after_->time < time)) {
    advance();
    if (!before_ && !after_) return std::nullopt;
  }
  if (!after_ || before_->time > time) return std::nullopt;
  const double length = after_->time - before_->time;
  const double f = length > 0 ? (time - before_->time) / length : 0.0;
  const double turn = mrpt::math::wrapToPi(after_->angle - before_->angle);
  return mrpt::poses::CPose3D(before_->x + f * (after_->x - before_->x),
                              before_->y + f * (after_->y - before_->y), 0,
                              before_->angle + f * turn, 0, 0);
}

}  // namespace hybrid
