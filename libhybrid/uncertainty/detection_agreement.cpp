// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/uncertainty/detail/crossings.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostJudged = 8000;
constexpr std::size_t kMostAsked = 1000000;  // landmarks of a map that frames are asked for
constexpr double kAgree = 0.95;              // probability of two detections of one thing to agree
/// Shares of the detections of a sensor that are nearer, and less to the side, than its view ends.
constexpr double kWithinRange = 0.9, kAside = 0.05;

/// A detection where its sensor sees it.
struct DetectedPlace {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// What a sensor has in view, by its detections.
struct ViewOfSensor {
  std::vector<double> ranges, yaws, pitches;  // of all
  double reach = 0, right = 0, left = 0, low = 0, high = 0;

  void learn() {
    reach = quantile(ranges, kWithinRange);
    right = quantile(yaws, kAside);
    left = quantile(yaws, 1 - kAside);
    low = quantile(pitches, kAside);
    high = quantile(pitches, 1 - kAside);
  }
  bool holds(const Eigen::Vector3d& z, bool is_3d) const {
    return z[0] < reach && z[1] >= right && z[1] <= left &&
           (!is_3d || (z[2] >= low && z[2] <= high));
  }
};

DetectedPlace detected_place(const MeasuredPoint& seen) {
  DetectedPlace out;
  if (seen.z.size() == 2) {
    Eigen::Matrix2d J;
    out.point.head<2>() = from_polar(Eigen::Vector2d(seen.z), &J);
    out.covariance.topLeftCorner<2, 2>() = J * seen.covariance * J.transpose();
  } else {
    Eigen::Matrix3d J;
    out.point = from_polar(Eigen::Vector3d(seen.z), &J);
    out.covariance = J * seen.covariance * J.transpose();
  }
  return out;
}

/// Whether two measurements of one thing may be as far apart.
template <int N>
bool agrees(const Eigen::Matrix<double, N, 1>& apart, const Eigen::Matrix<double, N, N>& C) {
  static const double gate = chi_square_quantile(kAgree, N);
  return apart.dot(C.inverse() * apart) < gate;
}

template <int N>
bool agrees(const DetectedPlace& a, const DetectedPlace& b) {
  return agrees<N>((a.point - b.point).head<N>(),
                   (a.covariance + b.covariance).topLeftCorner<N, N>());
}

/// Whether a direction, of N angles, leads to a place: z of it and its covariance are given.
template <int N>
bool leads_to(const MeasuredPoint& seen, const Eigen::Vector3d& z, const Eigen::Matrix3d& C) {
  Eigen::Matrix<double, N, 1> apart = seen.z.segment<N>(1) - z.segment<N>(1);
  apart[0] = wrap_angle(apart[0]);
  return agrees<N>(apart, C.block<N, N>(1, 1) + seen.covariance.block<N, N>(1, 1));
}

/// The looks of all sensors.
class Detections {
 public:
  /// `frames` are in order of time.
  Detections(std::vector<PlacedDetections> frames, const AgreementOptions& options)
      : options_(options_for(options, frames.back().time - frames.front().time)),
        crossings_(crossings(frames, options.near_to)),
        looks_(std::move(frames)) {
    for (const std::vector<PlacedDetections>* measured : {&looks_, &crossings_.places}) {
      for (const PlacedDetections& frame : *measured) {
        if (!frame.has_range) continue;
        std::vector<double>& ranges = views_[frame.sensor].ranges;
        for (const MeasuredPoint& seen : frame.seen) ranges.push_back(seen.z[0]);
        count_ += frame.seen.size();
      }
    }
    for (const PlacedDetections& frame : looks_) {
      places_.emplace_back();
      ViewOfSensor& view = views_[frame.sensor];
      for (const MeasuredPoint& seen : frame.seen) {
        if (frame.has_range) places_.back().push_back(detected_place(seen));
        view.yaws.push_back(seen.z[1]);
        view.pitches.push_back(seen.z.size() > 2 ? seen.z[2] : 0);
      }
    }
    for (auto& [sensor, view] : views_) {
      if (!view.ranges.empty() && !view.yaws.empty()) view.learn();
      reach_ = std::max(reach_, view.reach);
    }
  }

  Agreement judge() const {
    if (count_ == 0) return {};
    LookTable table(looks_.front().time, reach_);
    look_at_own_places(true, table);
    return conclude(table);
  }

  /// The same of landmarks of a map, in place of what was measured much earlier or later.
  Agreement judge(const std::vector<KnownLandmark>& map) const {
    if (count_ == 0 || map.empty()) return {};
    LookTable table(looks_.front().time, reach_);
    look_at_own_places(false, table);
    const std::size_t every = (looks_.size() * map.size() + kMostAsked - 1) / kMostAsked;
    for (std::size_t j = 0; j < looks_.size(); j += every) {
      table.begin_known_place(looks_[j].time);
      for (const KnownLandmark& landmark : map) {
        look(nullptr, {landmark.position, landmark.covariance}, j, LookTime::kLate, table);
      }
    }
    return conclude(table);
  }

 private:
  using Looks = std::vector<std::pair<LookTime, std::size_t>>;

