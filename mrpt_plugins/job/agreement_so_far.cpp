// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/agreement_so_far.h"

#include <algorithm>
#include <utility>

#include "libhybrid/uncertainty/agreement.h"
#include "mrpt_plugins/health/agreement.h"

namespace hybrid {
namespace {

constexpr double kLonger = 1.2;

}  // namespace

Health agreements(const SensorArchives& measured, const PlacedViews& views,
                  const Agreement& with_map, const Mapper& mapper, const Trajectory& path) {
  Health out = agreement_health(agreement_of_detections(measured.detections.placed(mapper, path)),
                                agreement_of_scans(views.scans),
                                agreement_of_clouds(views.clouds, views.reach));
  if (auto entry = map_agreement_health(with_map)) out.push_back(std::move(*entry));
  return out;
}

std::optional<Health> AgreementSoFar::at(double time, const ScanOutputs& scans,
                                         const SensorArchives& measured, const Mapper& mapper) {
  if (!begin_) begin_ = time;
  const double length = time - *begin_;
  // Before, nothing was measured much later than anything else.
  const double least = 2 * AgreementOptions().near_to;
  if (!(length >= std::max(least, kLonger * asked_))) return std::nullopt;
  asked_ = length;
  const Trajectory path = mapper.trajectory();
  return agreements(measured, PlacedViews(scans, measured, mapper, path), {}, mapper, path);
}

}  // namespace hybrid
