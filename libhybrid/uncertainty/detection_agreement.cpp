// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <map>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostJudged = 8000;
constexpr double kAgree = 0.95;  // probability of two detections of one thing to agree
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

/// The looks of all sensors.
class Detections {
 public:
  explicit Detections(std::vector<PlacedDetections> frames) : frames_(std::move(frames)) {
    std::stable_sort(frames_.begin(), frames_.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    for (const PlacedDetections& frame : frames_) {
      places_.emplace_back();
      ViewOfSensor& view = views_[frame.sensor];
      for (const MeasuredPoint& seen : frame.seen) {
        places_.back().push_back(detected_place(seen));
        view.ranges.push_back(seen.z[0]);
        view.yaws.push_back(seen.z[1]);
        view.pitches.push_back(seen.z.size() > 2 ? seen.z[2] : 0);
        ++count_;
      }
    }
    for (auto& [sensor, view] : views_) {
      if (!view.ranges.empty()) view.learn();
      reach_ = std::max(reach_, view.reach);
    }
  }

  Agreement judge(const AgreementOptions& given) const {
    if (count_ == 0) return {};
    const auto options = options_for(given, frames_.back().time - frames_.front().time);
    LookTable table(frames_.front().time, reach_);
    std::vector<std::pair<double, int>> times;
    for (const PlacedDetections& frame : frames_) times.emplace_back(frame.time, frame.robot);
    const LookChoice choice(std::move(times), options);
    const std::size_t every = (count_ + kMostJudged - 1) / kMostJudged;
    std::size_t number = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      if (frames_[i].seen.empty()) continue;
      std::vector<std::size_t> taken;
      for (std::size_t k = 0; k < places_[i].size(); ++k) {
        if (number++ % every == 0) taken.push_back(k);
      }
      if (taken.empty()) continue;
      const auto looks = choice.around(frames_[i].time, frames_[i].robot);
      for (const std::size_t k : taken) {
        table.begin_place(frames_[i].time);
        for (const auto& [when, j] : looks) look(i, k, j, when, table);
      }
    }
    Agreement out = table.conclude();
    out.far_from = options.far_from;
    return out;
  }

 private:
  /// The look of frame j at place k of frame i.
  void look(std::size_t i, std::size_t k, std::size_t j, LookTime when, LookTable& table) const {
    const PlacedDetections &from = frames_[i], &to = frames_[j];
    const Eigen::Isometry3d T = to.T_map_sensor.inverse() * from.T_map_sensor;
    const DetectedPlace& place = places_[i][k];
    Eigen::Vector3d p = T * place.point;
    if (!to.is_3d) p.z() = 0;
    const Eigen::Vector3d z = to_polar(p);
    if (!views_.at(to.sensor).holds(z, to.is_3d)) return;
    const Eigen::Matrix3d C = T.linear() * place.covariance * T.linear().transpose();
    const bool found =
        std::any_of(places_[j].begin(), places_[j].end(), [&](const DetectedPlace& other) {
          return agree(p - other.point, C + other.covariance, to.is_3d ? 3 : 2);
        });
    table.add(when, z[0], angle_between(T.linear() * place.point, p), found);
  }

  bool agree(const Eigen::Vector3d& apart, const Eigen::Matrix3d& covariance, int dim) const {
    const double gate = dim == 2 ? gate2_ : gate3_;
    if (dim == 2) {
      const Eigen::Matrix2d C = covariance.topLeftCorner<2, 2>();
      return apart.head<2>().dot(C.inverse() * apart.head<2>()) < gate;
    }
    return apart.dot(covariance.inverse() * apart) < gate;
  }

  std::vector<PlacedDetections> frames_;
  std::vector<std::vector<DetectedPlace>> places_;
  std::map<int, ViewOfSensor> views_;
  std::size_t count_ = 0;
  double reach_ = 0;
  double gate2_ = chi_square_quantile(kAgree, 2), gate3_ = chi_square_quantile(kAgree, 3);
};

}  // namespace

Agreement agreement_of_detections(std::vector<PlacedDetections> frames,
                                  const AgreementOptions& options) {
  return Detections(std::move(frames)).judge(options);
}

}  // namespace hybrid
