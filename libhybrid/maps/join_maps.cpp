// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/join_maps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/maps/detail/agreeing_pairs.h"
#include "libhybrid/maps/detail/joined_record.h"
#include "libhybrid/maps/detail/joint_estimate.h"
#include "libhybrid/maps/find_place.h"
#include "libhybrid/maps/sparse_gaussian.h"

namespace hybrid {
namespace {

constexpr int kRounds = 8;                  // of matching, in turn with estimation
constexpr std::size_t kAbout = 40;          // landmarks of a constellation
constexpr std::size_t kConstellations = 8;  // of the second map that are looked for
constexpr std::size_t kNearest = 4;         // landmarks of the second that one of the first may be
constexpr std::size_t kMostTested = 300;    // pairs by ids that are tested together
constexpr double kGate = 0.9999;

std::vector<int> existing(const MapRecord& map) {
  std::vector<int> out;
  for (int i = 0; i < static_cast<int>(map.landmarks.size()); ++i) {
    if (exists(map.landmarks[static_cast<std::size_t>(i)])) out.push_back(i);
  }
  return out;
}

template <class Pose>
class MapJoin {
 public:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Point = typename Pose::Point;

  MapJoin(const MapRecord& a, const MapRecord& b, double odds)
      : a_(a),
        b_(b),
        there_a_(existing(a)),
        there_b_(existing(b)),
        odds_(odds),
        map_a_(std::make_shared<PlaceMap<Pose>>(a, there_a_)),
        map_b_(b, there_b_),
        joint_(a, b) {
    prior_.assign(std::max(a.class_names.size(), b.class_names.size()), 1.0);
    for (const MapRecord* map : {&a, &b}) {
      for (const MapLandmark& l : map->landmarks) {
        for (std::size_t c = 0; c < l.class_probabilities.size(); ++c) {
          prior_[c] += l.class_probabilities[c];
        }
      }
    }
    double sum = 0;
    for (const double p : prior_) sum += p;
    for (double& p : prior_) p /= sum;
  }

  /// Of maps of which it is known where the second is in the first.
  JoinedMaps run_at(const Pose& T, const typename Pose::Jacobian& covariance) {
    is_known_ = true;
    joint_.know(T, covariance);
    joint_.estimate(pairs_, T);
    if (!there_a_.empty() && !there_b_.empty()) match_all();
    return result();
  }

  std::optional<JoinedMaps> run() {
    if (!find()) return std::nullopt;
    pair_by_ids();
    joint_.estimate(pairs_, T_);
    if (!a_.identified || there_a_.size() > kMostTested) match_all();
    log_odds_ = log_evidence(variance_factor());
    if (log_odds_ < std::log(odds_)) return std::nullopt;
    return result();
  }

 private:
  const MapLandmark& of_a(int i) const { return a_.landmarks[static_cast<std::size_t>(i)]; }
  const MapLandmark& of_b(int j) const { return b_.landmarks[static_cast<std::size_t>(j)]; }

  /// Evidence that two landmarks are one by their classes, or ids, one of so many.
  double ratio(const MapLandmark& l, const MapLandmark& m) const {
    if (a_.identified && l.id != m.id) return -kInfinity;
    const double by_id = a_.identified ? std::log(there_a_.size()) : 0.0;
    return by_id +
           same_class_log_likelihood_ratio(l.class_probabilities, m.class_probabilities, prior_);
  }

  /// The landmarks of the second map about one of them, by their places among those that exist.
  std::vector<int> about(int anchor) const {
    const std::vector<Point>& points = map_b_.points();
    std::vector<int> near;
    for (int k = 0; k < static_cast<int>(points.size()); ++k) near.push_back(k);
    const auto distance = [&](int k) {
      return (points[static_cast<std::size_t>(k)] - points[static_cast<std::size_t>(anchor)])
          .norm();
    };
    std::stable_sort(near.begin(), near.end(),
                     [&](int i, int j) { return distance(i) < distance(j); });
    if (near.size() > kAbout) near.resize(kAbout);
    return near;
  }

  /// The part of the questions that is the same for each constellation.
  PlaceQuestion<Pose> question_about_first() const {
    PlaceQuestion<Pose> question;
    question.map = map_a_;
    question.class_log_likelihood_ratio_in_map = [this](int i, int j) {
      return ratio(of_a(there_a_[static_cast<std::size_t>(i)]),
                   of_a(there_a_[static_cast<std::size_t>(j)]));
    };
    return question;
  }

