// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/constellation.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "libhybrid/association/matching.h"
#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/infinity.h"
#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/sensor_view.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

constexpr int kMaxSteps = 10;            // of Gauss-Newton
constexpr double kSmall = 1e-6;          // step at which it ends
constexpr double kAboveGate = 1 + 1e-9;  // for rounding

template <class Pose>
class PlaceSearch {
 public:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Point = typename Pose::Point;
  using Matrix = typename Constellation<Pose>::Matrix;
  using Tangent = typename Pose::Tangent;
  using Jacobian = typename Pose::Jacobian;
  using Pair = std::pair<int, int>;

  PlaceSearch(const ConstellationMatchProblem<Pose>& question, const PlaceOptions& options)
      : q_(question),
        options_(options),
        gate_(chi_square_quantile(options.gate, kDim)),
        information_(question.covariance.inverse()) {
    log_det_prior_ = std::log(q_.covariance.determinant());
  }

  std::vector<ConstellationMatch<Pose>> run() {
    find_pairs();
    for (const auto& [p, q] : pairs_of_pairs()) {
      if (explained(pairs_[p], pairs_[q])) continue;
      follow({pairs_[p], pairs_[q]});
    }
    std::stable_sort(answers_.begin(), answers_.end(),
                     [](const auto& x, const auto& y) { return x.cost < y.cost; });
    if (answers_.size() > static_cast<std::size_t>(options_.answers)) {
      answers_.resize(static_cast<std::size_t>(options_.answers));
    }
    return std::move(answers_);
  }

 private:
  /// An estimate of T_a_b with what it explains.
  struct Fit {
    Pose T;
    Jacobian information;   // of T, prior included
    double chi_square = 0;  // of prior and pairs
    double log_det = 0;     // sum over pairs of log det(2 pi R)
  };

  struct Residual {
    Point r;
    Matrix R;  // its noise
    Eigen::Matrix<double, kDim, Pose::kDim> J;
  };

  /// Of a pair given T: T b - a.
  Residual residual(const Pose& T, const Pair& pair) const {
    const Point& b = q_.b.points[pair.second];
    const Matrix R = T.rotation().matrix();
    Residual out;
    out.r = T * b - q_.a.points[pair.first];
    out.R = q_.a.covariances[pair.first] + R * q_.b.covariances[pair.second] * R.transpose();
    out.J.template leftCols<kDim>() = R;
    out.J.template rightCols<Pose::kDim - kDim>() = -R * rotation_derivative(b);
    return out;
  }

  /// A landmark of b in the frame of a, its noise there, and what it owes to that of T.
  struct Seen {
    Point point;
    Matrix noise, by_T;
  };

  std::vector<Seen> seen_from(const Pose& T, const Jacobian& covariance) const {
    std::vector<Seen> out;
    const Matrix R = T.rotation().matrix();
    Eigen::Matrix<double, kDim, Pose::kDim> J;
    J.template leftCols<kDim>() = R;
    for (std::size_t j = 0; j < q_.b.points.size(); ++j) {
      J.template rightCols<Pose::kDim - kDim>() = -R * rotation_derivative(q_.b.points[j]);
      out.push_back({T * q_.b.points[j], R * q_.b.covariances[j] * R.transpose(),
                     J * covariance * J.transpose()});
    }
    return out;
  }

  /// Pairs that the prior allows.
  void find_pairs() {
    for (int i = 0; i < static_cast<int>(q_.a.points.size()); ++i) {
      for (int j = 0; j < static_cast<int>(q_.b.points.size()); ++j) {
        if (!std::isfinite(q_.class_log_likelihood_ratio(i, j))) continue;
        const Residual d = residual(q_.T_a_b, {i, j});
        const Matrix S = d.R + d.J * q_.covariance * d.J.transpose();
        if (d.r.dot(S.llt().solve(d.r)) <= gate_) pairs_.emplace_back(i, j);
      }
    }
  }

