// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/maps/detail/place_seeds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/core/quantile.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

constexpr std::size_t kFigures = 300;    // of landmarks of here that are looked for, at most
constexpr std::size_t kGuesses = 20000;  // that are scored, at most
constexpr double kSigmas = 3;            // by which two distances may differ

/// Two landmarks, three in space, that fix a rigid motion.
template <int N>
using Figure = std::array<int, N>;

template <class Point>
double size_of(const std::vector<Point>& p, const Figure<2>& f) {
  return (p[f[0]] - p[f[1]]).norm();
}
template <class Point>
double size_of(const std::vector<Point>& p, const Figure<3>& f) {
  return (p[f[1]] - p[f[0]]).cross(p[f[2]] - p[f[0]]).norm();
}

/// The largest figure about each landmark in turn, then the second largest, and so on.
template <int N, class Point>
std::vector<Figure<N>> figures(const std::vector<Point>& points) {
  const int n = static_cast<int>(points.size());
  std::vector<std::vector<Figure<N>>> own(points.size());
  std::size_t all = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (j == i) continue;
      if constexpr (N == 2) {
        own[i].push_back({i, j});
      } else {
        for (int k = j + 1; k < n; ++k) {
          if (k != i) own[i].push_back({i, j, k});
        }
      }
    }
    std::stable_sort(own[i].begin(), own[i].end(), [&](const auto& a, const auto& b) {
      return size_of(points, a) > size_of(points, b);
    });
    all += own[i].size();
  }
  std::vector<Figure<N>> out;
  for (std::size_t rank = 0; out.size() < std::min(all, kFigures); ++rank) {
    for (const auto& list : own) {
      if (rank < list.size()) out.push_back(list[rank]);
    }
  }
  return out;
}

template <class Pose>
Pose fitted(const std::array<typename Pose::Point, Pose::Point::RowsAtCompileTime>& from,
            const std::array<typename Pose::Point, Pose::Point::RowsAtCompileTime>& to) {
  constexpr int N = Pose::Point::RowsAtCompileTime;
  Eigen::Matrix<double, N, N> a, b;
  for (int i = 0; i < N; ++i) {
    a.col(i) = from[static_cast<std::size_t>(i)];
    b.col(i) = to[static_cast<std::size_t>(i)];
  }
  const Eigen::Matrix<double, N + 1, N + 1> T = Eigen::umeyama(a, b, false);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().template topLeftCorner<N, N>() = T.template topLeftCorner<N, N>();
  pose.translation().template head<N>() = T.template topRightCorner<N, 1>();
  if constexpr (N == 2) {
    return to_se2(pose);
  } else {
    return to_se3(pose);
  }
}

template <class Pose>
class SeedSearch {
 public:
  static constexpr int kDim = Pose::Point::RowsAtCompileTime;
  using Point = typename Pose::Point;
  using Neighbour = typename PlaceMap<Pose>::Neighbour;

  SeedSearch(const PlaceQuestion<Pose>& question, double density)
      : q_(question), map_(q_.map->points()), log_density_(std::log(density)) {
    double reach = 0;
    for (const Point& a : q_.here.points) {
      for (const Point& b : q_.here.points) reach = std::max(reach, (a - b).norm());
    }
    spacing_ = std::exp(-log_density_ / kDim);
    reach_ = 1.1 * reach;
    for (int i = 0; i < static_cast<int>(map_.size()); ++i) {
      const auto [x, y] = cell_of(map_[i]);
      for (int cell = 0; cell < 9; ++cell) near_[{x + cell / 3 - 1, y + cell % 3 - 1}].push_back(i);
    }
  }

