// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/switching/learn.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/discrete/inference.h"

namespace hybrid {
namespace {

/// Weighted sums of one mode from which its motion is estimated.
struct Moments {
  double weight = 0.0;
  Eigen::MatrixXd xx, yx, yy;  // of regressors x and values y

  Moments(Eigen::Index d, Eigen::Index k)
      : xx(Eigen::MatrixXd::Zero(k, k)),
        yx(Eigen::MatrixXd::Zero(d, k)),
        yy(Eigen::MatrixXd::Zero(d, d)) {}

  void add(double w, const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
    weight += w;
    xx += w * x * x.transpose();
    yx += w * y * x.transpose();
    yy += w * y * y.transpose();
  }

  /// Most probable B and Q under the prior; `q` is the variance of its one observation.
  Autoregression motion(double ridge, double q) const {
    const auto k = xx.rows(), d = yy.rows();
    const Eigen::MatrixXd A = xx + ridge * Eigen::MatrixXd::Identity(k, k);
    Autoregression out;
    out.coefficients = A.ldlt().solve(yx.transpose()).transpose();
    const Eigen::MatrixXd S = yy - out.coefficients * yx.transpose();
    out.covariance =
        (0.5 * (S + S.transpose()) + q * Eigen::MatrixXd::Identity(d, d)) / (weight + 1.0);
    return out;
  }
};

double log_prior(const Autoregression& motion, double ridge, double q) {
  const auto d = motion.covariance.rows();
  const Eigen::LLT<Eigen::MatrixXd> llt(motion.covariance);
  const Eigen::MatrixXd M = ridge * motion.coefficients * motion.coefficients.transpose() +
                            q * Eigen::MatrixXd::Identity(d, d);
  const double log_root = Eigen::MatrixXd(llt.matrixL()).diagonal().array().log().sum();
  return -log_root - 0.5 * llt.solve(M).trace();
}

/// Mean variance of the values of all stretches, the unit of the prior of Q.
double variance(const std::vector<Series>& stretches) {
  double n = 0.0;
  Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(stretches.front().rows()), squares = sum;
  for (const Series& s : stretches) {
    n += static_cast<double>(s.cols());
    sum += s.rowwise().sum().array();
    squares += s.array().square().rowwise().sum();
  }
  const double mean = (squares / n - (sum / n).square()).mean();
  return mean > 0.0 ? mean : 1.0;
}

void check_stretches(const std::vector<Series>& stretches) {
  if (stretches.empty()) throw Error("nothing to learn a switching model from");
  for (const Series& s : stretches) {
    if (s.rows() != stretches.front().rows() || s.rows() == 0 || s.cols() == 0) {
      throw Error(
          "the stretches to learn from must have instants, and all the same number of "
          "values per instant");
    }
    if (!s.allFinite()) throw Error("a series to learn from holds a value that is not finite");
  }
}

/// The sufficient statistics of all parameters, as sums over instants.
class Statistics {
 public:
  Statistics(int modes, int order, Eigen::Index d)
      : order_(order), counts_(modes), moments_(modes, Moments(d, 1 + d * order)) {}

  void start(const Eigen::VectorXd& p) { counts_.starts += p; }
  void change(const Eigen::MatrixXd& p) { counts_.changes += p; }
  /// `p` is the probability of each mode at instant t.
  void instant(const Series& series, int t, const Eigen::VectorXd& p) {
    if (t < order_) return;
    const Eigen::VectorXd x = regressors(series, t, order_);
    for (int m = 0; m < p.size(); ++m) {
      if (p[m] > 0.0) moments_[m].add(p[m], x, series.col(t));
    }
  }

  double weight(int mode) const { return moments_[mode].weight; }

  SwitchingModel model(const LearnOptions& options, double q) const {
    SwitchingModel out;
    out.order = order_;
    out.chain = counts_.chain(options.change_prior);
    for (const Moments& m : moments_) out.motions.push_back(m.motion(options.ridge, q));
    return out;
  }

