// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/health_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace hybrid {

nlohmann::ordered_json health_json(const Health& health) {
  using Json = nlohmann::ordered_json;
  Json out = Json::array();
  for (const HealthEntry& e : health) {
    const auto limit = [](double x) { return std::isfinite(x) ? Json(x) : Json(); };
    out.push_back({{"name", e.name},
                   {"value", limit(e.value)},
                   {"expected", {limit(e.least), limit(e.most)}},
                   {"verdict", to_string(e.verdict)},
                   {"sentence", e.sentence},
                   {"knob", e.knob}});
    for (const HealthSample& s : e.over_time) {
      out.back()["over_time"].push_back(
          {{"time", s.time}, {"value", s.value}, {"weight", s.weight}});
    }
  }
  return out;
}

}  // namespace hybrid
