// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/detail/localizer.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <type_traits>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/factors/sensor_view.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostLandmarks = 30;  // of the session, about its newest pose
constexpr int kFewestSightings = 2;
constexpr std::size_t kNews = 3;       // landmarks more or less, to look again
constexpr std::size_t kPatience = 10;  // keyframes without such news until it looks again

double distance_to(const std::vector<Eigen::Vector3d>& path, const Eigen::Vector3d& point) {
  double best = kInfinity;
  for (const Eigen::Vector3d& p : path) best = std::min(best, (p - point).norm());
  return best;
}

/// Half the landmarks are seen from nearer than this.
double usual_distance(const std::vector<Eigen::Vector3d>& path,
                      const std::vector<Eigen::Vector3d>& points) {
  if (path.empty() || points.empty()) return 0;
  std::vector<double> d;
  for (const Eigen::Vector3d& p : points) d.push_back(distance_to(path, p));
  return median(std::move(d));
}

/// The landmarks of a session that count, nearest to the newest pose first.
std::vector<const Landmark*> landmarks_about(const Mapper& mapper, const Eigen::Vector3d& here) {
  const Values& values = mapper.backend().values();
  const auto existence = mapper.existence();
  std::vector<std::pair<double, const Landmark*>> near;
  for (const auto& [id, landmark] : mapper.landmarks()) {
    const auto it = existence.find(id);
    if (landmark.sightings < kFewestSightings || (it != existence.end() && it->second <= 0))
      continue;
    near.emplace_back((point_at(values, landmark.position) - here).norm(), &landmark);
  }
  std::stable_sort(near.begin(), near.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  if (near.size() > kMostLandmarks) near.resize(kMostLandmarks);
  std::vector<const Landmark*> out;
  for (const auto& [distance, landmark] : near) out.push_back(landmark);
  return out;
}

/// The landmarks in the frame of the newest pose.
template <class Pose>
Constellation<Pose> constellation(const Pose& T_map_pose, Key pose,
                                  const std::vector<const Landmark*>& landmarks,
                                  const Backend& backend) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Matrix = typename Constellation<Pose>::Matrix;
  const Matrix R = T_map_pose.rotation().matrix().transpose();
  const Pose T_pose_map = T_map_pose.inverse();
  Constellation<Pose> out;
  for (const Landmark* landmark : landmarks) {
    const typename Pose::Point p =
        T_pose_map * backend.values().template at<typename Pose::Point>(landmark->position);
    Eigen::Matrix<double, kDim, Pose::kDim + kDim> J;
    J.template leftCols<kDim>() = -Matrix::Identity();
    J.template middleCols<Pose::kDim - kDim>(kDim) = rotation_derivative(p);
    J.template rightCols<kDim>() = R;
    out.points.push_back(p);
    out.covariances.push_back(backend.joint_covariance({pose, landmark->position}, J));
  }
  return out;
}

/// What the first pose is in the map, given the newest one there.
template <class Pose>
KnownStart start_of(const FoundPlace<Pose>& place, Key first, Key here, const Backend& backend) {
  const Pose T_session_first = backend.values().template at<Pose>(first);
  const Pose T_session_here = backend.values().template at<Pose>(here);
  const Pose T_here_first = T_session_here.between(T_session_first);
  using Jacobian = typename Pose::Jacobian;
  const Jacobian back = T_here_first.inverse().adjoint();
  Jacobian covariance = back * place.covariance * back.transpose();
  if (first != here) {
    Eigen::MatrixXd J(Pose::kDim, 2 * Pose::kDim);
    J << -back, Jacobian::Identity();
    covariance += backend.joint_covariance({here, first}, J);
  }
  Values value;
  value.insert(first, place.T_map_here * T_here_first);
  return {isometry_at(value, first), 0.5 * (covariance + covariance.transpose())};
}

}  // namespace

Localizer::Localizer(const MapRecord& map, double odds) : map_(map), search_(odds) {
  std::vector<Eigen::Vector3d> points;
  class_prior_.assign(map.class_names.size(), 1.0);
  for (int i = 0; i < static_cast<int>(map.landmarks.size()); ++i) {
    const MapLandmark& landmark = map.landmarks[static_cast<std::size_t>(i)];
    if (!exists(landmark)) continue;
    there_.push_back(i);
    points.push_back(landmark.position);
    for (std::size_t c = 0; c < landmark.class_probabilities.size(); ++c) {
      class_prior_[c] += landmark.class_probabilities[c];
    }
  }
  double sum = 0;
  for (const double p : class_prior_) sum += p;
  for (double& p : class_prior_) p /= sum;
  if (map.is_3d) {
    in_space_ = std::make_shared<PlaceMap<SE3>>(map, there_);
  } else {
    in_plane_ = std::make_shared<PlaceMap<SE2>>(map, there_);
  }
  for (const MapSession& session : map.sessions) {
    for (const MapKeyframe& k : session.keyframes) path_.push_back(k.T_map_robot.translation());
  }
  reach_ = usual_distance(path_, points);
}

