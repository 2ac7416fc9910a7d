// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/marginals/posterior.h"
#include "libhybrid/smoother/proposal.h"
#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// Result of a back-end update. `rounds` counts linear solves.
struct BackendReport : UpdateReport {
  double cost = 0;                    ///< half the weighted squared error after the update
  std::vector<std::string> warnings;  ///< messages for the user, e.g. no convergence
};

/// Adds the work of a later update, and takes over its estimate's objective and cost.
inline void add_work(BackendReport& into, const BackendReport& from) {
  into.add(from);
  if (from.cost != 0 || into.cost == 0) into.cost = from.cost;
  for (Flip flip : from.flipped) {
    flip.half_step += into.objectives.size();
    into.flipped.push_back(flip);
  }
  into.objectives.insert(into.objectives.end(), from.objectives.begin(), from.objectives.end());
  into.warnings.insert(into.warnings.end(), from.warnings.begin(), from.warnings.end());
}

/// Uncertainty of an estimate: Laplace covariances (eq. 12), and p(d | Z) of discrete variables
/// with the continuous ones integrated out (see posterior_marginals).
struct Uncertainty {
  std::unordered_map<Key, Eigen::MatrixXd> covariances;
  std::unordered_map<Key, std::vector<double>> probabilities;
  double standard_error = 0;  ///< largest one of the probabilities, if some were sampled
};

/// Adds the marginal probabilities of discrete variables.
inline void add_probabilities(AssignmentPosterior&& posterior, Uncertainty& out) {
  for (auto& [key, variable] : posterior.variables) {
    for (double error : variable.standard_error) {
      out.standard_error = std::max(out.standard_error, error);
    }
    out.probabilities[key] = std::move(variable.p);
  }
}

/// Interface of the mapper to inference: one atomic Delta per update.
class Backend {
 public:
  virtual ~Backend() = default;

  /// Name of the mode in the INI.
  virtual std::string mode() const = 0;

  /// Applies one atomic change. Throws Error, and stays unchanged, if the change is impossible.
  virtual BackendReport update(const Delta& delta) = 0;
  /// Makes a change on trial: solves, and keeps it if the objective rises by no more than the
  /// proposal allows. Else the map is as it was before, and the report says `kTurnedDown`. Nothing
  /// leaves the graph before the next update. Throws as update() does.
  virtual BackendReport propose(const Proposal& proposal) = 0;

  /// Solves to convergence, after the last change.
  virtual BackendReport finish() = 0;
  /// Solves as far as the last change needs, where one update may not come so far.
  virtual BackendReport settle() { return finish(); }

  /// All variables ever added and not removed; a marginalised one keeps its last estimate, until
  /// finish() moves it along where the back-end can tell.
  virtual const Values& values() const = 0;
  virtual const Assignment& assignment() const = 0;

  /// All factors added so far and not removed; marginalised variables leave linear priors.
  virtual const HybridGraph& graph() const = 0;

  /// Whether factors may still be removed by their handles: not where the past is marginalised; of
  /// what is bounded by the place, those of variables that the graph holds.
  virtual bool keeps_all() const = 0;

  /// Whether a variable is in the graph and not marginalised.
  virtual bool holds(Key key) const = 0;

  /// Keeps a variable in the graph although its time comes, until `release`.
  virtual void hold(Key /*key*/) {}
  virtual void release(Key /*key*/) {}

  /// Figures for the summary of a run, by name; empty if there are none.
  virtual std::map<std::string, double> statistics() const { return {}; }

  /// Joint covariance of some variables that the graph holds, in the order given. Throws
  /// SettingsError in a mode that keeps no estimate on the way.
  virtual Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys) const = 0;
  /// Covariance of J x with x their tangents stacked.
  virtual Eigen::MatrixXd joint_covariance(const std::vector<Key>& keys,
                                           const Eigen::MatrixXd& J) const {
    return J * joint_covariance(keys) * J.transpose();
  }

  /// Uncertainty of variables at the estimate; variables with unknown uncertainty are left out.
  virtual Uncertainty uncertainty(const std::vector<Key>& continuous,
                                  const std::vector<DiscreteKey>& discrete) const = 0;
};

/// Declares the keys of section [solver] and creates the back-end.
std::unique_ptr<Backend> make_backend(IniSection solver);

}  // namespace hybrid
