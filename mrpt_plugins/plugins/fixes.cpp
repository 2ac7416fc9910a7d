// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/fixes.h"

#include <algorithm>
#include <utility>

#include "mrpt_plugins/mapping/register_plugin.h"

HYBRID_REGISTER_PLUGIN(Fixes, hybrid)

namespace hybrid {
void Fixes::configure(IniSection section) {
  FixModel model;
  section.read("modes", model.modes,
               "each fix is good, biased as others of its run, or false; no: errors are Gaussian "
               "and independent");
  section.read("huber_width", model.huber_width,
               "without modes: beyond so many sigmas the cost of a fix grows only linearly; 0: "
               "none is wrong",
               or_zero({1e-3, 1e3}));
  section.read("gate", model.gate,
               "without modes: a fix farther from where it is expected is left out [m]; 0: none is",
               kLength);
  section.read("sigma", model.good_sigma,
               "of good fixes whose quality is not stated, along each horizontal axis [m]",
               kSigmaMetres);
  section.read("bias_sigma", model.bias_sigma, "of the bias of biased fixes [m]", kSigmaMetres);
  section.read("lasts", model.lasts, "time in which the error of a receiver becomes another [s]",
               kPositiveDuration);
  section.read("good_lasts", model.good_lasts, "of a run of good fixes [s]", kPositiveDuration);
  section.read("bias_lasts", model.bias_lasts, "of a run of biased fixes [s]", kPositiveDuration);
  section.read("false_share", model.false_share, "of all fixes, that are false", {1e-9, 0.5});
  mapper_ = FixMapper(model);
}

Contribution Fixes::observe(const Frame& frame, const MapView& map) {
  std::vector<Fix> fixes;
  DropReport dropped;
  for (const LoggedFix& logged : frame.fixes) {
    const auto position = datum_.to_local(logged, dropped);
    if (datum_.is_contradicted() && !mapper_.datum()) {
      datum_ = {};
      fixes.clear();
      mapper_.forget_waiting();
    }
    if (!position) continue;
    fixes.push_back(logged.fix);
    fixes.back().position = *position;
  }
  Contribution out = mapper_.observe(frame.view(), fixes, map, frame.robot);
  out.dropped = std::move(dropped);
  return out;
}

Contribution Fixes::conclude(const MapView& map) {
  Contribution out = mapper_.revise(map, true);
  if (std::exchange(concluded_, true)) return out;
  std::size_t waiting = 0;
  for (const FixEntry& entry : mapper_.fixes()) {
    if (!entry.unused.empty()) ++out.dropped["fix not used: " + entry.unused];
    if (!mapper_.datum()) ++waiting;
  }
  if (waiting > 0) {
    out.dropped
        ["fix not used: the map is a known one whose place on earth fixes have not told, or most "
         "do not agree with the path, or it is too short to tell the direction of north"] = waiting;
  }
  return out;
}

std::map<std::string, double> Fixes::statistics() const {
  return {{"fixes", static_cast<double>(mapper_.fixes().size())},
          {"fix_own_sigma", mapper_.own_sigma()}};
}

void Fixes::adopt(const MapDatum& datum) {
  datum_ = DatumFinder(datum.origin, datum.is_on_earth);
  mapper_.set_datum(datum.T_datum_map);
}

std::optional<MapDatum> Fixes::datum() const {
  if (!mapper_.datum() || !datum_.frame()) return std::nullopt;
  return MapDatum{datum_.frame()->datum(), datum_.is_on_earth(), *mapper_.datum()};
}

}  // namespace hybrid