  std::vector<PlaceSeed<Pose>> run(std::size_t most) {
    for (const Figure<kDim>& figure : figures<kDim>(q_.here.points)) {
      for (int a = 0; a < static_cast<int>(map_.size()); ++a) extend(figure, a);
      if (guesses_ > kGuesses) break;
    }
    std::stable_sort(seeds_.begin(), seeds_.end(),
                     [](const auto& a, const auto& b) { return a.score > b.score; });
    std::vector<PlaceSeed<Pose>> out;
    std::vector<std::vector<Point>> seen;  // from each of them
    for (const PlaceSeed<Pose>& seed : seeds_) {
      std::vector<Point> places = places_of(seed);
      const bool near = std::any_of(seen.begin(), seen.end(),
                                    [&](const auto& better) { return same(places, better); });
      if (near) continue;
      out.push_back(seed);
      seen.push_back(std::move(places));
      if (out.size() == most) break;
    }
    return out;
  }

 private:
  bool possible(int i, int a) const { return q_.class_log_likelihood_ratio(i, a) > -3; }

  /// Variances of two landmarks of here, along an axis.
  double variance(int i, int j) const {
    return (q_.here.covariances[i].trace() + q_.here.covariances[j].trace()) / kDim;
  }

  /// The landmarks that those of here can be if one is `a`, and some farther than that.
  const std::vector<Neighbour>& neighbours(int a) const {
    return q_.map->neighbours(a, reach_ + spacing_);
  }

  /// Variance of a landmark of the map relative to another one near by; infinity elsewhere.
  double relative(int a, int b) const {
    const std::vector<Neighbour>& all = neighbours(a);
    const Neighbour wanted{(map_[a] - map_[b]).norm(), b, 0};
    const auto it = std::lower_bound(all.begin(), all.end(), wanted);
    return it != all.end() && it->landmark == b ? it->variance : kInfinity;
  }

  /// Landmarks of the map as far from a as j is from i.
  template <class Use>
  void visit(int i, int j, int a, const Use& use) const {
    const double d = (q_.here.points[i] - q_.here.points[j]).norm();
    const std::vector<Neighbour>& all = neighbours(a);
    const auto end = std::lower_bound(all.begin(), all.end(), Neighbour{reach_, -1, 0});
    if (end == all.begin()) return;
    // The variance relative to the anchor differs between neighbours: the widest bounds the range.
    const double own = variance(i, j);
    const double wide = kSigmas * std::sqrt(own + std::prev(end)->variance);
    auto it = std::lower_bound(all.begin(), end, Neighbour{d - wide, -1, 0});
    for (; it != end && it->distance < d + wide; ++it) {
      const int b = it->landmark;
      if (b == a || !possible(j, b)) continue;
      if (std::abs(it->distance - d) < kSigmas * std::sqrt(own + it->variance)) use(b);
    }
  }

  void extend(const Figure<kDim>& f, int a) {
    if (!possible(f[0], a)) return;
    visit(f[0], f[1], a, [&](int b) {
      if constexpr (kDim == 2) {
        take(f, {a, b});
      } else {
        visit(f[0], f[2], a, [&](int c) {
          const double want = (q_.here.points[f[1]] - q_.here.points[f[2]]).norm();
          const double got = (map_[b] - map_[c]).norm();
          const double off = kSigmas * std::sqrt(variance(f[1], f[2]) + relative(b, c));
          if (c != b && std::abs(want - got) < off) take(f, {a, b, c});
        });
      }
    });
  }

  void take(const Figure<kDim>& f, const Figure<kDim>& m) {
    if (++guesses_ > kGuesses) return;
    go_to(m[0]);
    std::array<Point, kDim> from, to;
    for (std::size_t k = 0; k < kDim; ++k) {
      from[k] = q_.here.points[f[k]];
      to[k] = map_[m[k]];
    }
    PlaceSeed<Pose> seed{fitted<Pose>(from, to), m[0], 0};
    const double baseline = (from[1] - from[0]).norm() + 1e-9;
    for (std::size_t i = 0; i < q_.here.points.size(); ++i) {
      const Point p = seed.T_map_here * q_.here.points[i];
      const double lever = 1 + (q_.here.points[i] - from[0]).norm() / baseline;
      seed.score += gain(static_cast<int>(i), p, lever * lever);
    }
    if (seed.score > 0) seeds_.push_back(seed);
  }

