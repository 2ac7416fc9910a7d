// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/map_faults.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

constexpr double kFarthest = 2.1e7;  // two places on Earth are no farther apart [m]
constexpr double kLatest = 1e11;     // [s] since 1970, some 3,000 years
/// A local map of which no more is known has no place [m].
constexpr double kMostUnknown = 1000.0;
constexpr float kMostSeen = 1e4F;  // from the anchor of a local cloud [m]
/// What something may stand for that is one landmark: a standard deviation [m], and things.
constexpr double kMostExtent = 1000.0;
constexpr int kMostThings = 1000000;
constexpr double kMostEvidence = 1e6;  // log odds of existence [nat]
constexpr int kMostSightings = 1000000000;
/// Of landmarks that the program numbers: a session has a track for each number, 300 MB.
constexpr std::int64_t kLastNumber = 1000000;
constexpr double kRounding = 1e-6;  // of correlations and probabilities
constexpr double kTolerance = 0.5;  // of a standard deviation, beside what the prior has lost

/// Whether a matrix is that of a density with standard deviations up to `most`.
bool is_covariance(const Eigen::MatrixXd& C, const Eigen::VectorXd& most) {
  const Eigen::VectorXd sigma = C.diagonal().cwiseMax(0).cwiseSqrt();
  if (!(sigma.minCoeff() > 0) || !(sigma.array() <= most.array()).all()) return false;
  const Eigen::VectorXd scale = sigma.cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * C * scale.asDiagonal();
  if (!correlation.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> roots(correlation, Eigen::EigenvaluesOnly);
  return roots.eigenvalues().minCoeff() > -kRounding;
}

bool is_place(const Eigen::Vector3d& position) {
  return position.cwiseAbs().maxCoeff() <= kFarthest;
}

bool are_probabilities(const std::vector<double>& p) {
  double sum = 0;
  for (const double v : p) {
    if (!(v >= 0 && v <= 1)) return false;
    sum += v;
  }
  return p.empty() || std::abs(sum - 1) < kRounding;
}

/// What a landmark alone cannot be; "" where it can.
std::string fault_of(const MapLandmark& l, const MapRecord& map) {
  const int dim = map.dim();
  if (!map.identified && l.id > kLastNumber) {
    return "landmarks without ids of a log are numbered up to " + std::to_string(kLastNumber);
  }
  if (!is_place(l.position)) return "it is at no place on Earth";
  const bool is_flat = map.is_3d || (l.position.z() == 0 && l.covariance.row(2).isZero(0) &&
                                     l.covariance.col(2).isZero(0));
  if (!is_flat) return "it is not in the plane of the map";
  if (!is_covariance(l.covariance.topLeftCorner(dim, dim),
                     Eigen::VectorXd::Constant(dim, kFarthest))) {
    return "it has no covariance";
  }
  if (!are_probabilities(l.class_probabilities)) return "its class probabilities do not sum to 1";
  if (!(std::abs(l.existence) <= kMostEvidence)) return "it has no log odds of its existence";
  if (l.sightings < 0 || l.sightings > kMostSightings) return "it has no number of sightings";
  if (l.size.extent < 0) return "it has a negative extent";
  if (!(l.size.extent <= kMostExtent)) return "it has an extent of more than a kilometre";
  if (l.size.things < 1 || l.size.things > kMostThings) return "it stands for no number of things";
  return "";
}

void check_landmarks(const MapRecord& map, std::vector<std::string>& faults) {
  const std::vector<Eigen::MatrixXd> implied = map.prior.covariances();
  const double allowed = kTolerance + std::sqrt(2 * map.prior.loss);
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    const MapLandmark& l = map.landmarks[i];
    std::string fault = fault_of(l, map);
    if (fault.empty()) {
      const double stated = std::sqrt(l.covariance.topLeftCorner(map.dim(), map.dim()).trace());
      const double by_prior = i < implied.size() ? std::sqrt(implied[i].trace()) : 0.0;
      if (!(std::abs(stated - by_prior) <= allowed * by_prior)) {
        fault = "its covariance and the prior contradict";
      }
    }
    if (!fault.empty()) faults.push_back("landmark " + std::to_string(l.id) + ": " + fault);
  }
}

void check_sessions(const MapRecord& map, std::vector<std::string>& faults) {
  for (const MapSession& session : map.sessions) {
    for (std::size_t k = 0; k < session.keyframes.size(); ++k) {
      const MapKeyframe& keyframe = session.keyframes[k];
      const std::string name =
          "keyframe " + std::to_string(k) + " of session " + std::to_string(session.id);
      if (!is_place(keyframe.T_map_robot.translation())) {
        faults.push_back(name + " is at no place on Earth");
      }
      if (!(std::abs(keyframe.time) <= kLatest)) faults.push_back(name + " is of no time");
    }
  }
}

/// Whether a local map has no parent, or one that comes before it and tells where it is.
template <class Pose>
bool has_sound_parent(const std::optional<PlaceParent<Pose>>& parent, std::size_t number,
                      const Eigen::VectorXd& most) {
  return !parent || (parent->place < number && is_covariance(parent->covariance, most));
}

void check_local_maps(const MapRecord& map, std::vector<std::string>& faults) {
  const Eigen::Vector3d most(kMostUnknown, kMostUnknown, M_PI);
  for (std::size_t m = 0; m < map.local_maps.size(); ++m) {
    const MapLocalMap& local = map.local_maps[m];
    const std::string name = "a local map of session " + std::to_string(local.session);
    if (!is_place({local.pose.x(), local.pose.y(), 0.0})) {
      faults.push_back(name + " is at no place on Earth");
    }
    if (!(std::abs(local.pose.z()) <= 2 * M_PI)) faults.push_back(name + " has no direction");
    if (!is_covariance(local.covariance, most)) faults.push_back(name + " has no covariance");
    if (!has_sound_parent(local.parent, m, most)) {
      faults.push_back(name + " is known beside none before it");
    }
  }
}

void check_local_clouds(const MapRecord& map, std::vector<std::string>& faults) {
  Eigen::Matrix<double, 6, 1> most;
  most << Eigen::Vector3d::Constant(kMostUnknown), Eigen::Vector3d::Constant(M_PI);
  for (std::size_t m = 0; m < map.local_clouds.size(); ++m) {
    const MapLocalCloud& local = map.local_clouds[m];
    const std::string name = "a local cloud of session " + std::to_string(local.session);
    const UncertainMotion3& anchor = local.T_map_anchor;
    if (!is_place(anchor.motion.translation())) faults.push_back(name + " is at no place on Earth");
    if (!anchor.motion.is_unit()) faults.push_back(name + " has no direction");
    if (!is_covariance(anchor.covariance, most)) faults.push_back(name + " has no covariance");
    if (!has_sound_parent(local.T_map_anchor.parent, m, most)) {
      faults.push_back(name + " is known beside none before it");
    }
    if (!(local.spacing > 0 && local.spacing <= kMostUnknown)) {
      faults.push_back(name + " has no spacing");
    }
    const bool is_far =
        std::any_of(local.points.begin(), local.points.end(), [](const MapCloudPoint& p) {
          return !(p.position.cwiseAbs().maxCoeff() <= kMostSeen) || !(p.normal.norm() < 1.1F);
        });
    if (is_far) faults.push_back(name + " has points that no sensor sees");
  }
}

}  // namespace

std::vector<std::string> faults_of(const MapRecord& map) {
  std::vector<std::string> faults;
  check_landmarks(map, faults);
  check_sessions(map, faults);
  check_local_maps(map, faults);
  check_local_clouds(map, faults);
  return faults;
}

}  // namespace hybrid
