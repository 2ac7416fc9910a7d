// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/smoother/window.h"
#include "mrpt_plugins/mapping/backend.h"

namespace hybrid {

/// Online smoothing: the cost of an update depends on the variables it affects, and the estimate is
/// complete after each. The graph holds all variables, or a window; variables outside keep their
/// last estimate, or, in a bounded window, follow those that they hang on.
class WindowBackend : public Backend {
 public:
  WindowBackend(const WindowOptions& window, const SmootherOptions& options)
      : window_(window), smoother_(window, options) {}

  std::string mode() const override;
  BackendReport update(const Delta& delta) override;
  BackendReport propose(const Proposal& proposal) override;
  BackendReport finish() override;
  BackendReport settle() override;
  const Values& values() const override;
  const Assignment& assignment() const override;
  const HybridGraph& graph() const override { return smoother_.smoother().graph(); }
  bool keeps_all() const override { return is_full() || is_bounded(); }
  bool holds(Key key) const override { return smoother_.smoother().values().contains(key); }
  void hold(Key key) override { smoother_.hold(key); }
  void release(Key key) override { smoother_.release(key); }
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const override {
    return smoother_.smoother().joint_covariance(keys);
  }
  Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys,
                                   const Eigen::MatrixXd& J) const override {
    return smoother_.smoother().joint_covariance(keys, J);
  }
  std::map<std::string, double> statistics() const override;
  Uncertainty uncertainty(const std::vector<Key>& continuous,
                          const std::vector<DiscreteKey>& discrete) const override;

 private:
  bool is_full() const { return window_.mode == WindowOptions::Mode::kFull; }
  bool is_bounded() const { return window_.mode == WindowOptions::Mode::kBounded; }
  /// Whether the estimate of the graph is that of all variables.
  bool is_whole() const { return is_full() || (is_bounded() && merged_.values.empty()); }
  BackendReport take(const WindowReport& update, const Delta& delta);
  bool affords_chordal_start() const;
  UpdateReport solve_from_chordal_start();
  void merge(const std::vector<Key>& changed, const std::vector<Key>& left,
             const std::vector<Key>& left_discrete);
  BackendReport report_of(const UpdateReport& update) const;
  void add_past(const std::vector<Key>& continuous, const std::vector<DiscreteKey>& discrete,
                Uncertainty& out) const;

  WindowOptions window_;
  WindowSmoother smoother_;
  std::int64_t eliminated_ = 0;           // variables, over all updates
  std::map<std::string, double> starts_;  // objectives of those that the last finish() compared
  Estimate merged_;                       // of the window and the past, once something has left
};

}  // namespace hybrid
