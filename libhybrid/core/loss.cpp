// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/loss.h"

#include <cmath>

namespace hybrid {

double Loss::value(double s) const {
  const double k2 = parameter * parameter;
  switch (kind) {
    case Kind::kNone:
      return s;
    case Kind::kHuber:
      return s <= k2 ? s : 2.0 * parameter * std::sqrt(s) - k2;
    case Kind::kCauchy:
      return k2 * std::log1p(s / k2);
    case Kind::kTukey: {
      if (s >= k2) return k2 / 3.0;
      const double t = 1.0 - s / k2;
      return k2 / 3.0 * (1.0 - t * t * t);
    }
    case Kind::kGemanMcClure:
      return k2 * s / (k2 + s);
  }
  return s;
}

double Loss::weight(double s) const {
  const double k2 = parameter * parameter;
  switch (kind) {
    case Kind::kNone:
      return 1.0;
    case Kind::kHuber:
      return s <= k2 ? 1.0 : parameter / std::sqrt(s);
    case Kind::kCauchy:
      return k2 / (k2 + s);
    case Kind::kTukey: {
      if (s >= k2) return 0.0;
      const double t = 1.0 - s / k2;
      return t * t;
    }
    case Kind::kGemanMcClure: {
      const double t = k2 / (k2 + s);
      return t * t;
    }
  }
  return 1.0;
}

}  // namespace hybrid
