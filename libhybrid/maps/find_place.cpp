// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/find_place.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "libhybrid/core/infinity.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/maps/detail/place_seeds.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostSeeds = 12;  // that are matched and weighed
constexpr int kHypotheses = 100;        // pairs of pairs of each that are followed up
constexpr int kPieces = 20;             // of a map, by which chance is measured
constexpr std::size_t kCover = 4;       // of them that a landmark is in: large ones are much alike
constexpr double kPairGate = 0.9999;    // chi-square probability

template <class Pose>
class PlaceFinder {
 public:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;
  static constexpr int kTurn = Pose::kDim - kDim;
  using Point = typename Pose::Point;
  using Jacobian = typename Pose::Jacobian;

  explicit PlaceFinder(const PlaceQuestion<Pose>& question)
      : q_(question), map_(q_.map->points()), density_(q_.map->density()) {
    for (const Point& p : q_.here.points) center_ += p / static_cast<double>(q_.here.points.size());
    for (const Point& p : q_.here.points) radius_ = std::max(radius_, (p - center_).norm());
  }

  /// The places that were weighed, the most probable first.
  std::vector<FoundPlace<Pose>> run() const {
    std::vector<FoundPlace<Pose>> found;
    for (const PlaceSeed<Pose>& seed : place_seeds(q_, density_, kMostSeeds)) {
      if (auto place = weigh(seed)) found.push_back(std::move(*place));
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& a, const auto& b) { return a.log_odds > b.log_odds; });
    return found;
  }

  bool same(const FoundPlace<Pose>& a, const FoundPlace<Pose>& b) const {
    double sum = 0;
    for (const Point& p : q_.here.points) sum += (a.T_map_here * p - b.T_map_here * p).norm();
    return sum / static_cast<double>(q_.here.points.size()) < 0.5 * spacing();
  }

 private:
  /// The landmarks of the map about a guess, relative to its anchor.
  std::vector<int> about(const Pose& T_map_here) const {
    const Point middle = T_map_here * center_;
    std::vector<int> out;
    for (int j = 0; j < static_cast<int>(map_.size()); ++j) {
      if ((map_[j] - middle).norm() < 1.5 * radius_) out.push_back(j);
    }
    return out;
  }

  std::optional<FoundPlace<Pose>> weigh(const PlaceSeed<Pose>& seed) const {
    const std::vector<int> near = about(seed.T_map_here);
    ConstellationMatchProblem<Pose> match;
    std::vector<double> variances;
    match.a.covariances = q_.map->relative_covariances(seed.anchor, near);
    for (std::size_t k = 0; k < near.size(); ++k) {
      match.a.points.push_back(map_[static_cast<std::size_t>(near[k])]);
      match.a.covariances[k].diagonal().array() += 1e-10;  // of the anchor itself
      variances.push_back(match.a.covariances[k].trace() / kDim);
    }
    match.a.covers = q_.covers;
    match.b = q_.here;
    for (const auto& C : q_.here.covariances) variances.push_back(C.trace() / kDim);
    match.T_a_b = seed.T_map_here;
    match.covariance.setZero();
    // Five sigmas are wide beside what the landmarks say; one place is not two that are apart.
    const double width = std::min(25 * median(variances), spacing() * spacing());
    match.covariance.diagonal().template head<kDim>().setConstant(width);
    match.covariance.diagonal().template tail<kTurn>().setConstant(width / (radius_ * radius_));
    match.class_log_likelihood_ratio.resize(static_cast<Eigen::Index>(near.size()),
                                            q_.class_log_likelihood_ratio.rows());
    for (std::size_t k = 0; k < near.size(); ++k) {
      match.class_log_likelihood_ratio.row(static_cast<Eigen::Index>(k)) =
          q_.class_log_likelihood_ratio.col(near[k]).transpose();
    }
    match.log_density = std::log(density_);
    PlaceOptions options;
    options.gate = kPairGate;
    options.answers = 1;
    options.hypotheses = kHypotheses;
    const auto answers = match_places(match, options);
    if (answers.empty() || answers.front().pairs.size() <= kDim) return std::nullopt;
    return place_of(answers.front(), match, near);
  }

  FoundPlace<Pose> place_of(const ConstellationMatch<Pose>& answer,
                            const ConstellationMatchProblem<Pose>& match,
                            const std::vector<int>& near) const {
    FoundPlace<Pose> out;
    out.T_map_here = answer.T_a_b;
    Jacobian information = Jacobian::Zero();
    const auto R = answer.T_a_b.rotation().matrix();
    for (const auto& [a, b] : answer.pairs) {
      Eigen::Matrix<double, kDim, Pose::kDim> J;
      J.template leftCols<kDim>() = R;
      J.template rightCols<kTurn>() = -R * rotation_derivative(match.b.points[b]);
      const Eigen::Matrix<double, kDim, kDim> S =
          match.a.covariances[a] + R * match.b.covariances[b] * R.transpose();
      information += J.transpose() * S.llt().solve(J);
      out.pairs.emplace_back(b, near[static_cast<std::size_t>(a)]);
    }
    std::sort(out.pairs.begin(), out.pairs.end());
    out.covariance = information.inverse();
    // The prior of the match gives way to one that is uniform over map and headings.
    const double narrow =
        0.5 * std::log(match.covariance.determinant()) + 0.5 * Pose::kDim * std::log(2 * M_PI);
    out.log_odds = -(answer.cost - narrow + q_.map->log_volume_of_poses());
    return out;
  }

  /// How far landmarks are apart.
  double spacing() const { return std::exp(-std::log(density_) / kDim); }

  const PlaceQuestion<Pose>& q_;
  const std::vector<Point>& map_;
  double density_;
  Point center_ = Point::Zero();
  double radius_ = 1e-3;
};

