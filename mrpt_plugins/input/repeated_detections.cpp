// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/repeated_detections.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace hybrid {
namespace {

auto measured(const Detection& d) {
  return std::tie(d.range, d.yaw, d.pitch, d.id, d.class_probabilities);
}

bool is_same(const DetectionFrame& a, const DetectionFrame& b) {
  return a.time == b.time &&
         std::equal(
             a.detections.begin(), a.detections.end(), b.detections.begin(), b.detections.end(),
             [](const Detection& x, const Detection& y) { return measured(x) == measured(y); });
}

}  // namespace

std::size_t RepeatedDetections::remove(DetectionFrame& frame) {
  std::vector<Detection>& detections = frame.detections;
  const std::size_t before = detections.size();
  std::set<decltype(measured(frame.detections.front()))> seen;
  std::vector<Detection> once;
  once.reserve(before);
  for (Detection& detection : detections) {
    once.push_back(std::move(detection));
    if (!seen.insert(measured(once.back())).second) once.pop_back();
  }
  detections = std::move(once);
  DetectionFrame& last = last_[frame.sensor_label];
  if (!detections.empty() && is_same(frame, last)) {
    detections.clear();
  } else {
    last = frame;
  }
  return before - detections.size();
}

}  // namespace hybrid
