// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/progress.h"

namespace hybrid {

void Progress::update(double fraction, std::size_t keyframes, std::size_t landmarks,
                      double objective) {
  if (!line_.is_due()) return;
  line_.show(fmt::format("{:3.0f} %  {} keyframes  {} landmarks  objective {:.6g}  {:.0f}/s  {}",
                         100 * fraction, keyframes, landmarks, objective,
                         static_cast<double>(keyframes) / line_.elapsed(),
                         line_.time_left(fraction)));
}

}  // namespace hybrid
