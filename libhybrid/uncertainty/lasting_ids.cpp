// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/lasting_ids.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>

#include "libhybrid/core/quantile.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr double kAbsence = 5;      // s, longer than trackers keep what they do not see
constexpr std::size_t kLooks = 10;  // frames with a place in view, in which it would be seen
constexpr std::size_t kFewestIds = 10;
constexpr std::size_t kMostChecks = 2000000;  // of places against frames: a tenth of a second

struct IdLife {
  double last = 0;  // s
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  std::size_t looks = 0;  // since then
  bool again = false, returned = false, due = false;
};

/// Ranges and angles at which a sensor detects most of what it does.
struct View {
  double nearest = 0, farthest = 0, right = 0, left = 0;
  bool contains(const Eigen::Vector3d& z) const {
    return z[0] > nearest && z[0] < farthest && z[1] > right && z[1] < left;
  }
};

View view_of(const std::vector<MovedSightings>& frames) {
  std::vector<double> ranges, yaws;
  for (const MovedSightings& frame : frames) {
    for (const MeasuredPoint& m : frame.sightings.seen) {
      ranges.push_back(m.z[0]);
      yaws.push_back(m.z[1]);
    }
  }
  if (ranges.empty()) return {};
  return {quantile(ranges, 0.1), quantile(ranges, 0.8), quantile(yaws, 0.1), quantile(yaws, 0.9)};
}

Eigen::Vector3d sighted_place(const MovedSightings& frame, const Eigen::VectorXd& z) {
  return frame.T_odometry_robot * (frame.sightings.T_robot_sensor * from_polar(padded_point(z)));
}

/// One of the places where an id was seen.
struct SeenPlace {
  Eigen::Vector3d place;
  Eigen::Matrix3d covariance;  // of what was seen there last, and of the odometry since
  std::size_t sightings = 1;
};

/// Sigmas between a place and what is seen now, by which it is another place.
constexpr double kElsewhere = 5;
/// Odometry may be so many times worse than stated: what is elsewhere after a long way tells
/// nothing.
constexpr double kWorseOdometry = 5;
constexpr std::size_t kFewestThere = 3;
constexpr double kLeastShareThere = 0.2;  // of the sightings of an id; less are errors
constexpr std::size_t kMostPlaces = 8;

/// Of a place that was sighted, by the noise that is stated of the sighting.
Eigen::Matrix3d place_covariance(const MovedSightings& frame, const MeasuredPoint& m) {
  Eigen::Matrix3d sigma = Eigen::Matrix3d::Zero();
  sigma.topLeftCorner(m.z.size(), m.z.size()) = m.covariance;
  Eigen::Matrix3d J;
  from_polar(padded_point(m.z), &J);
  const Eigen::Matrix3d R =
      (frame.T_odometry_robot * frame.sightings.T_robot_sensor).rotation().matrix();
  return R * J * sigma * J.transpose() * R.transpose();
}

/// The places of one id, in the order in which it was seen.
class PlacesOfId {
 public:
  /// `drift` is the variance of the odometry since the sighting before [m^2].
  void add(const Eigen::Vector3d& place, const Eigen::Matrix3d& covariance, double drift) {
    for (SeenPlace& p : places_) p.covariance += drift * Eigen::Matrix3d::Identity();
    std::size_t best = places_.size();
    double least = kElsewhere * kElsewhere;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Eigen::Vector3d e = place - places_[i].place;
      const Eigen::Matrix3d P =
          places_[i].covariance + covariance + kRounded * Eigen::Matrix3d::Identity();
      const double squared = e.dot(P.ldlt().solve(e));
      if (squared < least) {
        least = squared;
        best = i;
      }
    }
    if (best == places_.size()) {
      if (places_.size() >= kMostPlaces) return;
      places_.push_back({place, covariance});
    } else {
      SeenPlace& there = places_[best];
      ++there.sightings;
      there.place = place;
      there.covariance = covariance;
    }
    ++sightings_;
  }

  /// How far the two places are apart that are of two things; nothing where they are not.
  std::optional<double> apart() const {
    std::vector<const SeenPlace*> all;
    for (const SeenPlace& p : places_) {
      const bool is_one = p.sightings >= kFewestThere &&
                          static_cast<double>(p.sightings) >= kLeastShareThere * sightings_;
      if (is_one) all.push_back(&p);
    }
    if (all.size() < 2) return std::nullopt;
    return (all[0]->place - all[1]->place).norm();
  }

 private:
  static constexpr double kRounded = 1e-6;  // m^2, of numbers in millimetres
  std::vector<SeenPlace> places_;
  double sightings_ = 0;
};

