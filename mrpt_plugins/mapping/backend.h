// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/marginals/posterior.h"
#include "libhybrid/smoother/report.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// What a back-end did with one change of the graph. `rounds` are linear solves.
struct BackendReport : UpdateReport {
  double cost = 0;                    ///< half the weighted squared error afterwards
  std::vector<std::string> warnings;  ///< what the user should know, e.g. no convergence
};

/// Counts the work of one more update; the estimate is that of the later one.
void add_work(BackendReport& into, const BackendReport& from);

/// Uncertainty of an estimate: Laplace covariances (eq. 12), and p(d | Z) of discrete variables
/// with the continuous ones integrated out (see posterior_marginals).
struct Uncertainty {
  std::unordered_map<Key, Eigen::MatrixXd> covariances;
  std::unordered_map<Key, std::vector<double>> probabilities;
  double standard_error = 0;  ///< largest of the probabilities, where some were sampled
};

/// Takes over what is known of discrete variables.
void add_probabilities(AssignmentPosterior&& posterior, Uncertainty& out);

/// The seam between the mapper and inference: whoever can take in one Delta per keyframe.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Name of the mode as in the INI.
  virtual std::string mode() const = 0;

  /// Takes one atomic change in. Throws Error, and stays as it was, if the change is impossible.
  virtual BackendReport update(const Delta& delta) = 0;

  /// Solves to convergence, once no more changes come.
  virtual BackendReport finish() = 0;

  /// Every variable ever added and not removed; one marginalised out keeps its last estimate.
  virtual const Values& values() const = 0;
  virtual const Assignment& assignment() const = 0;

  /// All factors taken in so far and not removed; for variables marginalised out, linear priors.
  virtual const HybridGraph& graph() const = 0;

  /// The continuous variables of the graph in the order of their elimination; empty where the
  /// back-end keeps none.
  virtual std::vector<Key> elimination_order() const { return {}; }

  /// Whether factors may still be removed by their handles: not where the past is marginalised; of
  /// what is bounded by the place, those of variables that the graph holds.
  virtual bool keeps_all() const = 0;

  /// Whether a variable is in the graph and not marginalised out.
  virtual bool holds(Key key) const = 0;

  /// Figures for the summary of a run, by name; empty if there are none.
  virtual std::map<std::string, double> statistics() const { return {}; }

  /// Joint covariance of some variables that the graph holds, in the order given. Throws
  /// SettingsError in a mode that keeps no estimate on the way.
  virtual Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const = 0;

  /// Uncertainty of some variables at the estimate; a variable without it is left out.
  virtual Uncertainty uncertainty(const std::vector<Key>& continuous,
                                  const std::vector<DiscreteKey>& discrete) const = 0;
};

/// Declares the keys of section [solver] and creates the back-end they ask for.
std::unique_ptr<Backend> make_backend(IniSection solver);

}  // namespace hybrid
