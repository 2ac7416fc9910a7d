// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/hypothesis_bank.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace hybrid {
namespace {

constexpr int kMaxSteps = 10;
constexpr double kSmallStep = 1e-4;  // m
constexpr double kSamePlace = 0.3;   // of max_sigma, distance below which places are one
constexpr double kForgotten = 1e-8;  // probability below which a place is given up

/// Sum of the normal equations of the measurements at a point, and the robust cost.
struct Equations {
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
  double cost = 0;
};

/// A measurement that misses costs no more than what it costs to call it an outlier: max-mixture of
/// its Gaussian and of a constant.
Equations equations_at(const Eigen::VectorXd& point,
                       const std::vector<HypothesisBank::Measurement>& measurements,
                       const std::function<const double*(Key)>& pose, double outlier_cost) {
  const Eigen::Index n = point.size();
  Equations out{1e-6 * Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n), 0};
  for (const HypothesisBank::Measurement& measurement : measurements) {
    const ContinuousFactorPtr& factor = measurement.trial;
    const double* const x[2] = {pose(factor->keys()[0]), point.data()};
    Eigen::VectorXd r(factor->rows());
    Eigen::MatrixXd J(factor->rows(), factor->cols());
    const double cost = factor->linearize(x, r.data(), J.data());
    out.cost += std::min(cost, outlier_cost);
    const double weight = cost > outlier_cost ? outlier_cost / cost : 1.0;
    const auto Jp = J.rightCols(n);
    out.information += weight * Jp.transpose() * Jp;
    out.gradient += weight * Jp.transpose() * r;
  }
  return out;
}

void refine_place(HypothesisBank::Place& place,
                  const std::vector<HypothesisBank::Measurement>& measurements,
                  const std::function<const double*(Key)>& pose, double outlier_cost) {
  Equations at = equations_at(place.point, measurements, pose, outlier_cost);
  for (int step = 0; step < kMaxSteps; ++step) {
    Eigen::VectorXd move = -at.information.ldlt().solve(at.gradient);
    bool better = false;
    for (int halving = 0; halving < 6 && !better; ++halving, move *= 0.5) {
      const Equations there = equations_at(place.point + move, measurements, pose, outlier_cost);
      if (there.cost > at.cost) continue;
      better = true;
      place.point += move;
      at = there;
      break;
    }
    if (!better || move.norm() < kSmallStep) break;
  }
  place.covariance = at.information.inverse();
  place.cost = at.cost + 0.5 * std::log(at.information.determinant());
}

}  // namespace

BankOptions read_bank_options(IniSection& section) {
  BankOptions o;
  o.dominance =
      section.get("dominance", o.dominance,
                  "a landmark is placed once its best place has this probability", {0.5, 1.0});
  o.max_sigma = section.get("max_sigma", o.max_sigma,
                            "and is known to so many metres in every direction", kPositive);
  o.min_measurements = section.get("min_measurements", o.min_measurements,
                                   "measurements before a decision", IniRange{1, 1e6});
  o.max_measurements = section.get("max_measurements", o.max_measurements,
                                   "kept of a landmark that has no place yet", IniRange{2, 1e6});
  o.outlier_share =
      section.get("outlier_share", o.outlier_share, "of measurements that are false", {1e-9, 0.5});
  o.drift = section.get("drift", o.drift,
                        "of the robot while a landmark has no place yet, added to the noise [m]",
                        kNonNegative);
  return o;
}

HypothesisBank::HypothesisBank(std::vector<Eigen::VectorXd> candidates) {
  for (Eigen::VectorXd& point : candidates) places_.push_back({std::move(point), {}, 0, 0});
}

void HypothesisBank::add(Measurement measurement, const BankOptions& options) {
  if (measurements_.size() >= static_cast<std::size_t>(options.max_measurements)) {
    measurements_.erase(measurements_.begin());
  }
  measurements_.push_back(std::move(measurement));
}

void HypothesisBank::refine(const std::function<const double*(Key)>& pose,
                            const BankOptions& options) {
  const double outlier_cost = -std::log(options.outlier_share);
  for (Place& place : places_) refine_place(place, measurements_, pose, 3 + outlier_cost);
  std::sort(places_.begin(), places_.end(),
            [](const Place& a, const Place& b) { return a.cost < b.cost; });
  const double same = kSamePlace * options.max_sigma;
  std::vector<Place> distinct;
  double sum = 0;
  for (Place& place : places_) {
    const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Place& p) {
      return (p.point - place.point).norm() < same;
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

std::optional<Eigen::VectorXd> HypothesisBank::decided(const BankOptions& options) const {
  if (measurements_.size() < static_cast<std::size_t>(options.min_measurements) ||
      places_.front().covariance.size() == 0) {
    return std::nullopt;
  }
  const Place& best = places_.front();
  const double worst =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(best.covariance, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .maxCoeff();
  if (best.probability < options.dominance || worst > options.max_sigma * options.max_sigma) {
    return std::nullopt;
  }
  return best.point;
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
