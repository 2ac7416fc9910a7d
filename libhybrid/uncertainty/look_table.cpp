// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/uncertainty/detail/look_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

constexpr double kLeftOut = 20;     // [s] of the log, left out in turn
constexpr double kFewestSoon = 20;  // looks that tell a share
constexpr std::size_t kMostSoon = 30, kMostLate = 140;

}  // namespace

void LookTable::begin_place(double time) {
  end_place();
  stretch_ = &stretches_[std::lround(std::floor((time - begin_) / kLeftOut))];
  is_known_ = false;
  ++places_;
}

void LookTable::begin_known_place(double time) {
  begin_place(time);
  is_known_ = true;
}

void LookTable::add(LookTime when, double range, double turn, bool found) {
  const int r = std::clamp(static_cast<int>(kRanges * range / reach_), 0, kRanges - 1);
  const int t = std::clamp(static_cast<int>(kTurns * turn / M_PI), 0, kTurns - 1);
  looks_.push_back({when, static_cast<std::size_t>(r * kTurns + t), found});
}

/// Whether any look of a time found the present place.
bool LookTable::stands(LookTime when) const {
  return std::any_of(looks_.begin(), looks_.end(),
                     [when](const Look& look) { return look.when == when && look.found; });
}

void LookTable::end_place() {
  const bool before = stands(LookTime::kBefore), after = stands(LookTime::kAfter);
  const auto counts_at = [&](LookTime when) {
    if (when == LookTime::kBefore) return after;
    return when == LookTime::kAfter ? before : is_known_ || before || after;
  };
  bool has_late = false;
  for (const Look& look : looks_) {
    if (!counts_at(look.when)) continue;
    const bool is_late = look.when == LookTime::kLate;
    for (Counts* counts : {&all_, &stretch_->counts}) {
      Count& count = (*counts)[is_late ? 1 : 0][look.bin];
      count.looks += 1;
      count.found += look.found ? 1 : 0;
    }
    has_late = has_late || is_late;
  }
  if (has_late) {
    ++seen_late_;
    ++stretch_->places;
  }
  looks_.clear();
}

double LookTable::Shares::ratio() const {
  return late / std::max(soon, Agreement::kLeastSoon);
}

/// The shares of looks that found something, both as the late ones of `spread` are spread.
LookTable::Shares LookTable::compare(const Counts& soon, const Counts& late,
                                     const Counts& spread) const {
  Shares out;
  for (std::size_t i = 0; i < soon[0].size(); ++i) {
    const Count &s = soon[0][i], &l = late[1][i];
    if (all_[0][i].looks < kFewestSoon || s.looks <= 0 || l.looks <= 0) continue;
    const double looks = spread[1][i].looks;
    out.looks += looks;
    out.soon += looks * s.found / s.looks;
    out.late += looks * l.found / l.looks;
  }
  out.soon /= std::max(1.0, out.looks);
  out.late /= std::max(1.0, out.looks);
  return out;
}

/// Standard deviation of the ratio by leaving out each stretch in turn.
double LookTable::jackknife() const {
  std::vector<double> ratios;
  for (const auto& [number, stretch] : stretches_) {
    const Counts& counts = stretch.counts;
    Counts rest = all_;
    for (std::size_t late = 0; late < rest.size(); ++late) {
      for (std::size_t i = 0; i < rest[late].size(); ++i) {
        rest[late][i].looks -= counts[late][i].looks;
        rest[late][i].found -= counts[late][i].found;
      }
    }
    const Shares shares = compare(rest, rest, all_);
    if (shares.looks > 0) ratios.push_back(shares.ratio());
  }
  if (ratios.size() < 2) return std::numeric_limits<double>::infinity();
  const auto n = static_cast<double>(ratios.size());
  double mean = 0, sum = 0;
  for (const double r : ratios) mean += r / n;
  for (const double r : ratios) sum += (r - mean) * (r - mean);
  return std::sqrt((n - 1) / n * sum);
}

Agreement LookTable::conclude() {
  end_place();
  Agreement out;
  const Shares all = compare(all_, all_, all_);
  if (all.looks <= 0) return out;
  out.soon = all.soon;
  out.late = all.late;
  out.ratio = all.ratio();
  out.sigma = jackknife();
  out.looks = static_cast<std::size_t>(all.looks);
  out.judged = static_cast<double>(seen_late_) / static_cast<double>(places_);
  for (const auto& [number, stretch] : stretches_) {
    const Shares own = compare(all_, stretch.counts, stretch.counts);
    if (own.looks <= 0) continue;
    out.stretches.push_back({begin_ + kLeftOut * static_cast<double>(number), own.ratio(),
                             static_cast<std::size_t>(own.looks), stretch.places});
  }
  return out;
}

AgreementOptions options_for(AgreementOptions options, double length) {
  options.far_from = std::min(options.far_from, std::max(options.near_to, length / 2));
  return options;
}

LookChoice::LookChoice(std::vector<std::pair<double, int>> looks, const AgreementOptions& options)
    : looks_(std::move(looks)), options_(options) {}

std::vector<std::pair<LookTime, std::size_t>> LookChoice::around(double time, int robot) const {
  std::vector<std::size_t> before, after, late;
  for (std::size_t i = 0; i < looks_.size(); ++i) {
    const double later = looks_[i].first - time;
    if (looks_[i].second != robot || std::abs(later) > options_.far_from) {
      late.push_back(i);
    } else if (std::abs(later) > options_.near_from && std::abs(later) < options_.near_to) {
      (later < 0 ? before : after).push_back(i);
    }
  }
  std::vector<std::pair<LookTime, std::size_t>> out;
  for (const std::size_t i : evenly_chosen(before, kMostSoon))
    out.emplace_back(LookTime::kBefore, i);
  for (const std::size_t i : evenly_chosen(after, kMostSoon)) out.emplace_back(LookTime::kAfter, i);
  for (const std::size_t i : evenly_chosen(late, kMostLate)) out.emplace_back(LookTime::kLate, i);
  return out;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace hybrid
