// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/initialization/gaussian_sum_initializer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

constexpr int kMaxSteps = 30;
constexpr double kSmallStep = 1e-5;  // m
constexpr double kSamePlace = 0.3;   // of max_sigma: nearer than this, places are one
constexpr double kForgotten = 1e-8;  // probability below which a place is given up
constexpr double kPriorInformation = 1 / (kAnywhere * kAnywhere);

/// Sum of the normal equations of the measurements at a point, and the cost.
struct Equations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double cost = 0;
  double explained = 0;
};

/// -log ((1 - share) N(z) + share u) of one measurement, and the probability that it is right.
struct Likelihood {
  double cost;
  double right;
};

Likelihood likelihood(double gaussian_cost, const GaussianSumInitializer::Measurement& m,
                      double outlier_share) {
  const double right = gaussian_cost + m.trial->log_normalizer() - std::log1p(-outlier_share);
  const double wrong = -std::log(outlier_share * m.outlier_density);
  const double difference = right - wrong;
  if (!(difference < 700.0)) return {wrong, 0.0};
  return {std::min(right, wrong) - std::log1p(std::exp(-std::abs(difference))),
          1.0 / (1.0 + std::exp(difference))};
}

Equations equations_at(const Eigen::VectorXd& point,
                       const std::vector<GaussianSumInitializer::Measurement>& measurements,
                       const std::function<const double*(Key)>& pose, double outlier_share) {
  const Eigen::Index n = point.size();
  Equations out{kPriorInformation * Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n)};
  for (const GaussianSumInitializer::Measurement& measurement : measurements) {
    const ContinuousFactor& factor = *measurement.trial;
    const double* const x[2] = {pose(factor.keys()[0]), point.data()};
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd J(factor.rows(), factor.cols());
    const double cost = factor.linearize(x, r.data(), J.data());
    const Likelihood l = likelihood(cost, measurement, outlier_share);
    out.cost += l.cost;
    out.explained += l.right;
    const auto Jp = J.rightCols(n);
    out.information += l.right * Jp.transpose() * Jp;
    out.gradient += l.right * Jp.transpose() * r;
  }
  return out;
}

/// Levenberg-Marquardt on the likelihood of the measurements.
void refine_place(GaussianSumInitializer::Place& place,
                  const std::vector<GaussianSumInitializer::Measurement>& measurements,
                  const std::function<const double*(Key)>& pose, double outlier_share) {
  Equations at = equations_at(place.point, measurements, pose, outlier_share);
  double damping = 1e-3;
  for (int step = 0; step < kMaxSteps && damping < 1e6; ++step) {
    Eigen::MatrixXd damped = at.information;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::VectorXd move = -damped.ldlt().solve(at.gradient);
    const Equations there = equations_at(place.point + move, measurements, pose, outlier_share);
    if (!(there.cost <= at.cost)) {
      damping *= 8.0;
      continue;
    }
    damping = std::max(0.2 * damping, 1e-9);
    place.point += move;
    at = there;
    if (move.norm() < kSmallStep) break;
  }
  place.covariance = at.information.inverse();
  place.cost = at.cost + 0.5 * std::log(at.information.determinant());
  place.explained = at.explained;
  std::vector<double> distances;
  for (const GaussianSumInitializer::Measurement& measurement : measurements) {
    const Eigen::Map<const Eigen::VectorXd> seen_from(pose(measurement.trial->keys()[0]),
                                                      place.point.size());
    distances.push_back((place.point - seen_from).norm());
  }
  place.distance = median(std::move(distances));
}

}  // namespace

double measurement_cost(const std::vector<GaussianSumInitializer::Measurement>& measurements,
                        const Eigen::VectorXd& point, const std::function<const double*(Key)>& pose,
                        double outlier_share) {
  return equations_at(point, measurements, pose, outlier_share).cost;
}

GaussianSumInitializer::GaussianSumInitializer(std::vector<Eigen::VectorXd> candidates) {
  add_candidates(std::move(candidates));
}

bool GaussianSumInitializer::needs_candidates() const {
  return measurements_.size() > 1 &&
         places_.front().explained < 0.5 * static_cast<double>(measurements_.size());
}

void GaussianSumInitializer::add_candidates(std::vector<Eigen::VectorXd> candidates) {
  for (Eigen::VectorXd& point : candidates) places_.push_back({std::move(point), {}, 0, 0, 0});
}

void GaussianSumInitializer::add(Measurement measurement, const BankOptions& options) {
  if (measurements_.size() >= static_cast<std::size_t>(options.max_measurements)) {
    measurements_.erase(measurements_.begin());
  }
  measurements_.push_back(std::move(measurement));
}

void GaussianSumInitializer::refine(const std::function<const double*(Key)>& pose,
                                    const BankOptions& options) {
  for (Place& place : places_) refine_place(place, measurements_, pose, options.outlier_share);
  std::sort(places_.begin(), places_.end(),
            [](const Place& a, const Place& b) { return a.cost < b.cost; });
  std::vector<Place> distinct;
  double sum = 0;
  for (Place& place : places_) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Place& p) {
      return (p.point - place.point).norm() < kSamePlace * options.max_sigma * p.distance;
    });
    if (known) continue;
    place.probability = std::exp(places_.front().cost - place.cost);
    if (place.probability < kForgotten) continue;
    sum += place.probability;
    distinct.push_back(place);
  }
  for (Place& place : distinct) place.probability /= sum;
  places_ = std::move(distinct);
}

const char* GaussianSumInitializer::undecided(const BankOptions& options) const {
  if (measurements_.size() < static_cast<std::size_t>(options.min_measurements) ||
      places_.front().covariance.size() == 0) {
    return "it was seen too few times";
  }
  const Place& best = places_.front();
  const double worst =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(best.covariance, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff();
  if (best.probability < options.dominance) return "it may be in several places";
  const double most = options.max_sigma * best.distance;
  return worst > most * most ? "its place is not known well enough" : nullptr;
}

std::optional<Eigen::VectorXd> GaussianSumInitializer::decided(const BankOptions& options) const {
  if (undecided(options) != nullptr) return std::nullopt;
  return places_.front().point;
}

std::vector<Eigen::VectorXd> ring_places(const Eigen::VectorXd& center, double radius, int count) {
  std::vector<Eigen::VectorXd> places;
  const double golden = M_PI * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    Eigen::VectorXd direction(center.size());
    if (center.size() == 2) {
      const double angle = 2 * M_PI * i / count;
      direction << std::cos(angle), std::sin(angle);
    } else {  // a spiral over the sphere
      const double z = 1 - (2.0 * i + 1) / count, flat = std::sqrt(1 - z * z);
      direction << flat * std::cos(golden * i), flat * std::sin(golden * i), z;
    }
    places.push_back(center + radius * direction);
  }
  return places;
}

std::vector<Eigen::VectorXd> ray_places(const Eigen::VectorXd& origin,
                                        const Eigen::VectorXd& direction, double least,
                                        double greatest, int count) {
  std::vector<Eigen::VectorXd> places;
  for (int i = 0; i < count; ++i) {
    const double depth = least * std::pow(greatest / least, i / std::max(1.0, count - 1.0));
    places.push_back(origin + depth * direction);
  }
  return places;
}

}  // namespace hybrid