  Agreement conclude(LookTable& table) const {
    Agreement out = table.conclude();
    out.far_from = options_.far_from;
    return out;
  }

  void look_at_own_places(bool late, LookTable& table) const {
    std::vector<std::pair<double, int>> times;
    for (const PlacedDetections& frame : looks_) times.emplace_back(frame.time, frame.robot);
    const LookChoice choice(std::move(times), options_);
    std::size_t number = 0;
    for (const PlacedDetections& frame : looks_) {
      const auto looks = [&] { return choice.around(frame.time, frame.robot); };
      if (frame.has_range) look_at(frame, looks, late, number, table);
    }
    for (std::size_t i = 0; i < crossings_.places.size(); ++i) {
      const PlacedDetections& frame = crossings_.places[i];
      const auto looks = [&] { return around_crossing(i, choice.around(frame.time, frame.robot)); };
      look_at(frame, looks, late, number, table);
    }
  }

  /// The looks at what directions tell: soon are those of the same stretch that had no part in it.
  Looks around_crossing(std::size_t i, Looks looks) const {
    const auto is_soon = [](const auto& look) { return look.first != LookTime::kLate; };
    looks.erase(std::remove_if(looks.begin(), looks.end(), is_soon), looks.end());
    for (const std::size_t j : crossings_.looks[i]) {
      const bool is_before = looks_[j].time < crossings_.places[i].time;
      looks.emplace_back(is_before ? LookTime::kBefore : LookTime::kAfter, j);
    }
    return looks;
  }

  /// Looks at the places of a frame that are its turn; not `late`: soon looks alone. `number`
  /// counts those of all frames. The looks are a walk over the log, and only asked for where there
  /// is such a place.
  template <class FindLooks>
  void look_at(const PlacedDetections& frame, const FindLooks& find_looks, bool late,
               std::size_t& number, LookTable& table) const {
    const std::size_t every = (count_ + kMostJudged - 1) / kMostJudged;
    std::optional<Looks> looks;
    for (const MeasuredPoint& seen : frame.seen) {
      if (number++ % every != 0) continue;
      if (!looks) looks = find_looks();
      table.begin_place(frame.time);
      const DetectedPlace place = detected_place(seen);
      for (const auto& [when, j] : *looks) {
        if (late || when != LookTime::kLate) look(&frame.T_map_sensor, place, j, when, table);
      }
    }
  }

  /// The look of frame j at a place that was measured from elsewhere; null: that is in the map, and
  /// known from all sides.
  void look(const Eigen::Isometry3d* T_map_from, const DetectedPlace& place, std::size_t j,
            LookTime when, LookTable& table) const {
    const PlacedDetections& to = looks_[j];
    const Eigen::Isometry3d T_sensor_map = to.T_map_sensor.inverse();
    const Eigen::Isometry3d T = T_map_from ? T_sensor_map * *T_map_from : T_sensor_map;
    DetectedPlace here{T * place.point, T.linear() * place.covariance * T.linear().transpose()};
    if (!to.is_3d) here.point.z() = 0;
    const Eigen::Vector3d z = to_polar(here.point);
    if (!views_.at(to.sensor).holds(z, to.is_3d)) return;
    const bool found = to.has_range ? has_at(j, here) : has_towards(j, here);
    const double turn = T_map_from ? angle_between(T.linear() * place.point, here.point) : 0.0;
    table.add(when, z[0], turn, found);
  }

  bool has_at(std::size_t j, const DetectedPlace& here) const {
    const bool is_3d = looks_[j].is_3d;
    return std::any_of(places_[j].begin(), places_[j].end(), [&](const DetectedPlace& other) {
      return is_3d ? agrees<3>(here, other) : agrees<2>(here, other);
    });
  }

  bool has_towards(std::size_t j, const DetectedPlace& here) const {
    const PlacedDetections& to = looks_[j];
    Eigen::Matrix3d by_point;
    const Eigen::Vector3d z = to_polar(here.point, &by_point);
    const Eigen::Matrix3d C = by_point * here.covariance * by_point.transpose();
    return std::any_of(to.seen.begin(), to.seen.end(), [&](const MeasuredPoint& seen) {
      return to.is_3d ? leads_to<2>(seen, z, C) : leads_to<1>(seen, z, C);
    });
  }

  AgreementOptions options_;
  Crossings crossings_;
  std::vector<PlacedDetections> looks_;
  std::vector<std::vector<DetectedPlace>> places_;  // of looks with ranges
  std::map<int, ViewOfSensor> views_;
  std::size_t count_ = 0;  // of places that are looked at
  double reach_ = 0;
};

void sort_by_time(std::vector<PlacedDetections>& frames) {
  std::stable_sort(frames.begin(), frames.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
}

}  // namespace

Agreement agreement_of_detections(std::vector<PlacedDetections> frames,
                                  const AgreementOptions& options) {
  if (frames.empty()) return {};
  sort_by_time(frames);
  return Detections(std::move(frames), options).judge();
}

Agreement agreement_with_map(std::vector<PlacedDetections> frames,
                             const std::vector<KnownLandmark>& map,
                             const AgreementOptions& options) {
  if (frames.empty()) return {};
  sort_by_time(frames);
  return Detections(std::move(frames), options).judge(map);
}

}  // namespace hybrid