  /// Two pairs whose landmarks are as far apart here as there, the most telling ones first.
  std::vector<Pair> pairs_of_pairs() const {
    struct Ranked {
      double cost;
      int p, q;
    };
    std::vector<Ranked> ranked;
    const double gate = chi_square_quantile(options_.gate, 1);
    for (int p = 0; p < static_cast<int>(pairs_.size()); ++p) {
      const auto [i, j] = pairs_[p];
      for (int q = p + 1; q < static_cast<int>(pairs_.size()); ++q) {
        const auto [k, l] = pairs_[q];
        if (i == k || j == l) continue;
        const double in_a = (q_.a.points[i] - q_.a.points[k]).norm();
        const double in_b = (q_.b.points[j] - q_.b.points[l]).norm();
        const double variance = (q_.a.covariances[i].trace() + q_.a.covariances[k].trace() +
                                 q_.b.covariances[j].trace() + q_.b.covariances[l].trace()) /
                                kDim;
        const double off = (in_a - in_b) * (in_a - in_b) / variance;
        if (off > gate) continue;
        // What a distance tells grows with it: long baselines fix the rotation.
        ranked.push_back({0.5 * off - 0.5 * std::log(in_a * in_a + variance), p, q});
      }
    }
    const auto most = std::min(ranked.size(), static_cast<std::size_t>(options_.hypotheses));
    std::partial_sort(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(most),
                      ranked.end(), [](const Ranked& x, const Ranked& y) {
                        return std::tie(x.cost, x.p, x.q) < std::tie(y.cost, y.p, y.q);
                      });
    ranked.resize(most);
    std::vector<Pair> out;
    for (const Ranked& r : ranked) out.emplace_back(r.p, r.q);
    return out;
  }

  /// Whether an answer holds both.
  bool explained(const Pair& p, const Pair& q) const {
    return std::any_of(answers_.begin(), answers_.end(),
                       [&](const ConstellationMatch<Pose>& answer) {
                         return std::binary_search(answer.pairs.begin(), answer.pairs.end(), p) &&
                                std::binary_search(answer.pairs.begin(), answer.pairs.end(), q);
                       });
  }

  /// The most probable T_a_b given some pairs, from `start`.
  Fit fit(const Pose& start, const std::vector<Pair>& pairs) const {
    Fit out;
    out.T = start;
    for (int step = 0; step < kMaxSteps; ++step) {
      const Tangent off = q_.T_a_b.between(out.T).log();
      const Jacobian by_T = Pose::right_jacobian_inverse(off);
      out.information = by_T.transpose() * information_ * by_T;
      Tangent gradient = by_T.transpose() * information_ * off;
      out.chi_square = off.dot(information_ * off);
      out.log_det = 0;
      for (const Pair& pair : pairs) {
        const Residual d = residual(out.T, pair);
        const Eigen::LLT<Matrix> llt(d.R);
        const Point w = llt.solve(d.r);
        out.information += d.J.transpose() * llt.solve(d.J);
        gradient += d.J.transpose() * w;
        out.chi_square += d.r.dot(w);
        out.log_det += std::log(d.R.determinant()) + kDim * std::log(2 * M_PI);
      }
      const Tangent move = out.information.ldlt().solve(-gradient);
      if (move.norm() < kSmall) break;
      out.T = out.T * Pose::exp(move);
    }
    return out;
  }