bool Localizer::covers(const Eigen::Vector3d& point) const {
  return distance_to(path_, point) < reach_;
}

std::optional<KnownStart> Localizer::look(const Mapper& mapper) {
  const std::size_t landmarks = mapper.landmarks().size();
  const std::size_t news = landmarks > asked_ ? landmarks - asked_ : asked_ - landmarks;
  if (news < kNews && ++waited_ < kPatience) return std::nullopt;
  asked_ = landmarks;
  uses_ids_ = map_.identified && mapper.decisions().empty();
  waited_ = 0;
  return map_.is_3d ? look_in<SE3>(mapper) : look_in<SE2>(mapper);
}

/// Evidence that a landmark is one of the map, by its class, or by its id.
double Localizer::log_likelihood_ratio(std::int64_t id, const std::vector<double>& classes,
                                       int of_map) const {
  const MapLandmark& there =
      map_.landmarks[static_cast<std::size_t>(there_[static_cast<std::size_t>(of_map)])];
  const double ratio =
      same_class_log_likelihood_ratio(classes, there.class_probabilities, class_prior_);
  if (!uses_ids_) return ratio;
  return id == there.id ? ratio + std::log(there_.size()) : -kInfinity;  // the right one of so many
}

template <class Pose>
PlaceQuestion<Pose> Localizer::question_about_map() const {
  PlaceQuestion<Pose> out;
  if constexpr (std::is_same_v<Pose, SE2>) {
    out.map = in_plane_;
  } else {
    out.map = in_space_;
  }
  out.class_log_likelihood_ratio_in_map = [this](int i, int j) {
    const MapLandmark& l =
        map_.landmarks[static_cast<std::size_t>(there_[static_cast<std::size_t>(i)])];
    return log_likelihood_ratio(l.id, l.class_probabilities, j);
  };
  out.covers = [this](const typename Pose::Point& p) { return covers(padded_point(p)); };
  return out;
}

template <class Pose>
std::optional<KnownStart> Localizer::look_in(const Mapper& mapper) {
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  const Backend& backend = mapper.backend();
  const Key first(key_letter::kPose, 0), here(key_letter::kPose, mapper.log_rows().size() - 1);
  const Pose T_session_here = backend.values().at<Pose>(here);
  const Eigen::Vector3d position = padded_point(T_session_here.translation());
  const std::vector<const Landmark*> landmarks = landmarks_about(mapper, position);
  if (landmarks.size() <= kDim || there_.size() <= kDim) return std::nullopt;

  PlaceQuestion<Pose> question = question_about_map<Pose>();
  question.here = constellation<Pose>(T_session_here, here, landmarks, backend);
  std::vector<Eigen::Vector3d> path, points;
  for (std::size_t i = 0; i < mapper.log_rows().size(); ++i) {
    path.push_back(isometry_at(backend.values(), Key(key_letter::kPose, i)).translation());
  }
  double far = 0;
  for (const Landmark* landmark : landmarks) {
    points.push_back(point_at(backend.values(), landmark->position));
    far = std::max(far, (points.back() - position).norm());
  }
  const double reach = usual_distance(path, points);
  question.here.covers = [&](const typename Pose::Point& p) {
    return p.norm() < far && distance_to(path, padded_point(T_session_here * p)) < reach;
  };

  std::vector<DiscreteKey> classes;
  for (const Landmark* l : landmarks) {
    if (l->class_key) classes.push_back(*l->class_key);
  }
  Uncertainty known;
  try {
    known = backend.uncertainty({}, classes);
  } catch (const Error&) {
    return std::nullopt;  // linearised too far from the estimate to tell; later ones will
  }
  question.class_log_likelihood_ratio.resize(static_cast<Eigen::Index>(landmarks.size()),
                                             static_cast<Eigen::Index>(there_.size()));
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto p = landmarks[i]->class_key ? known.probabilities[landmarks[i]->class_key->key]
                                           : std::vector<double>{};
    for (int j = 0; j < static_cast<int>(there_.size()); ++j) {
      question.class_log_likelihood_ratio(static_cast<Eigen::Index>(i), j) =
          log_likelihood_ratio(landmarks[i]->id, p, j);
    }
  }
  const auto place = search_.find(question);
  if (!place) return std::nullopt;
  return start_of(*place, first, here, backend);
}

}  // namespace hybrid