 private:
  int order_;
  MarkovCounts counts_;
  std::vector<Moments> moments_;
};

/// Adds the expected sums of one stretch; returns its log likelihood.
double expect(const SwitchingModel& model, const Series& series, Statistics& statistics) {
  const std::vector<Table> tables = switching_tables(model, series);
  std::vector<const Table*> factors;
  for (const Table& table : tables) factors.push_back(&table);
  const TableMarginals marginals = table_marginals(factors);
  const int n = static_cast<int>(series.cols()), modes = model.modes();
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::VectorXd p = Eigen::Map<const Eigen::VectorXd>(marginals.tables[0].data(), modes);
  statistics.start(p);
  for (int t = 0; t < n; ++t) {
    if (t > 0) {
      const Eigen::Map<const RowMajor> pair(marginals.tables[t].data(), modes, modes);
      statistics.change(pair);
      p = pair.colwise().sum();
    }
    statistics.instant(series, t, p);
  }
  return marginals.log_partition;
}

double log_prior(const SwitchingModel& model, const LearnOptions& options, double q) {
  double sum = options.change_prior * (model.chain.initial.array().log().sum() +
                                       model.chain.transition.array().log().sum());
  for (const Autoregression& motion : model.motions) sum += log_prior(motion, options.ridge, q);
  return sum;
}

}  // namespace

SwitchingModel learn_from_labels(const std::vector<LabelledSeries>& stretches, int modes,
                                 const LearnOptions& options) {
  std::vector<Series> all;
  for (const LabelledSeries& s : stretches) all.push_back(s.series);
  check_stretches(all);
  Statistics statistics(modes, options.order, all.front().rows());
  for (const LabelledSeries& s : stretches) {
    if (static_cast<Eigen::Index>(s.modes.size()) != s.series.cols()) {
      throw Error("a stretch of " + std::to_string(s.series.cols()) + " instants has " +
                  std::to_string(s.modes.size()) + " labels");
    }
    Eigen::VectorXd before;
    for (std::size_t t = 0; t < s.modes.size(); ++t) {
      if (s.modes[t] < 0 || s.modes[t] >= modes) {
        throw Error("label " + std::to_string(s.modes[t]) + " of instant " + std::to_string(t) +
                    " is not one of 0 .. " + std::to_string(modes - 1));
      }
      const Eigen::VectorXd p = Eigen::VectorXd::Unit(modes, s.modes[t]);
      if (t == 0) statistics.start(p);
      if (t > 0) statistics.change(before * p.transpose());
      statistics.instant(s.series, static_cast<int>(t), p);
      before = p;
    }
  }
  for (int m = 0; m < modes; ++m) {
    if (statistics.weight(m) == 0.0) {
      throw Error("no instant to learn from is labelled " + std::to_string(m));
    }
  }
  return statistics.model(options, options.least_variance * variance(all));
}

EmResult learn_without_labels(const std::vector<Series>& stretches, const SwitchingModel& guess,
                              const LearnOptions& options) {
  check_stretches(stretches);
  const double q = options.least_variance * variance(stretches);
  EmResult result{guess, {}, false};
  for (int round = 0; round <= options.max_rounds; ++round) {
    Statistics statistics(guess.modes(), guess.order, stretches.front().rows());
    double posterior = log_prior(result.model, options, q);
    for (const Series& s : stretches) posterior += expect(result.model, s, statistics);
    result.log_posteriors.push_back(posterior);
    if (round > 0) {
      const double gain = posterior - result.log_posteriors[round - 1];
      result.converged = gain <= options.relative_gain * std::max(1.0, std::abs(posterior));
    }
    if (result.converged || round == options.max_rounds) break;
    result.model = statistics.model(options, q);
  }
  return result;
}

SwitchingModel guess_by_level(const std::vector<Series>& stretches, int modes, int half_window,
                              const LearnOptions& options) {
  check_stretches(stretches);
  if (modes < 1) throw Error("a switching model needs at least one mode");
  std::vector<std::vector<double>> levels;
  std::vector<double> sorted;
  for (const Series& s : stretches) {
    levels.emplace_back();
    for (int t = 0; t < s.cols(); ++t) {
      const int first = std::max(0, t - half_window);
      const int last = std::min(static_cast<int>(s.cols()) - 1, t + half_window);
      levels.back().push_back(s.row(0).segment(first, last - first + 1).mean());
    }
    sorted.insert(sorted.end(), levels.back().begin(), levels.back().end());
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<LabelledSeries> labelled;
  for (std::size_t i = 0; i < stretches.size(); ++i) {
    labelled.push_back({stretches[i], {}});
    for (double level : levels[i]) {
      int mode = 0;
      while (mode + 1 < modes && level >= sorted[sorted.size() * (mode + 1) / modes]) ++mode;
      labelled.back().modes.push_back(mode);
    }
  }
  return learn_from_labels(labelled, modes, options);
}

}  // namespace hybrid