  /// Has the variances relative to an anchor at hand.
  void go_to(int anchor) {
    if (anchor == anchor_) return;
    by_anchor_.resize(map_.size(), kInfinity);
    if (anchor_ >= 0) {
      for (const Neighbour& n : neighbours(anchor_)) by_anchor_[n.landmark] = kInfinity;
    }
    for (const Neighbour& n : neighbours(anchor)) by_anchor_[n.landmark] = n.variance;
    anchor_ = anchor;
  }

  /// What the best landmark of the map near a point is worth.
  double gain(int i, const Point& p, double lever) const {
    const auto near = near_.find(cell_of(p));
    if (near == near_.end()) return 0;
    double best = 0;
    const double own = q_.here.covariances[i].trace() / kDim;
    // No landmark has a smaller variance: most are found to be too far without a logarithm.
    const double most =
        1e-9 - log_density_ - 0.5 * kDim * std::log(2 * M_PI * (lever * own + 1e-12));
    for (const int j : near->second) {
      const double squared = (map_[j] - p).squaredNorm();
      if (squared > spacing_ * spacing_ || !possible(i, j)) continue;
      const double s2 = lever * (own + by_anchor_[j]) + 1e-12;
      if (q_.class_log_likelihood_ratio(i, j) + most - 0.5 * squared / s2 < best) continue;
      best = std::max(best, q_.class_log_likelihood_ratio(i, j) - log_density_ -
                                0.5 * kDim * std::log(2 * M_PI * s2) - 0.5 * squared / s2);
    }
    return best;
  }

  /// Cells as wide as landmarks are apart; those of the plane go by x and y.
  using Cell = std::pair<std::int64_t, std::int64_t>;
  Cell cell_of(const Point& p) const {
    const auto index = [this](double x) {
      return static_cast<std::int64_t>(std::clamp(std::floor(x / spacing_), -1e15, 1e15));
    };
    return {index(p[0]), index(p[1])};
  }
  struct HashOfCell {
    std::size_t operator()(const Cell& cell) const {
      return static_cast<std::size_t>(cell.first) * 0x9e3779b97f4a7c15u ^
             static_cast<std::size_t>(cell.second);
    }
  };

  /// Where a guess puts the landmarks.
  std::vector<Point> places_of(const PlaceSeed<Pose>& seed) const {
    std::vector<Point> out;
    out.reserve(q_.here.points.size());
    for (const Point& p : q_.here.points) out.push_back(seed.T_map_here * p);
    return out;
  }

  /// Whether two guesses put the landmarks to the same places, by how these are apart.
  bool same(const std::vector<Point>& a, const std::vector<Point>& b) const {
    const auto count = static_cast<double>(a.size());
    const double far = 0.5 * spacing_ * count * (1 + 1e-9);
    double sum = 0;
    for (std::size_t i = 0; i < a.size() && sum <= far; ++i) sum += (a[i] - b[i]).norm();
    return sum / count < 0.5 * spacing_;
  }

  const PlaceQuestion<Pose>& q_;
  const std::vector<Point>& map_;
  double log_density_;
  double spacing_ = 0;  // of landmarks [m]
  double reach_ = 0;    // how far landmarks of here are apart, at most [m]
  int anchor_ = -1;
  std::vector<double> by_anchor_;  // variances relative to it; infinity for those far from it
  std::unordered_map<Cell, std::vector<int>, HashOfCell>
      near_;  // landmarks of a cell and those about it
  std::vector<PlaceSeed<Pose>> seeds_;
  std::size_t guesses_ = 0;
};

}  // namespace

template <class Pose>
std::vector<PlaceSeed<Pose>> place_seeds(const PlaceQuestion<Pose>& question, double density,
                                         std::size_t most) {
  return SeedSearch<Pose>(question, density).run(most);
}

template std::vector<PlaceSeed<SE2>> place_seeds(const PlaceQuestion<SE2>&, double, std::size_t);
template std::vector<PlaceSeed<SE3>> place_seeds(const PlaceQuestion<SE3>&, double, std::size_t);

}  // namespace hybrid
