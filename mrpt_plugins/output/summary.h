// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/solvers/certificate.h"
#include "mrpt_plugins/bridge/provenance.h"
#include "mrpt_plugins/evaluation/landmark_metrics.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/plugin_choice.h"
#include "mrpt_plugins/output/mode_writer.h"

namespace HYBRID_API hybrid {

/// Distribution of a time per step.
struct StepStatistics {
  double total_s = 0, mean_ms = 0, p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;
};

/// Statistics of the solver times of `steps`; percentiles interpolate linearly, all zero when
/// empty.
StepStatistics step_statistics(const std::vector<StepRecord>& steps);

/// The same of the time of the plugins.
StepStatistics plugin_statistics(const std::vector<StepRecord>& steps);

/// Comparison with the truth; what is not known stays empty and is left out of the file.
struct TruthSummary {
  std::optional<TrajectoryReport> trajectory;
  std::optional<TrajectoryReport> dead_reckoning;
  std::optional<LandmarkErrors> landmarks;
  std::optional<LandmarkErrors> landmarks_aligned;  ///< after the alignment of the trajectory
  std::optional<double> class_accuracy;             ///< fraction of the matched landmarks
  std::optional<AssociationReport> associations;
  std::optional<double> nees_pose;       ///< mean over poses and degrees of freedom
  std::optional<double> nees_landmark;   ///< the same over landmarks
  std::optional<ModeScore> modes;        ///< of motion
  std::optional<double> loop_precision;  ///< share of the accepted closures that are true
  std::optional<double> loop_recall;     ///< share of the true closures that are accepted
};

/// One of several robots of a replay.
struct RobotSummary {
  std::string name, rawlog;
  std::size_t keyframes = 0;
  std::optional<TruthSummary> truth;  ///< errors of its path
};

/// The content of a replay's summary.json.
struct Summary {
  Provenance provenance;
  std::string status = "ok";
  std::string message;  ///< why the status is not "ok"; left out of the file when empty
  std::string mode;
  std::size_t keyframes = 0;
  std::size_t landmarks = 0;
  double objective = 0;
  double cost = 0;
  double solver_s = 0;
  double total_s = 0;
  StepStatistics steps;
  StepStatistics plugins;
  std::vector<std::string> chosen_plugins;             ///< where the log chose them
  std::map<std::string, ObservationUse> observations;  ///< of the log, by class
  std::map<std::string, double> statistics;            ///< figures of the plugins, by name
  std::map<std::string, std::size_t> dropped;          ///< reason -> number of measurements
  std::vector<std::string> warnings;
  std::vector<CalibrationEstimate> calibration;
  std::map<std::string, std::size_t> modes;  ///< of motion -> number of motions
  bool uses_map = false;                     ///< of a file, in which the log is to be localised
  std::optional<std::size_t> localized_at;   ///< keyframe; none: not found in the map
  std::optional<TruthSummary> truth;
  std::vector<RobotSummary> robots;  ///< where there are several
};

/// The summary as JSON; values that are not finite become null in its text.
nlohmann::ordered_json summary_json(const Summary& summary);

/// What a pose graph came to from one start.
struct StartSummary {
  std::string start;
  double cost = 0;
  int iterations = 0;
};

/// The content of the summary.json of a pose graph.
struct GraphSummary {
  Provenance provenance;
  std::string status = "ok";
  std::string message;  ///< where the status is not ok
  std::string method;
  std::size_t poses = 0;
  std::size_t landmarks = 0;
  double solver_s = 0;
  double total_s = 0;
  int iterations = 0;  ///< linear systems solved
  double objective = 0;
  double cost = 0;
  std::size_t inliers = 0;  ///< loop closures by decision
  std::size_t outliers = 0;
  std::size_t unchecked = 0;              ///< accepted closures that no other measurement checks
  std::size_t hypotheses = 0;             ///< edges with several; left out when there are none
  std::size_t first_hypotheses = 0;       ///< of those, where the first of the file was chosen
  std::string note;                       ///< left out when empty
  std::optional<double> variance_factor;  ///< of the noise of the measurements
  std::vector<MemberSummary> members;
  std::string start;                 ///< where the solver started; left out when empty
  std::vector<StartSummary> starts;  ///< those that were compared; left out when there are none
  std::optional<Certificate> certificate;
  std::optional<StepStatistics> steps;
  std::optional<double> cost_online;  ///< after the last step, before solving to convergence
  std::optional<TruthSummary> truth;
};

nlohmann::ordered_json summary_json(const GraphSummary& summary);

/// The steps as CSV: keyframe, time (s), solver_ms, iterations, flips, relinearized, objective,
/// cost, landmarks, plugin_ms.
std::string steps_csv(const std::vector<StepRecord>& steps);

}  // namespace hybrid