  /// All pairs under `T`, one to one, where a match beats two landmarks of their own.
  std::vector<Pair> match(const Fit& fit) const {
    const Jacobian covariance = fit.information.inverse();
    const std::vector<Seen> there = seen_from(fit.T, covariance);
    struct Candidate {
      int i, j;
      double cost;
    };
    std::vector<Candidate> candidates;
    for (const auto& [i, j] : pairs_) {
      const Point r = there[j].point - q_.a.points[i];
      const Matrix S = q_.a.covariances[i] + there[j].noise + there[j].by_T;
      // No eigenvalue of S is above its trace.
      if (r.squaredNorm() > kAboveGate * gate_ * S.trace()) continue;
      const Eigen::LLT<Matrix> llt(S);
      const double chi_square = r.dot(llt.solve(r));
      if (chi_square > gate_) continue;
      const double cost = 0.5 * chi_square + 0.5 * std::log(S.determinant()) +
                          0.5 * kDim * std::log(2 * M_PI) + gain(i, j);
      if (cost < 0) candidates.push_back({i, j, cost});
    }
    // Landmarks without a candidate do not count.
    std::vector<int> rows, columns;
    for (const Candidate& c : candidates) {
      rows.push_back(c.i);
      columns.push_back(c.j);
    }
    const auto place_in = [](const std::vector<int>& all, int value) {
      return std::lower_bound(all.begin(), all.end(), value) - all.begin();
    };
    sort_unique(rows);
    sort_unique(columns);
    MatchingProblem problem;
    problem.matched.setConstant(static_cast<Eigen::Index>(rows.size()),
                                static_cast<Eigen::Index>(columns.size()), kInfinity);
    problem.unmatched.setZero(problem.matched.rows());
    for (const Candidate& c : candidates) {
      problem.matched(place_in(rows, c.i), place_in(columns, c.j)) = c.cost;
    }
    const std::vector<int> column = best_matching(problem).column;
    std::vector<Pair> out;
    for (std::size_t i = 0; i < column.size(); ++i) {
      if (column[i] >= 0) out.emplace_back(rows[i], columns[static_cast<std::size_t>(column[i])]);
    }
    return out;
  }

  /// -log of the likelihood of a pair apart from its position.
  double gain(int i, int j) const { return q_.log_density - q_.class_log_likelihood_ratio(i, j); }

  void follow(std::vector<Pair> pairs) {
    Fit at = fit(q_.T_a_b, pairs);
    if (at.chi_square > chi_square_quantile(options_.gate, 2 * kDim)) return;
    std::set<std::vector<Pair>> own;  // that this has come by
    for (int round = 0; round < kMaxSteps; ++round) {
      std::vector<Pair> next = match(at);
      if (next.size() < 2) return;
      const bool same = next == pairs;
      pairs = std::move(next);
      if (same) break;
      const bool mine = !own.insert(pairs).second;
      if (!followed_.insert(pairs).second && !mine) return;  // it is known where they lead
      at = fit(at.T, pairs);
    }
    const bool known = std::any_of(answers_.begin(), answers_.end(),
                                   [&](const auto& answer) { return answer.pairs == pairs; });
    if (known) return;
    ConstellationMatch<Pose> answer;
    answer.T_a_b = at.T;
    answer.chi_square = at.chi_square;
    answer.cost = 0.5 * (at.chi_square + at.log_det + log_det_prior_ +
                         std::log(at.information.determinant()));
    for (const auto& [i, j] : pairs) answer.cost += gain(i, j);
    answer.cost += q_.missed * missing(at.T, pairs);
    answer.pairs = std::move(pairs);
    answers_.push_back(std::move(answer));
  }

  /// How many landmarks one place has and the other covers but lacks.
  int missing(const Pose& T, const std::vector<Pair>& pairs) const {
    std::vector<bool> a(q_.a.points.size()), b(q_.b.points.size());
    for (const auto& [i, j] : pairs) a[i] = b[j] = true;
    int count = 0;
    const Pose inverse = T.inverse();
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!a[i] && q_.b.covers && q_.b.covers(inverse * q_.a.points[i])) ++count;
    }
    for (std::size_t j = 0; j < b.size(); ++j) {
      if (!b[j] && q_.a.covers && q_.a.covers(T * q_.b.points[j])) ++count;
    }
    return count;
  }

  const ConstellationMatchProblem<Pose>& q_;
  const PlaceOptions& options_;
  double gate_;
  Jacobian information_;
  double log_det_prior_ = 0;
  std::vector<Pair> pairs_;
  std::set<std::vector<Pair>> followed_;
  std::vector<ConstellationMatch<Pose>> answers_;
};

}  // namespace

template <class Pose>
std::vector<ConstellationMatch<Pose>> match_places(const ConstellationMatchProblem<Pose>& question,
                                                   const PlaceOptions& options) {
  return PlaceSearch<Pose>(question, options).run();
}

template std::vector<ConstellationMatch<SE2>> match_places(const ConstellationMatchProblem<SE2>&,
                                                           const PlaceOptions&);
template std::vector<ConstellationMatch<SE3>> match_places(const ConstellationMatchProblem<SE3>&,
                                                           const PlaceOptions&);

}  // namespace hybrid
