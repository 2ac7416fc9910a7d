// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/fixes.h"

#include <algorithm>
#include <utility>

#include "mrpt_plugins/mapping/register_plugin.h"

HYBRID_REGISTER_PLUGIN(Fixes, hybrid)

namespace hybrid {
namespace {

constexpr double kNear = 1000;        // m, between two fixes that confirm each other
constexpr double kFastest = 100;      // m/s, added to that
constexpr double kMostDistant = 1e6;  // m, of a fix from the datum

}  // namespace

void Fixes::configure(IniSection section) {
  FixModel model;
  model.modes = section.get("modes", model.modes,
                            "each fix is good, biased as others of its run, or false; no: errors "
                            "are Gaussian and independent");
  model.huber_width = section.get(
      "huber_width", model.huber_width,
      "without modes: beyond so many sigmas the cost of a fix grows only linearly; 0: none is "
      "wrong",
      or_zero(IniRange{1e-3, 1e3}));
  model.gate =
      section.get("gate", model.gate,
                  "without modes: a fix farther from where it is expected is left out [m]; "
                  "0: none is",
                  kLength);
  model.good_sigma = section.get(
      "sigma", model.good_sigma,
      "of good fixes whose quality is not stated, along each horizontal axis [m]", kSigmaMetres);
  model.bias_sigma =
      section.get("bias_sigma", model.bias_sigma, "of the bias of biased fixes [m]", kSigmaMetres);
  model.lasts =
      section.get("lasts", model.lasts, "time in which the error of a receiver becomes another [s]",
                  kPositiveDuration);
  model.good_lasts =
      section.get("good_lasts", model.good_lasts, "of a run of good fixes [s]", kPositiveDuration);
  model.bias_lasts = section.get("bias_lasts", model.bias_lasts, "of a run of biased fixes [s]",
                                 kPositiveDuration);
  model.false_share = section.get("false_share", model.false_share, "of all fixes, that are false",
                                  IniRange{1e-9, 0.5});
  mapper_ = FixMapper(model);
}

/// Whether a fix can be put into the axes of the datum; the first that is confirmed becomes it.
bool Fixes::confirms(const LoggedFix& fix) {
  if (frame_) return true;
  const std::optional<LoggedFix> before = std::exchange(first_, fix);
  if (!before) return false;
  const double apart = (ecef_of(fix.place) - ecef_of(before->place)).norm();
  if (apart > kNear + kFastest * std::max(0.0, fix.fix.time - before->fix.time)) return false;
  frame_.emplace(before->place);
  is_on_earth_ = before->is_on_earth;
  return true;
}

Contribution Fixes::observe(const Frame& frame, const MapView& map) {
  std::vector<Fix> fixes;
  std::size_t unconfirmed = 0, far = 0;
  for (const LoggedFix& logged : frame.fixes) {
    if (!confirms(logged)) {
      ++unconfirmed;
      continue;
    }
    Fix fix = logged.fix;
    fix.position = frame_->to_local(logged.place);
    if (fix.position.norm() > kMostDistant) {
      ++far;
    } else {
      fixes.push_back(fix);
    }
  }
  Contribution out = mapper_.observe(frame.view(), fixes, map, frame.robot);
  if (unconfirmed > 0) out.dropped["fix dropped: before two that confirm each other"] = unconfirmed;
  if (far > 0) out.dropped["fix dropped: farther than 1,000 km from the datum"] = far;
  return out;
}

Contribution Fixes::conclude(const MapView& map) {
  Contribution out = mapper_.revise(map);
  if (std::exchange(concluded_, true)) return out;
  std::size_t waiting = 0;
  for (const FixEntry& entry : mapper_.fixes()) {
    if (!entry.unused.empty()) ++out.dropped["fix not used: " + entry.unused];
    if (!mapper_.datum()) ++waiting;
  }
  if (waiting > 0) {
    out.dropped
        ["fix not used: the map is a known one, or most do not agree with the path, or it is "
         "too short to tell the direction of north"] = waiting;
  }
  return out;
}

std::map<std::string, double> Fixes::statistics() const {
  return {{"fixes", static_cast<double>(mapper_.fixes().size())},
          {"fix_own_sigma", mapper_.own_sigma()}};
}

std::optional<MapDatum> Fixes::datum() const {
  if (!mapper_.datum() || !frame_) return std::nullopt;
  return MapDatum{frame_->datum(), is_on_earth_, *mapper_.datum()};
}

}  // namespace hybrid