/// Variance that odometry adds to a place which is `away` from the robot [m^2].
double drift_of(const SE3::Jacobian& covariance, double away) {
  return covariance.topLeftCorner<3, 3>().trace() +
         away * away * covariance.bottomRightCorner<3, 3>().trace();
}

}  // namespace

std::vector<SharedId> shared_ids(const std::vector<MovedSightings>& frames) {
  std::map<std::int64_t, PlacesOfId> places;
  std::map<std::int64_t, SE3::Jacobian> driven;  // when an id was seen: the odometry up to then
  SE3::Jacobian all = SE3::Jacobian::Zero();
  int chain = frames.empty() ? 0 : frames.front().chain;
  for (const MovedSightings& frame : frames) {
    if (frame.chain != chain) return {};  // places before and after are not in one frame
    all += frame.motion_covariance;
    for (std::size_t k = 0; k < frame.ids.size(); ++k) {
      if (!frame.ids[k]) continue;
      const MeasuredPoint& m = frame.sightings.seen[k];
      SE3::Jacobian& before = driven.try_emplace(*frame.ids[k], all).first->second;
      places[*frame.ids[k]].add(sighted_place(frame, m.z), place_covariance(frame, m),
                                kWorseOdometry * kWorseOdometry * drift_of(all - before, m.z[0]));
      before = all;
    }
  }
  std::vector<SharedId> out;
  for (const auto& [id, of_id] : places) {
    if (const auto apart = of_id.apart()) out.push_back({id, *apart});
  }
  return 4 * out.size() <= places.size() ? out : std::vector<SharedId>();
}

std::optional<double> IdReturns::share() const {
  if (due >= kFewestIds) return static_cast<double>(returned) / static_cast<double>(due);
  if (ids >= kFewestIds) return static_cast<double>(again) / static_cast<double>(ids);
  return std::nullopt;
}

IdReturns count_id_returns(const std::vector<MovedSightings>& frames) {
  std::map<std::int64_t, IdLife> lives;
  const View view = view_of(frames);
  std::size_t checks = 0;
  for (const MovedSightings& frame : frames) {
    const double time = frame.sightings.time;
    for (std::size_t k = 0; k < frame.ids.size(); ++k) {
      if (!frame.ids[k]) continue;
      const auto [it, is_new] = lives.try_emplace(*frame.ids[k]);
      IdLife& life = it->second;
      if (!is_new) life.again = true;
      if (!is_new && time - life.last > kAbsence) life.returned = true;
      life.last = time;
      life.place = sighted_place(frame, frame.sightings.seen[k].z);
      life.looks = 0;
    }
    if (checks > kMostChecks) continue;
    const SE3 T_sensor_odometry =
        (frame.T_odometry_robot * frame.sightings.T_robot_sensor).inverse();
    for (auto& [id, life] : lives) {
      ++checks;
      if (life.due || life.returned || time - life.last <= kAbsence) continue;
      if (!view.contains(to_polar(Eigen::Vector3d(T_sensor_odometry * life.place)))) continue;
      if (++life.looks >= kLooks) life.due = true;
    }
  }
  IdReturns out;
  out.ids = lives.size();
  for (const auto& [id, life] : lives) {
    if (life.again) ++out.again;
    if (life.due) ++out.due;
    if (life.returned) ++out.returned;
  }
  out.due += out.returned;
  return out;
}

}  // namespace hybrid
