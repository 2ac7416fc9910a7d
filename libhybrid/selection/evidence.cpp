// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/factors/surface_match.h"

namespace hybrid {
namespace {

constexpr double kGateProbability = 0.9999;
constexpr int kMostRows = 6;              // with tabulated quantiles
constexpr double kSmallestRadius = 1e-3;  // of a robot that stands still [m]
/// Closures as well as which it is known that the noise is as stated: the factor of fewer is drawn
/// to one.
constexpr double kStatedCount = 10.0;
constexpr double kSmallestVarianceFactor = 1e-6;
constexpr double kLargestVarianceFactor = 4.0;

/// How an innovation fits a covariance.
struct Fit {
  double chi_square = 0.0;
  double log_det = 0.0;  ///< of the covariance
};

/// Nothing if the covariance is not positive definite.
std::optional<Fit> fit_of(const Eigen::VectorXd& b, const Eigen::MatrixXd& S) {
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  if (llt.info() != Eigen::Success) return std::nullopt;
  return Fit{llt.matrixL().solve(b).squaredNorm(),
             2.0 * Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum()};
}

}  // namespace

double log_volume(const ContinuousFactor& factor, double radius) {
  const double area = M_PI * radius * radius;
  const double ball = 4.0 / 3.0 * area * radius;
  const bool planar = std::any_of(factor.types().begin(), factor.types().end(), [](auto type) {
    return type.kind == VariableKind::kSE2 || (type.kind == VariableKind::kVector && type.dim == 2);
  });
  switch (factor.rows()) {
    case 1:
      return std::log(2.0 * radius);
    case 2:
      return std::log(area);
    case 3:
      return planar ? std::log(area * 2.0 * M_PI) : std::log(ball);
    default:
      return std::log(ball * 8.0 * M_PI * M_PI);
  }
}

/// The log density of a Student t of that many dimensions, of a covariance of that log determinant,
/// relative to the Gaussian's own normaliser (2 pi)^(d/2).
double EvidenceModel::log_density(double chi_square, double log_det, int d) const {
  return std::lgamma(0.5 * (degrees + d)) - std::lgamma(0.5 * degrees) -
         0.5 * d * std::log(0.5 * degrees) -
         0.5 * (degrees + d) * std::log1p(chi_square / (degrees * variance_factor)) -
         0.5 * (log_det + d * std::log(variance_factor));
}

double EvidenceModel::density_ratio(double chi_square, double log_det,
                                    const ContinuousFactor& factor) const {
  const int d = factor.rows();
  if (!(chi_square <= limit(d))) return -std::numeric_limits<double>::infinity();
  // `log_normalizer` holds the Gaussian's normaliser.
  return log_density(chi_square, log_det, d) - factor.log_normalizer() + log_volume(factor, radius);
}

double EvidenceModel::log_ratio(const Eigen::VectorXd& b, const Eigen::MatrixXd& S,
                                const ContinuousFactor& factor) const {
  const std::optional<Fit> fit = fit_of(b, S);
  if (!fit) return -std::numeric_limits<double>::infinity();
  const double to_any = density_ratio(fit->chi_square, fit->log_det, factor);
  const auto* place = dynamic_cast<const MistakablePlace*>(&factor);
  if (place == nullptr) return to_any;
  const std::optional<Fit> false_fit = fit_of(b, S + place->elsewhere() / variance_factor);
  if (!false_fit) return to_any;
  const int d = factor.rows();
  return std::min(to_any, log_density(fit->chi_square, fit->log_det, d) -
                              log_density(false_fit->chi_square, false_fit->log_det, d));
}

double EvidenceModel::largest_log_ratio(const Eigen::VectorXd& b, const Eigen::MatrixXd& S,
                                        const ContinuousFactor& factor) const {
  const double chi_square = S.llt().matrixL().solve(b).squaredNorm();
  return density_ratio(chi_square, 0.0, factor);
}

double evidence_needed(std::size_t not_admitted, const ClosureSelectionOptions& options) {
  return std::log1p(static_cast<double>(not_admitted)) + options.margin;
}

double against_alternatives(std::size_t closure, const std::vector<double>& evidence,
                            const Alternatives& alternatives, double log_odds) {
  double most = 0.0;  // of the logarithms in the sum, that of a false closure
  for (const std::size_t other : alternatives.set_of(closure)) {
    if (other != closure) most = std::max(most, evidence[other] + log_odds);
  }
  double sum = std::exp(-most);
  for (const std::size_t other : alternatives.set_of(closure)) {
    if (other != closure) sum += std::exp(evidence[other] + log_odds - most);
  }
  return evidence[closure] - most - std::log(sum);
}

void write_evidence(const std::vector<double>& alone, const std::vector<double>& redundancy,
                    const Alternatives& alternatives, const ClosureSelectionOptions& options,
                    std::vector<ClosureDecision>& decisions) {
  const auto admitted = static_cast<std::size_t>(
      std::count_if(decisions.begin(), decisions.end(),
                    [](const ClosureDecision& decision) { return decision.accepted(); }));
  const double needed = evidence_needed(decisions.size() - admitted, options);
  const double share = (1.0 + double(admitted)) / (2.0 + double(decisions.size()));
  const double log_odds = std::log(share / (1.0 - share));
  for (std::size_t k = 0; k < decisions.size(); ++k) {
    ClosureDecision& decision = decisions[k];
    const double evidence = against_alternatives(k, alone, alternatives, log_odds);
    decision.redundancy = redundancy[k];
    decision.checkable = redundancy[k] >= options.min_redundancy;
    decision.inlier_probability = 1.0 / (1.0 + std::exp(-evidence - log_odds));
    decision.evidence = evidence;
    decision.margin = evidence - needed;
  }
}

double gate_quantile(int degrees) {
  static const std::array<double, kMostRows + 1> table = [] {
    std::array<double, kMostRows + 1> quantiles{};
    for (int d = 1; d <= kMostRows; ++d) quantiles[d] = chi_square_quantile(kGateProbability, d);
    return quantiles;
  }();
  return degrees <= kMostRows ? table[degrees] : chi_square_quantile(kGateProbability, degrees);
}

double EvidenceModel::limit(int d) const {
  return gate * gate_quantile(d) * std::max(1.0, variance_factor);
}

double map_radius(const Values& values) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> points;
  for (int slot = 0; slot < values.slot_count(); ++slot) {
    if (!values.occupied(slot)) continue;
    const VariableType type = values.type(slot);
    const bool in_space = type.kind == VariableKind::kSE3 || type.dim == 3;
    const double* x = values.data(slot);
    const bool on_a_line = type.size < 2 || type.kind == VariableKind::kSO3;
    if (on_a_line) continue;
    points.emplace_back(x[0], x[1], in_space && type.kind != VariableKind::kSE2 ? x[2] : 0.0);
    centre += points.back();
  }
  if (points.empty()) return kSmallestRadius;
  centre /= static_cast<double>(points.size());
  double sum = 0.0;
  for (const Eigen::Vector3d& point : points) sum += (point - centre).squaredNorm();
  return std::max(kSmallestRadius, 2.0 * std::sqrt(sum / static_cast<double>(points.size())));
}

double variance_factor(const std::vector<double>& chi_squares, const std::vector<int>& degrees,
                       double probability) {
  if (chi_squares.empty()) return 1.0;
  std::vector<double> ratios;
  std::map<int, double> quantiles;
  for (std::size_t k = 0; k < chi_squares.size(); ++k) {
    double& quantile = quantiles[degrees[k]];
    if (quantile == 0.0) quantile = chi_square_quantile(probability, degrees[k]);
    ratios.push_back(chi_squares[k] / quantile);
  }
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(probability * ratios.size());
  std::nth_element(ratios.begin(), middle, ratios.end());
  const double count = static_cast<double>(ratios.size());
  const double factor = std::max(*middle, kSmallestVarianceFactor);
  return std::min(kLargestVarianceFactor,
                  std::exp(count / (count + kStatedCount) * std::log(factor)));
}

}  // namespace hybrid
