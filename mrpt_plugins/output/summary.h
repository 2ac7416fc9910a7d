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
#include "mrpt_plugins/evaluation/mover_truth.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/health/fix_figures.h"
#include "mrpt_plugins/health/health.h"
#include "mrpt_plugins/input/log_correction.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/plugin_choice.h"
#include "mrpt_plugins/output/mode_writer.h"

namespace HYBRID_API hybrid {

/// Distribution of wall times per step.
struct StepStatistics {
  double total_s = 0, mean_ms = 0, p50_ms = 0, p95_ms = 0, p99_ms = 0, max_ms = 0;
};

/// Statistics of the solver times of `steps`. Percentiles interpolate linearly; all are zero
/// without steps.
StepStatistics step_statistics(const std::vector<StepRecord>& steps);

/// Statistics of the times of the plugins.
StepStatistics plugin_statistics(const std::vector<StepRecord>& steps);

/// Comparison with the truth. Unknown fields stay empty and are left out of the file.
struct TruthSummary {
  std::optional<TrajectoryReport> trajectory;
  std::optional<TrajectoryReport> dead_reckoning;
  std::optional<LandmarkErrors> landmarks;
  std::optional<LandmarkErrors> landmarks_aligned;  ///< after the alignment of the trajectory
  std::optional<double> class_accuracy;             ///< fraction of the matched landmarks
  std::optional<AssociationReport> associations;
  std::optional<MoverReport> movers;     ///< in the frame of the landmarks once aligned
  std::optional<double> nees_pose;       ///< mean over poses and degrees of freedom
  std::optional<double> nees_landmark;   ///< the same over landmarks
  std::optional<ModeScore> modes;        ///< of motion
  std::optional<FixScore> fixes;         ///< of satellite receivers
  std::optional<double> loop_precision;  ///< share of the accepted closures that are true
  std::optional<double> loop_recall;     ///< share of the true closures that are accepted
};

/// One of several robots of a replay.
struct RobotSummary {
  std::string name, rawlog;
  std::size_t keyframes = 0;
  std::optional<TruthSummary> truth;        ///< errors of its path
  std::optional<std::size_t> localized_at;  ///< its keyframe, where there is a map; else unused
};

/// One of several maps that were made of the same logs.
struct DrawSummary {
  std::vector<std::string> settings;    ///< section.key=value, beyond those of the request
  std::vector<double> agreement;        ///< over time, of detections and of scans; NaN: not judged
  std::optional<HealthVerdict> health;  ///< the worst of all; none: the map was given up
  double work = 0;                      ///< relative to that of the first
  bool is_taken = false;
};

/// The content of a replay's summary.json.
struct Summary {
  Provenance provenance;
  std::string status = "ok";
  std::string message;  ///< why the status is not "ok"; left out of the file when empty
  std::string mode;
  std::size_t keyframes = 0;
  std::size_t landmarks = 0;
  std::size_t movers = 0;
  double path_m = 0;  ///< length of the path, of all robots
  double objective = 0;
  double cost = 0;
  double solver_s = 0;
  double total_s = 0;
  StepStatistics steps;
  StepStatistics plugins;
  std::vector<std::string> chosen_plugins;             ///< plugins chosen by the log
  std::map<std::string, ObservationUse> observations;  ///< of the log, by class
  std::map<std::string, double> statistics;            ///< figures of the plugins, by name
  std::map<std::string, std::size_t> dropped;          ///< reason -> number of measurements
  std::vector<std::string> warnings;
  Health health;                   ///< what the run says about itself
  std::vector<DrawSummary> draws;  ///< where several maps were made, in order
  std::vector<CalibrationEstimate> calibration;
  std::vector<NoiseRecord> noise;            ///< stated, measured and used
  std::vector<AlignmentRecord> alignment;    ///< of the sensors: sign, mounting, clock
  std::map<std::string, std::size_t> modes;  ///< mode of motion -> number of motions
  FixFigures fixes;                          ///< left out of the file where there are none
  bool uses_map = false;                     ///< the log is localised in a given map
  std::optional<std::size_t> localized_at;   ///< keyframe; none: not localised; of one robot only
  std::optional<TruthSummary> truth;
  std::vector<RobotSummary> robots;  ///< where there are several
};

nlohmann::ordered_json to_json(const std::vector<DrawSummary>& draws);

/// The summary as JSON; values that are not finite become null in its text.
nlohmann::ordered_json summary_json(const Summary& summary);

/// The solution of a pose graph from one start.
struct StartSummary {
  std::string start;
  double cost = 0;
  int iterations = 0;
};

/// The content of the summary.json of a pose graph.
struct GraphSummary {
  Provenance provenance;
  std::string status = "ok";
  std::string message;  ///< set unless the status is ok
  std::string method;
  std::size_t poses = 0;
  std::size_t landmarks = 0;
  double solver_s = 0;
  double total_s = 0;
  int iterations = 0;  ///< linear systems solved
  double objective = 0;
  double cost = 0;
  std::size_t inliers = 0;  ///< accepted loop closures; `outliers`: rejected ones
  std::size_t outliers = 0;
  std::size_t unchecked = 0;         ///< accepted closures that no other measurement checks
  std::size_t hypotheses = 0;        ///< edges with several hypotheses; left out if there are none
  std::size_t first_hypotheses = 0;  ///< of those, with the first hypothesis of the file chosen
  std::string note;                  ///< left out when empty
  std::optional<double> variance_factor;  ///< of the measurements
  Health health;                          ///< what the run says about itself
  std::vector<NoiseRecord> noise;         ///< of the kinds of measurements, factors of the stated
  std::vector<MemberSummary> members;
  std::string start;                 ///< initial values of the solver; left out when empty
  std::vector<StartSummary> starts;  ///< starts compared; left out if there are none
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
