// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/join_maps.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <type_traits>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "libhybrid/maps/detail/place_seeds.h"
#include "libhybrid/maps/find_place.h"

namespace hybrid {
namespace {

constexpr int kRounds = 8;                  // of matching, in turn with estimation
constexpr std::size_t kAbout = 40;          // landmarks of a constellation
constexpr std::size_t kConstellations = 8;  // of the second map that are looked for
constexpr double kGate = 0.9999;
constexpr double kSame = 1e-4;  // how far two sightings of one landmark may lie apart [m]
constexpr double kFlat = 1e6;   // variances of a motion that is not known, by those that are

using Pairs = std::vector<std::pair<int, int>>;

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
      : a_(a), b_(b), there_a_(existing(a)), there_b_(existing(b)), odds_(odds) {
    Sa_ = joint_covariance(a);
    Sb_ = joint_covariance(b);
    prior_.assign(a.class_names.size(), 1.0);
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

  std::optional<JoinedMaps> run() {
    if (!find()) return std::nullopt;
    for (int round = 0; round < kRounds; ++round) {
      estimate();
      if (!match_more()) break;
    }
    log_odds_ = log_evidence(variance_factor());
    if (log_odds_ < std::log(odds_)) return std::nullopt;
    return result();
  }

 private:
  const MapLandmark& of_a(int i) const { return a_.landmarks[static_cast<std::size_t>(i)]; }
  const MapLandmark& of_b(int j) const { return b_.landmarks[static_cast<std::size_t>(j)]; }
  Point a(int i) const { return of_a(i).position.template head<kDim>(); }
  Point b(int j) const { return of_b(j).position.template head<kDim>(); }

  /// Evidence that two landmarks are one by their classes, or ids, one of so many.
  double ratio(const MapLandmark& l, const MapLandmark& m) const {
    if (a_.identified && l.id != m.id) return -kInfinity;
    const double by_id = a_.identified ? std::log(there_a_.size()) : 0.0;
    return by_id +
           same_class_log_likelihood_ratio(l.class_probabilities, m.class_probabilities, prior_);
  }

  /// The landmarks of the second map about one of them.
  std::vector<int> about(int anchor) const {
    std::vector<int> near = there_b_;
    std::stable_sort(near.begin(), near.end(), [&](int i, int j) {
      return (b(i) - b(anchor)).norm() < (b(j) - b(anchor)).norm();
    });
    if (near.size() > kAbout) near.resize(kAbout);
    return near;
  }

  /// The part of the questions that is the same for each constellation.
  PlaceQuestion<Pose> question_about_first() const {
    PlaceQuestion<Pose> question;
    std::vector<Eigen::Index> rows;
    for (const int i : there_a_) {
      question.map.push_back(a(i));
      for (int k = 0; k < kDim; ++k) rows.push_back(kDim * i + k);
    }
    question.covariance = Sa_(rows, rows);
    const auto n = static_cast<Eigen::Index>(there_a_.size());
    question.class_log_likelihood_ratio_in_map =
        Eigen::MatrixXd::NullaryExpr(n, n, [this](Eigen::Index i, Eigen::Index j) {
          return ratio(of_a(there_a_[i]), of_a(there_a_[j]));
        });
    return question;
  }

  /// The common place for which most speaks.
  bool find() {
    PlaceQuestion<Pose> question = question_about_first();
    PlaceSearch search(odds_);
    const std::size_t step = std::max<std::size_t>(1, there_b_.size() / kConstellations);
    for (std::size_t s = 0; s < there_b_.size(); s += step) {
      const std::vector<int> near = about(there_b_[s]);
      question.here = {};
      question.class_log_likelihood_ratio.resize(static_cast<Eigen::Index>(near.size()),
                                                 static_cast<Eigen::Index>(there_a_.size()));
      for (std::size_t k = 0; k < near.size(); ++k) {
        question.here.points.push_back(b(near[k]));
        question.here.covariances.push_back(relative_covariance<Pose>(Sb_, near[k], there_b_[s]));
        question.here.covariances.back().diagonal().array() += 1e-10;
        for (std::size_t i = 0; i < there_a_.size(); ++i) {
          question.class_log_likelihood_ratio(static_cast<Eigen::Index>(k),
                                              static_cast<Eigen::Index>(i)) =
              ratio(of_a(there_a_[i]), of_b(near[k]));
        }
      }
      const auto place = search.find(question);
      if (!place || place->log_odds < log_odds_) continue;
      log_odds_ = place->log_odds;
      T_ = place->T_map_here;
      pairs_.clear();
      for (const auto& [k, i] : place->pairs) {
        pairs_.emplace_back(there_a_[static_cast<std::size_t>(i)],
                            near[static_cast<std::size_t>(k)]);
      }
    }
    return !pairs_.empty() && search.stands_out(log_odds_);
  }

  /// All landmarks and the motion together, given that the pairs are one; linear about T_, which
  /// is then moved to where it comes out, until it stays.
  void estimate() {
    const auto na = static_cast<Eigen::Index>(a_.landmarks.size() * kDim);
    const auto nb = static_cast<Eigen::Index>(b_.landmarks.size() * kDim);
    for (int step = 0; step < kRounds; ++step) {
      const Eigen::MatrixXd R = T_.rotation().matrix();
      mean_.resize(na + nb + Pose::kDim);
      covariance_.setZero(na + nb + Pose::kDim, na + nb + Pose::kDim);
      Eigen::MatrixXd J(nb, Pose::kDim), turn = Eigen::MatrixXd::Zero(nb, nb);
      for (std::size_t i = 0; i < a_.landmarks.size(); ++i) {
        mean_.segment<kDim>(kDim * static_cast<Eigen::Index>(i)) = a(static_cast<int>(i));
      }
      double extent = 1;
      for (std::size_t j = 0; j < b_.landmarks.size(); ++j) {
        const Eigen::Index at = kDim * static_cast<Eigen::Index>(j);
        const Point p = b(static_cast<int>(j));
        mean_.segment<kDim>(na + at) = T_ * p;
        J.block<kDim, kDim>(at, 0) = R;
        J.block<kDim, Pose::kDim - kDim>(at, kDim) = -R * rotation_derivative(p);
        turn.block<kDim, kDim>(at, at) = R;
        extent = std::max(extent, p.norm());
      }
      mean_.tail<Pose::kDim>().setZero();
      Eigen::VectorXd free(Pose::kDim);
      const double known = Sb_.diagonal().mean() + kSame * kSame;
      free.head<kDim>().setConstant(kFlat * known);
      free.tail<Pose::kDim - kDim>().setConstant(kFlat * known / (extent * extent));
      const Eigen::MatrixXd JP = J * free.asDiagonal();
      covariance_.topLeftCorner(na, na) = Sa_;
      covariance_.block(na, na, nb, nb) = turn * Sb_ * turn.transpose() + JP * J.transpose();
      covariance_.block(na, na + nb, nb, Pose::kDim) = JP;
      covariance_.block(na + nb, na, Pose::kDim, nb) = JP.transpose();
      covariance_.bottomRightCorner<Pose::kDim, Pose::kDim>() = free.asDiagonal();
      condition(na);
      const typename Pose::Tangent move = mean_.template tail<Pose::kDim>();
      T_ = T_ * Pose::exp(move);
      if (move.norm() < 1e-9 * extent) break;
    }
  }

  /// Conditions on every pair being one.
  void condition(Eigen::Index na) {
    const auto m = static_cast<Eigen::Index>(pairs_.size() * kDim);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(m, mean_.size());
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const Eigen::Index row = kDim * static_cast<Eigen::Index>(p);
      H.block<kDim, kDim>(row, kDim * pairs_[p].first).setIdentity();
      H.block<kDim, kDim>(row, na + kDim * pairs_[p].second) =
          -Eigen::Matrix<double, kDim, kDim>::Identity();
    }
    const Eigen::MatrixXd HC = H * covariance_;
    Eigen::MatrixXd S = HC * H.transpose();
    S.diagonal().array() += kSame * kSame;
    const Eigen::LDLT<Eigen::MatrixXd> ldlt(S);
    const Eigen::VectorXd innovation = -H * mean_;
    const Eigen::VectorXd weighted = ldlt.solve(innovation);
    chi_square_ = innovation.dot(weighted);
    log_det_ = ldlt.vectorD().array().log().sum();
    mean_ += HC.transpose() * weighted;
    covariance_ -= HC.transpose() * ldlt.solve(HC);
    covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  }

