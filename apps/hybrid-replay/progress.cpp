// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/progress.h"

namespace hybrid {

void Progress::update(std::optional<double> fraction, std::size_t keyframes, std::size_t landmarks,
                      double objective) {
  if (!line_.is_due()) return;
  const std::string share = fraction ? fmt::format("{:3.0f} %  ", 100 * *fraction) : "";
  line_.show(fmt::format("{}{} keyframes  {} landmarks  objective {:.6g}  {:.0f}/s  {}", share,
                         keyframes, landmarks, objective,
                         static_cast<double>(keyframes) / line_.elapsed(),
                         fraction ? line_.time_left(*fraction) : ""));
}

}  // namespace hybrid