/// With the second axis turned round.
template <class Pose>
PlaceQuestion<Pose> mirrored(const PlaceQuestion<Pose>& question) {
  using Point = typename Pose::Point;
  PlaceQuestion<Pose> out = question;
  for (Point& p : out.here.points) p[1] = -p[1];
  for (auto& covariance : out.here.covariances) {
    covariance.row(1) *= -1;
    covariance.col(1) *= -1;
  }
  if (question.here.covers) {
    out.here.covers = [&covers = question.here.covers](Point p) {
      p[1] = -p[1];
      return covers(p);
    };
  }
  return out;
}

/// Whether the landmarks come to overlap in both places.
template <class Pose>
bool overlap(const PlaceQuestion<Pose>& question, const FoundPlace<Pose>& place,
             const PlaceQuestion<Pose>& other, const FoundPlace<Pose>& there) {
  using Point = typename Pose::Point;
  const auto middle = [](const PlaceQuestion<Pose>& q, const FoundPlace<Pose>& p) {
    Point sum = Point::Zero();
    for (const Point& x : q.here.points) sum += p.T_map_here * x;
    return Point(sum / static_cast<double>(q.here.points.size()));
  };
  const Point a = middle(question, place), b = middle(other, there);
  double extent = 0;
  for (const Point& x : question.here.points) {
    extent = std::max(extent, (place.T_map_here * x - a).norm());
  }
  return (a - b).norm() < extent;
}

/// The landmarks of the map about one of them as those of `here`.
template <class Pose>
PlaceQuestion<Pose> piece_about(const PlaceQuestion<Pose>& question, int anchor, std::size_t size) {
  const auto& points = question.map->points();
  std::vector<int> near(points.size());
  std::iota(near.begin(), near.end(), 0);
  const auto distance = [&](int i) { return (points[i] - points[anchor]).norm(); };
  std::stable_sort(near.begin(), near.end(),
                   [&](int i, int j) { return distance(i) < distance(j); });
  near.resize(size);
  PlaceQuestion<Pose> out = question;
  out.here = {{}, question.map->relative_covariances(anchor, near), question.covers};
  for (const int i : near) out.here.points.push_back(points[i]);
  for (auto& C : out.here.covariances) C.diagonal().array() += 1e-10;  // of the anchor itself
  out.class_log_likelihood_ratio = Eigen::MatrixXd::NullaryExpr(
      static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(points.size()),
      [&](Eigen::Index k, Eigen::Index j) {
        return question.class_log_likelihood_ratio_in_map(near[static_cast<std::size_t>(k)],
                                                          static_cast<int>(j));
      });
  return out;
}

/// Whether there are enough landmarks for a place to be found.
template <class Pose>
bool fixes_place(const PlaceQuestion<Pose>& question) {
  constexpr std::size_t kFewest = Pose::Point::RowsAtCompileTime + 1;
  return question.here.points.size() >= kFewest && question.map->points().size() >= kFewest;
}

/// What the mirror image reaches elsewhere than the original: a street looks much like its own
/// mirror image, and what is found in the right place is not chance.
template <class Pose>
double chance(const PlaceQuestion<Pose>& question, const FoundPlace<Pose>* original) {
  double out = 0;
  const PlaceQuestion<Pose> mirror = mirrored(question);
  for (const FoundPlace<Pose>& place : PlaceFinder<Pose>(mirror).run()) {
    if (original != nullptr && overlap(question, *original, mirror, place)) continue;
    out = std::max(out, place.log_odds);
  }
  return out;
}

}  // namespace

template <class Pose>
std::optional<FoundPlace<Pose>> PlaceSearch::find(const PlaceQuestion<Pose>& question) {
  if (!fixes_place(question)) return std::nullopt;
  const PlaceFinder<Pose> finder(question);
  const std::vector<FoundPlace<Pose>> found = finder.run();
  chance_ = std::max(chance_, chance(question, found.empty() ? nullptr : &found.front()));
  if (found.empty() || !stands_out(found.front().log_odds)) return std::nullopt;
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (finder.same(found[i], found.front())) continue;
    if (found.front().log_odds - found[i].log_odds < margin_) return std::nullopt;
    break;
  }
  if (found.front().log_odds < margin_ + chance_of_pieces(question)) return std::nullopt;
  return found.front();
}

/// What the mirror images of pieces of the map reach that have as many landmarks.
template <class Pose>
double PlaceSearch::chance_of_pieces(const PlaceQuestion<Pose>& question) {
  const std::size_t size = std::min(question.here.points.size(), question.map->points().size());
  const auto [known, is_new] = chance_of_pieces_.try_emplace(size, 0.0);
  if (!is_new) return known->second;
  const int n = static_cast<int>(question.map->points().size());
  const int covering = static_cast<int>(kCover * question.map->points().size() / size);
  const int pieces = std::min({n, kPieces, covering});
  const FoundPlace<Pose> itself;
  for (int k = 0; k < pieces; ++k) {
    const double reached = chance(piece_about(question, k * n / pieces, size), &itself);
    known->second = std::max(known->second, reached);
  }
  return known->second;
}

double same_class_log_likelihood_ratio(const std::vector<double>& p, const std::vector<double>& q,
                                       const std::vector<double>& prior) {
  if (p.empty() || q.empty()) return 0;
  double sum = 0;
  for (std::size_t s = 0; s < p.size(); ++s) {
    if (prior[s] > 0) sum += p[s] * q[s] / prior[s];
  }
  return sum > 0 ? std::log(sum) : -kInfinity;
}

template std::optional<FoundPlace<SE2>> PlaceSearch::find(const PlaceQuestion<SE2>&);
template std::optional<FoundPlace<SE3>> PlaceSearch::find(const PlaceQuestion<SE3>&);

}  // namespace hybrid
