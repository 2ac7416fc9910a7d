// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

constexpr std::size_t kPlaces = 40;  // of each cloud

/// How far a place may be from a sensor that looks at it, in reaches of the sensor.
constexpr double kFarLook = 2;

class CloudLooks {
 public:
  CloudLooks(std::vector<PlacedCloud> clouds, double reach, AgreementOptions options)
      : clouds_(std::move(clouds)), farthest_(kFarLook * reach) {
    std::stable_sort(clouds_.begin(), clouds_.end(),
                     [](const auto& a, const auto& b) { return a.time < b.time; });
    options_ = options_for(options, clouds_.back().time - clouds_.front().time);
  }

  Agreement judge() const {
    LookTable table(clouds_.front().time, farthest_);
    for (const PlacedCloud& from : clouds_) {
      std::vector<std::size_t> near;
      std::vector<std::pair<double, int>> times;
      for (std::size_t j = 0; j < clouds_.size(); ++j) {
        if ((from.sensor() - clouds_[j].sensor()).norm() > 2 * farthest_) continue;
        near.push_back(j);
        times.emplace_back(clouds_[j].time, clouds_[j].robot);
      }
      const auto looks = LookChoice(std::move(times), options_).around(from.time, from.robot);
      const std::vector<CloudPoint> places = chosen(from.view->surfaces(), kPlaces);
      for (const CloudPoint& place : places) {
        table.begin_place(from.time);
        for (const auto& [when, j] : looks) look(from, place, clouds_[near[j]], when, table);
      }
    }
    Agreement out = table.conclude();
    out.far_from = options_.far_from;
    return out;
  }

 private:
  void look(const PlacedCloud& from, const CloudPoint& place, const PlacedCloud& to, LookTime when,
            LookTable& table) const {
    const SE3 T = to.T_map_robot.between(from.T_map_robot);
    const Eigen::Vector3d at = T * place.position.cast<double>();
    const Eigen::Vector3d normal = T.rotation() * place.normal.cast<double>();
    const Eigen::Vector3d ray = at - to.view->sensor().cast<double>();
    if (ray.norm() > farthest_ || normal.dot(ray) > 0) return;  // from behind
    const auto found = to.view->finds(at.cast<float>(), normal.cast<float>());
    if (!found) return;
    const Eigen::Vector3d before =
        T.rotation() * (place.position - from.view->sensor()).cast<double>();
    table.add(when, ray.norm(), angle_between(before, ray), *found);
  }

  std::vector<PlacedCloud> clouds_;
  double farthest_;
  AgreementOptions options_;
};

}  // namespace

Agreement agreement_of_clouds(std::vector<PlacedCloud> clouds, double reach,
                              const AgreementOptions& options) {
  if (clouds.empty() || !(reach > 0)) return {};
  return CloudLooks(std::move(clouds), reach, options).judge();
}

}  // namespace hybrid