  /// The common place for which most speaks.
  bool find() {
    PlaceQuestion<Pose> question = question_about_first();
    PlaceSearch search(odds_);
    const std::size_t step = std::max<std::size_t>(1, there_b_.size() / kConstellations);
    for (std::size_t s = 0; s < there_b_.size(); s += step) {
      const std::vector<int> near = about(static_cast<int>(s));
      question.here = {{}, map_b_.relative_covariances(static_cast<int>(s), near), {}};
      question.class_log_likelihood_ratio.resize(static_cast<Eigen::Index>(near.size()),
                                                 static_cast<Eigen::Index>(there_a_.size()));
      for (std::size_t k = 0; k < near.size(); ++k) {
        const auto j = static_cast<std::size_t>(near[k]);
        question.here.points.push_back(map_b_.points()[j]);
        question.here.covariances[k].diagonal().array() += 1e-10;
        for (std::size_t i = 0; i < there_a_.size(); ++i) {
          question.class_log_likelihood_ratio(static_cast<Eigen::Index>(k),
                                              static_cast<Eigen::Index>(i)) =
              ratio(of_a(there_a_[i]), of_b(there_b_[j]));
        }
      }
      const auto place = search.find(question);
      if (!place || place->log_odds < log_odds_) continue;
      log_odds_ = place->log_odds;
      T_ = place->T_map_here;
      pairs_.clear();
      for (const auto& [k, i] : place->pairs) {
        pairs_.emplace_back(there_a_[static_cast<std::size_t>(i)],
                            there_b_[static_cast<std::size_t>(near[static_cast<std::size_t>(k)])]);
      }
    }
    return !pairs_.empty() && search.stands_out(log_odds_);
  }

  /// Where ids tell which landmarks are one: these, without those that contradict all others.
  void pair_by_ids() {
    if (!a_.identified) return;
    std::map<std::int64_t, int> of_id;
    for (const int i : there_a_) of_id[of_a(i).id] = i;
    LandmarkPairs all;
    for (const int j : there_b_) {
      const auto it = of_id.find(of_b(j).id);
      if (it != of_id.end()) all.emplace_back(it->second, j);
    }
    if (all.size() <= kMostTested) pairs_ = agreeing_pairs(a_, b_, std::move(all), T_);
  }

  /// By how much the maps disagree more than what each knows of itself allows: the a posteriori
  /// variance factor of the pairs, 1 where their chi-square is within the gate.
  double variance_factor() const {
    const int freedom = kDim * static_cast<int>(pairs_.size()) - (is_known_ ? 0 : Pose::kDim);
    if (freedom <= 0) return 1;
    if (joint_.chi_square() <= chi_square_quantile(kGate, freedom)) return 1;
    return joint_.chi_square() / freedom;
  }

  /// log odds that the pairs are one each, and not landmarks that lie so by chance, with all
  /// covariances larger by a factor. The second map is anywhere in the first, in any direction.
  double log_evidence(double factor) const {
    const auto n = static_cast<double>(pairs_.size());
    double sum = joint_.log_density() + 0.5 * joint_.chi_square() * (1 - 1 / factor) -
                 0.5 * (n * kDim - Pose::kDim) * std::log(factor) -
                 n * std::log(map_a_->density()) - map_a_->log_volume_of_poses();
    for (const auto& [i, j] : pairs_) sum += ratio(of_a(i), of_b(j));
    return sum;
  }

  /// A landmark of each map that may be one, and what speaks against it.
  struct Candidate {
    double cost;
    int i, j;
  };

  /// The landmarks of the second map that one of the first can be, the nearest ones.
  std::vector<int> nearest(int i, const std::vector<int>& of_second) const {
    std::vector<std::pair<double, int>> near;
    const Point p = joint_.at(joint_.first(i));
    for (const int j : of_second) {
      if (std::isfinite(ratio(of_a(i), of_b(j)))) {
        near.emplace_back((joint_.at(joint_.second(j)) - p).norm(), j);
      }
    }
    const std::size_t count = std::min(kNearest, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    std::vector<int> out;
    for (std::size_t k = 0; k < count; ++k) out.push_back(near[k].second);
    return out;
  }

  /// What speaks against two landmarks being one; nothing where they are too far apart.
  std::optional<double> cost(int i, int j, double factor, const Covariances& alone) const {
    const Key p = joint_.first(i), q = joint_.second(j);
    const Point d = joint_.at(p) - joint_.at(q);
    const double gate = chi_square_quantile(kGate, kDim) * factor;
    // A difference has at most twice the variance of what is subtracted.
    if (d.squaredNorm() > 2 * gate * (alone.at(p).trace() + alone.at(q).trace())) return {};
    const Eigen::MatrixXd C = joint_.marginals().joint_covariance({p, q});
    const Eigen::Matrix<double, kDim, kDim> S =
        C.topLeftCorner(kDim, kDim) + C.bottomRightCorner(kDim, kDim) -
        C.topRightCorner(kDim, kDim) - C.bottomLeftCorner(kDim, kDim);
    const Eigen::LLT<Eigen::Matrix<double, kDim, kDim>> llt(S);
    const double chi_square = d.dot(llt.solve(d));
    if (!(chi_square < gate)) return {};
    return 0.5 * chi_square / factor + llt.matrixLLT().diagonal().array().log().sum() +
           0.5 * kDim * std::log(2 * M_PI * factor) + std::log(map_a_->density()) -
           ratio(of_a(i), of_b(j));
  }

  /// Pairs more, in turn with estimation.
  void match_all() {
    for (int round = 0; round < kRounds && match_more(); ++round) {
      joint_.estimate(pairs_, joint_.T_first_second());
    }
  }

  /// Adds pairs that lie together now and are nearest to each other. False where there are none.
  bool match_more() {
    const double factor = variance_factor();
    const Covariances alone = joint_.marginals().all();
    std::set<int> paired_a, paired_b;
    for (const auto& [i, j] : pairs_) {
      paired_a.insert(i);
      paired_b.insert(j);
    }
    std::vector<int> free_b;
    for (const int j : there_b_) {
      if (paired_b.count(j) == 0) free_b.push_back(j);
    }
    std::vector<Candidate> candidates;
    for (const int i : there_a_) {
      if (paired_a.count(i) > 0) continue;
      for (const int j : nearest(i, free_b)) {
        const std::optional<double> c = cost(i, j, factor, alone);
        if (c && *c < 0) candidates.push_back({*c, i, j});
      }
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.cost < y.cost; });
    const std::size_t before = pairs_.size();
    for (const Candidate& c : candidates) {
      if (paired_a.count(c.i) > 0 || paired_b.count(c.j) > 0) continue;
      pairs_.emplace_back(c.i, c.j);
      paired_a.insert(c.i);
      paired_b.insert(c.j);
    }
    return pairs_.size() > before;
  }

