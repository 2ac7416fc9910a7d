// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/contribution.h"

namespace hybrid {

void enter(const Contribution& contribution, LandmarkRegistry& landmarks) {
  for (const Landmark& landmark : contribution.landmarks) landmarks.add(landmark);
  for (const std::int64_t id : contribution.sighted) landmarks.sighted(id);
  for (const std::int64_t id : contribution.unsighted) landmarks.unsighted(id);
  for (const std::int64_t id : contribution.forgotten) landmarks.remove(id);
}

}  // namespace hybrid
