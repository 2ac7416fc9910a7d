// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/fix_source.h"

#include <map>
#include <utility>

#include "libhybrid/core/spatial_values.h"

namespace hybrid {
namespace {

const std::vector<double>* find(const Uncertainty& uncertainty, Key key) {
  const auto found = uncertainty.probabilities.find(key);
  return found == uncertainty.probabilities.end() ? nullptr : &found->second;
}

}  // namespace

FixSource* fix_source_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins) {
  for (const auto& plugin : plugins) {
    if (auto* source = dynamic_cast<FixSource*>(plugin.get())) return source;
  }
  return nullptr;
}

std::vector<DiscreteKey> discrete_keys_of(const std::vector<FixEntry>& fixes) {
  std::vector<DiscreteKey> keys;
  std::map<ReceiverId, Key> newest;  // of the modes, which fixes of a receiver share
  for (const FixEntry& entry : fixes) {
    if (!entry.falsity) continue;
    keys.push_back({*entry.falsity, 2});
    const auto [found, is_first] = newest.emplace(entry.receiver(), entry.mode.key);
    if (is_first || std::exchange(found->second, entry.mode.key) != entry.mode.key) {
      keys.push_back(entry.mode);
    }
  }
  return keys;
}

FixEstimate FixEstimator::operator()(const FixEntry& entry) const {
  FixEstimate out;
  out.time = entry.fix.time;
  out.keyframe = entry.pose.index();
  out.sensor = entry.fix.sensor;
  out.sigma = entry.fix.sigma;
  out.unused = entry.unused;
  if (values_.contains(entry.pose)) {
    out.antenna = isometry_at(values_, entry.pose) * entry.fix.lever_arm();
  }
  if (!datum_) return out;
  out.measured = datum_->T_datum_map.inverse() * entry.fix.position;
  if (entry.is_plain) out.mode = FixMode::kGood;
  if (!entry.falsity || assignment_.find(*entry.falsity) < 0) return out;
  if (values_.contains(*entry.error)) {
    out.error = datum_->T_datum_map.linear() * point_at(values_, *entry.error);
  }
  if (assignment_.at(*entry.falsity) == 1) {
    out.mode = FixMode::kFalse;
  } else {
    const auto mode = static_cast<ErrorMode>(assignment_.at(entry.mode.key));
    out.mode = is_biased(mode) ? FixMode::kBiased : FixMode::kGood;
  }
  set_probabilities(entry, out);
  return out;
}

void FixEstimator::set_probabilities(const FixEntry& entry, FixEstimate& out) const {
  const std::vector<double>* falsity = find(uncertainty_, *entry.falsity);
  const std::vector<double>* mode = find(uncertainty_, entry.mode.key);
  if (falsity == nullptr || mode == nullptr) return;
  double good = 0, biased = 0;  // not 1 less the other, which rounding makes negative
  for (int i = 0; i < kErrorModes; ++i) {
    (is_biased(static_cast<ErrorMode>(i)) ? biased : good) += (*mode)[static_cast<std::size_t>(i)];
  }
  const double right = (*falsity)[0];
  out.probabilities = {right * good, right * biased, (*falsity)[1]};
}

}  // namespace hybrid