  JoinedMaps result() const {
    JoinedMaps out;
    Values value;
    value.insert(Key(), joint_.T_first_second());
    out.T_first_second = isometry_at(value, Key());
    out.covariance = joint_.covariance();
    out.variance_factor = variance_factor();
    out.common = pairs_.size();
    out.log_odds = log_odds_;
    record_join(a_, b_, pairs_, joint_, out);
    return out;
  }

  const MapRecord &a_, &b_;
  std::vector<int> there_a_, there_b_;
  double odds_;
  std::shared_ptr<const PlaceMap<Pose>> map_a_;
  PlaceMap<Pose> map_b_;
  std::vector<double> prior_;  // of classes
  Pose T_;
  LandmarkPairs pairs_;
  double log_odds_ = 0;
  bool is_known_ = false;  // where the second map is in the first
  JointEstimate<Pose> joint_;
};

/// Throws Error where a log is in both maps.
void refuse_common_logs(const MapRecord& first, const MapRecord& second) {
  for (const MapSession& a : first.sessions) {
    for (const MapSession& b : second.sessions) {
      for (const std::string& log : a.logs) {
        if (log.empty() || std::count(b.logs.begin(), b.logs.end(), log) == 0) continue;
        throw Error("its session " + std::to_string(b.id) + " mapped the log of session " +
                    std::to_string(a.id) +
                    " of the other map: what it measured would count twice; join the map from "
                    "before, or extend one map by the other logs");
      }
    }
  }
}

}  // namespace

void refuse_to_join(const MapRecord& first, const MapRecord& second) {
  if (first.is_3d != second.is_3d) throw Error("one map is in the plane, the other in space");
  if (!first.landmarks.empty() && !second.landmarks.empty()) {
    if (first.class_names != second.class_names) throw Error("the maps have different classes");
    if (first.identified != second.identified) {
      throw Error("the landmarks of one map have the ids of its log, those of the other do not");
    }
  }
  refuse_common_logs(first, second);
}

JoinedMaps join_maps_at(const MapRecord& first, const MapRecord& second,
                        const Eigen::Isometry3d& T_first_second,
                        const Eigen::MatrixXd& covariance) {
  refuse_to_join(first, second);
  JoinedMaps out =
      first.is_3d ? MapJoin<SE3>(first, second, 1.0).run_at(to_se3(T_first_second), covariance)
                  : MapJoin<SE2>(first, second, 1.0).run_at(to_se2(T_first_second), covariance);
  out.was_known = true;
  return out;
}

std::optional<JoinedMaps> join_maps(const MapRecord& first, const MapRecord& second, double odds) {
  refuse_to_join(first, second);
  return first.is_3d ? MapJoin<SE3>(first, second, odds).run()
                     : MapJoin<SE2>(first, second, odds).run();
}

MapRecord without_landmarks(const MapRecord& map, const std::vector<std::int64_t>& ids) {
  const std::set<std::int64_t> gone(ids.begin(), ids.end());
  const KnownMap known = known_map(map);
  const HybridGraph graph(known.prior);
  MapRecord out = map;
  out.landmarks.clear();
  Values values;
  std::vector<Key> left;
  for (const MapLandmark& landmark : map.landmarks) {
    const Key key = position_key(landmark.id);
    values.insert(key, Eigen::VectorXd(landmark.position.head(map.dim())));
    if (gone.count(landmark.id) > 0) continue;
    out.landmarks.push_back(landmark);
    left.push_back(key);
  }
  out.prior = sparsify(graph, values, left, map.dim());
  return out;
}

}  // namespace hybrid