  /// By how much the maps disagree more than what each knows of itself allows: the a posteriori
  /// variance factor of the pairs, 1 where their chi-square is within the gate.
  double variance_factor() const {
    const int rows = kDim * static_cast<int>(pairs_.size());
    if (chi_square_ <= chi_square_quantile(kGate, rows)) return 1;
    return chi_square_ / (rows - Pose::kDim);
  }

  /// log odds that the pairs are one each, and not landmarks that lie so by chance, with all
  /// covariances larger by a factor.
  double log_evidence(double factor) const {
    const auto n = static_cast<double>(pairs_.size());
    double sum = -0.5 * (chi_square_ / factor + log_det_ + n * kDim * std::log(2 * M_PI * factor)) -
                 n * log_density();
    for (const auto& [i, j] : pairs_) sum += ratio(of_a(i), of_b(j));
    return sum;
  }

  double log_density() const {
    std::vector<Point> points;
    for (const int i : there_a_) points.push_back(a(i));
    return std::log(local_density(points));
  }

  /// Adds pairs that lie together now and are nearest to each other. False where there are none.
  bool match_more() {
    const auto na = static_cast<Eigen::Index>(a_.landmarks.size() * kDim);
    const double density = log_density();
    const double gate = chi_square_quantile(kGate, kDim);
    struct Candidate {
      double cost;
      int i, j;
    };
    std::vector<Candidate> candidates;
    for (const int i : there_a_) {
      for (const int j : there_b_) {
        const Eigen::Index p = kDim * i, q = na + kDim * j;
        const Point d = mean_.segment<kDim>(p) - mean_.segment<kDim>(q);
        const double r = ratio(of_a(i), of_b(j));
        if (!std::isfinite(r)) continue;
        Eigen::Matrix<double, kDim, kDim> S =
            covariance_.block<kDim, kDim>(p, p) + covariance_.block<kDim, kDim>(q, q) -
            covariance_.block<kDim, kDim>(p, q) - covariance_.block<kDim, kDim>(q, p);
        S.diagonal().array() += kSame * kSame;
        const Eigen::LLT<Eigen::Matrix<double, kDim, kDim>> llt(S);
        const double chi_square = d.dot(llt.solve(d));
        if (!(chi_square < gate)) continue;
        const double cost = 0.5 * chi_square + llt.matrixLLT().diagonal().array().log().sum() +
                            0.5 * kDim * std::log(2 * M_PI) + density - r;
        if (cost < 0) candidates.push_back({cost, i, j});
      }
    }
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const Candidate& x, const Candidate& y) { return x.cost < y.cost; });
    const std::size_t before = pairs_.size();
    for (const Candidate& c : candidates) {
      const bool taken = std::any_of(pairs_.begin(), pairs_.end(), [&](const auto& p) {
        return p.first == c.i || p.second == c.j;
      });
      if (!taken) pairs_.emplace_back(c.i, c.j);
    }
    return pairs_.size() > before;
  }

  std::vector<double> product(const std::vector<double>& p, const std::vector<double>& q) const {
    std::vector<double> out(p.size());
    double sum = 0;
    for (std::size_t c = 0; c < p.size(); ++c) sum += out[c] = p[c] * q[c];
    for (double& v : out) v = sum > 0 ? v / sum : 1.0 / static_cast<double>(p.size());
    return out;
  }

  JoinedMaps result() const {
    JoinedMaps out;
    Values value;
    value.insert(Key(), T_);
    out.T_first_second = isometry_at(value, Key());
    out.covariance = covariance_.bottomRightCorner<Pose::kDim, Pose::kDim>();
    out.variance_factor = variance_factor();
    out.common = pairs_.size();
    out.log_odds = log_odds_;
    MapRecord& map = out.map;
    map.is_3d = a_.is_3d;
    map.identified = a_.identified;
    map.class_names = a_.class_names;
    map.origin = a_.origin;
    map.sessions = a_.sessions;
    const int shift = a_.sessions.empty() ? 0 : a_.sessions.back().id;
    for (MapSession session : b_.sessions) {
      session.id += shift;
      for (MapKeyframe& k : session.keyframes) k.T_map_robot = out.T_first_second * k.T_map_robot;
      map.sessions.push_back(std::move(session));
    }
    std::vector<Eigen::Index> rows = take_landmarks(shift, map);
    const Eigen::MatrixXd joint = covariance_(rows, rows);
    for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
      const Eigen::Index at = kDim * static_cast<Eigen::Index>(i);
      map.landmarks[i].covariance.setZero();
      map.landmarks[i].covariance.topLeftCorner<kDim, kDim>() = joint.block<kDim, kDim>(at, at);
    }
    map.prior = sparsify(joint, kDim);
    return out;
  }

  /// The landmarks of both, and the rows of the estimate that they are.
  std::vector<Eigen::Index> take_landmarks(int shift, MapRecord& map) const {
    struct Entry {
      MapLandmark landmark;
      Eigen::Index row;
    };
    std::vector<Entry> all;
    std::int64_t next = 0;
    for (std::size_t i = 0; i < a_.landmarks.size(); ++i) {
      all.push_back({a_.landmarks[i], kDim * static_cast<Eigen::Index>(i)});
      next = std::max(next, a_.landmarks[i].id + 1);
    }
    for (std::size_t j = 0; j < b_.landmarks.size(); ++j) {
      const auto pair = std::find_if(pairs_.begin(), pairs_.end(), [&](const auto& p) {
        return p.second == static_cast<int>(j);
      });
      MapLandmark l = b_.landmarks[j];
      if (pair != pairs_.end()) {
        MapLandmark& known = all[static_cast<std::size_t>(pair->first)].landmark;
        known.sightings += l.sightings;
        known.existence = std::max(known.existence, l.existence);
        known.class_probabilities = product(known.class_probabilities, l.class_probabilities);
        continue;
      }
      const auto same_id = [&](const Entry& e) { return e.landmark.id == l.id; };
      if (a_.identified && std::any_of(all.begin(), all.end(), same_id)) {
        throw Error("landmark " + std::to_string(l.id) + " lies elsewhere in the other map");
      }
      if (!a_.identified) l.id = next++;
      l.session += shift;
      all.push_back({l, kDim * static_cast<Eigen::Index>(a_.landmarks.size() + j)});
    }
    std::stable_sort(all.begin(), all.end(),
                     [](const Entry& x, const Entry& y) { return x.landmark.id < y.landmark.id; });
    std::vector<Eigen::Index> rows;
    for (Entry& e : all) {
      e.landmark.position.template head<kDim>() = mean_.segment<kDim>(e.row);
      for (int k = 0; k < kDim; ++k) rows.push_back(e.row + k);
      map.landmarks.push_back(std::move(e.landmark));
    }
    return rows;
  }

  const MapRecord &a_, &b_;
  std::vector<int> there_a_, there_b_;
  double odds_;
  Eigen::MatrixXd Sa_, Sb_;
  std::vector<double> prior_;  // of classes
  Pose T_;
  Pairs pairs_;
  double log_odds_ = 0, chi_square_ = 0, log_det_ = 0;
  Eigen::VectorXd mean_;        // of both maps in the frame of the first, and of the motion
  Eigen::MatrixXd covariance_;  // of these
};

}  // namespace

std::optional<JoinedMaps> join_maps(const MapRecord& first, const MapRecord& second, double odds) {
  if (first.is_3d != second.is_3d) throw Error("one map is in the plane, the other in space");
  if (first.class_names != second.class_names) throw Error("the maps have different classes");
  if (first.identified != second.identified) {
    throw Error("the landmarks of one map have the ids of its log, those of the other do not");
  }
  return first.is_3d ? MapJoin<SE3>(first, second, odds).run()
                     : MapJoin<SE2>(first, second, odds).run();
}

MapRecord without_landmarks(const MapRecord& map, const std::vector<std::int64_t>& ids) {
  MapRecord out = map;
  out.landmarks.clear();
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (std::find(ids.begin(), ids.end(), map.landmarks[i].id) != ids.end()) continue;
    out.landmarks.push_back(map.landmarks[i]);
    for (int k = 0; k < map.dim(); ++k) {
      rows.push_back(map.dim() * static_cast<Eigen::Index>(i) + k);
    }
  }
  const Eigen::MatrixXd joint = joint_covariance(map);
  out.prior = sparsify(joint(rows, rows), map.dim());
  return out;
}

}  // namespace hybrid
