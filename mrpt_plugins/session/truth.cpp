// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/evaluation/ground_truth.h"
#include "mrpt_plugins/evaluation/landmark_metrics.h"
#include "mrpt_plugins/evaluation/mover_truth.h"
#include "mrpt_plugins/evaluation/same_motion.h"

namespace hybrid {
namespace {

constexpr std::size_t kNoRow = ~std::size_t{0};  // of the log: a pose of another robot
constexpr double kMaxTimeDifference = 0.05;      // s, between a pose and its truth in a TUM file
constexpr std::size_t kFewestShare = 10;         // of so many keyframes, one has a true pose

/// Whether the odometry tells of no motion at all, as where a log has none.
bool stands_still(const Trajectory& dead_reckoning) {
  return std::all_of(dead_reckoning.begin(), dead_reckoning.end(), [&](const TimedPose& pose) {
    return pose.pose == dead_reckoning.front().pose;
  });
}

}  // namespace

Truth::Truth(const std::string& path_file, const std::string& map_file,
             const Eigen::Vector3d& point)
    : path_file_(path_file), map_file_(map_file) {
  if (!path_file.empty()) {
    const auto extension = std::filesystem::path(path_file).extension();
    has_times_ = extension == ".tum" || extension == ".xyz";
    if (extension == ".xyz") {
      truth_.path = read_positions(path_file);
      content_ = TruthContent::kPositions;
      T_robot_point_ = {point.x(), point.y(), point.z(), 0, 0, 0};
    } else if (has_times_) {
      truth_.path = read_tum(path_file);
      real_part_first_ = seems_real_part_first(truth_.path);
    } else {
      may_end_early_ = is_numbered_path(path_file);
      for (const auto& pose :
           may_end_early_ ? read_numbered_path(path_file) : read_true_path(path_file)) {
        truth_.path.push_back({static_cast<double>(truth_.path.size()), pose});
      }
    }
  }
  if (map_file.empty()) return;
  for (LandmarkTruth& row : read_true_landmarks(map_file)) {
    truth_.landmarks.push_back({row.id, row.position, std::nullopt});
    landmark_classes_.push_back(std::move(row.class_name));
  }
}

void Truth::read_movers(const std::string& file) {
  truth_.movers = read_true_movers(file);
}

void Truth::label(std::vector<AssociationDecision>& decisions,
                  const std::vector<std::size_t>& log_rows) const {
  for (AssociationDecision& decision : decisions) {
    if (decision.true_id || decision.pose >= log_rows.size()) continue;
    const auto it = associations_.find({log_rows[decision.pose], decision.measurement});
    if (it != associations_.end()) decision.true_id = it->second;
  }
}

std::optional<mrpt::poses::CPose3D> Truth::origin(const MapResult& result,
                                                  const std::vector<std::size_t>& log_rows) const {
  if (truth_.path.empty() || result.trajectory.empty()) return std::nullopt;
  if (frame_ && result.datum) return origin_by_datum(result);
  const mrpt::poses::CPose3D origin = origin_of_map(result.trajectory, log_rows);
  const bool begins_elsewhere = result.in_known_map || result.datum;
  if (!begins_elsewhere || content_ != TruthContent::kPoses) return origin;
  return origin + (mrpt::poses::CPose3D() - result.trajectory.front().pose);
}

/// The origin of a map that lies on earth; a planar one at the height of the first true pose.
mrpt::poses::CPose3D Truth::origin_by_datum(const MapResult& result) const {
  const Eigen::Isometry3d T_truth_datum = LocalFrame(result.datum->origin).pose_in(*frame_);
  mrpt::poses::CPose3D origin = to_mrpt(T_truth_datum * result.datum->T_datum_map);
  if (!result.is_3d) {
    origin = {origin.x(), origin.y(), truth_.path.front().pose.z(), origin.yaw(), 0, 0};
  }
  return origin;
}

void Truth::move(const std::optional<mrpt::poses::CPose3D>& origin,
                 const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < landmark_classes_.size() && !names.empty(); ++i) {
    if (landmark_classes_[i].empty()) continue;
    const auto it = std::find(names.begin(), names.end(), landmark_classes_[i]);
    if (it == names.end()) {
      throw Error(fmt::format("{}: landmark {} is of class '{}', which the log does not know",
                              map_file_, truth_.landmarks[i].id, landmark_classes_[i]));
    }
    truth_.landmarks[i].class_index = static_cast<int>(it - names.begin());
  }
  if (!origin) return;
  for (TimedPose& pose : truth_.path) pose.pose = pose.pose - *origin;
  for (TrueLandmark& landmark : truth_.landmarks) {
    landmark.position = seen_from(*origin, landmark.position);
  }
  for (auto& [id, places] : truth_.movers) {
    for (auto& [step, place] : places) place = seen_from(*origin, place);
  }
}

std::vector<std::string> Truth::warnings(const RobotPart& part) const {
  std::vector<std::string> out;
  for (const std::string& path : {about_path(part), about_number(part)}) {
    if (!path.empty()) out.push_back(path);
  }
  const auto& found = part.result.landmarks;
  for (const auto& [a, b] :
       exchanged_ids(match_by_id(found, truth_.landmarks), found, truth_.landmarks)) {
    out.push_back(
        fmt::format("{}: landmarks {} and {} of the truth fit if exchanged", map_file_, a, b));
  }
  return out;
}

/// What is odd about the true path; "" where nothing is.
std::string Truth::about_path(const RobotPart& part) const {
  if (truth_.path.empty()) return "";
  if (real_part_first_) return about_real_part_first(path_file_);
  const Trajectory& dead_reckoning = part.result.dead_reckoning;
  if (stands_still(dead_reckoning)) return "";
  if (may_be_same_motion(pairs(dead_reckoning, part.log_rows).poses, content_)) return "";
  return path_file_ +
         ": the motions that it tells are not those of the odometry; is it the truth of another "
         "log?";
}

/// That most keyframes have no true pose; "" where enough have one.
std::string Truth::about_number(const RobotPart& part) const {
  const std::size_t all = part.result.trajectory.size();
  if (truth_.path.empty() || all == 0) return "";
  const std::size_t known = pairs(part.result.trajectory, part.log_rows).poses.size();
  const bool is_few = known < kFewestTruePoses || kFewestShare * known < all;
  if (!is_few || known == all) return "";
  return fmt::format(
      "{}: {} of {} keyframes {} a true pose, so that errors tell little of the path; are times of "
      "truth and log of one clock?",
      path_file_, known, all, known == 1 ? "has" : "have");
}

mrpt::poses::CPose3D Truth::origin_of_map(const Trajectory& estimate,
                                          const std::vector<std::size_t>& log_rows) const {
  const bool all = content_ == TruthContent::kPositions;
  if (!has_times_ && log_rows.front() < first_step_) {  // the first pose has no true one
    const std::vector<PosePair> later = pairs(estimate, log_rows).poses;
    if (!later.empty())
      return later.front().truth + (mrpt::poses::CPose3D() - later.front().estimate);
  }
  const std::vector<PosePair> known =
      (all ? pairs(estimate, log_rows) : pairs({estimate.front()}, {log_rows.front()})).poses;
  if (known.empty()) {
    throw Error(fmt::format(
        "{}: has no pose within {} s of {} pose of the log: it is of {} to {} s, "
        "the log of {} to {} s; times of both are of one clock",
        path_file_, kMaxTimeDifference, all ? "any" : "the first", truth_.path.front().time,
        truth_.path.back().time, estimate.front().time, estimate.back().time));
  }
  return all ? alignment(known) : known.front().truth;
}

Truth::Pairs Truth::pairs(const Trajectory& estimate,
                          const std::vector<std::size_t>& log_rows) const {
  Pairs out;
  if (has_times_) {
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      const TimedPose& pose = estimate[i];
      const auto pair =
          pair_by_time({{pose.time, pose.pose + T_robot_point_}}, truth_.path, kMaxTimeDifference);
      if (pair.empty()) continue;
      out.times.push_back(pose.time);
      out.poses.push_back(pair.front());
      out.indices.push_back(i);
    }
    return out;
  }
  const std::size_t last = *std::max_element(log_rows.begin(), log_rows.end());
  if (last >= first_step_ + truth_.path.size() && !may_end_early_) {
    throw Error(
        fmt::format("{}: has {} poses, but the log has a frame for row {}: this is the truth of "
                    "another log",
                    path_file_, truth_.path.size(), last));
  }
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const std::size_t row = log_rows[i] - first_step_;
    if (log_rows[i] < first_step_ || row >= truth_.path.size()) continue;
    out.times.push_back(estimate[i].time);
    out.poses.push_back({estimate[i].pose, truth_.path[row].pose});
    out.indices.push_back(i);
  }
  return out;
}

std::vector<RobotPart> parts_of(const MapResult& result, const Mapper& mapper, bool wanted) {
  const std::vector<Eigen::MatrixXd> covariances =
      wanted ? mapper.pose_covariances() : std::vector<Eigen::MatrixXd>(result.trajectory.size());
  const std::vector<std::size_t>& rows = mapper.log_rows();
  if (result.robots.empty()) return {{"", result, rows, covariances, rows}};
  std::vector<RobotPart> parts;
  for (const RobotPath& robot : result.robots) {
    RobotPart part{robot.name, result, {}, {}, std::vector<std::size_t>(rows.size(), kNoRow)};
    MapResult& own = part.result;
    own.robots.clear();
    own.in_known_map = result.in_known_map || !parts.empty();
    own.trajectory = part_of(result.trajectory, robot);
    own.dead_reckoning = part_of(result.dead_reckoning, robot);
    own.steps.clear();
    own.motion_modes.clear();
    own.mode_probabilities.clear();
    for (const std::size_t i : robot.keyframes) {
      own.steps.push_back(result.steps[i]);
      if (!result.motion_modes.empty()) {
        own.motion_modes.push_back(result.motion_modes[i]);
        own.mode_probabilities.push_back(result.mode_probabilities[i]);
      }
      part.log_rows.push_back(rows[i]);
      part.covariances.push_back(covariances[i]);
      part.rows_by_keyframe[i] = rows[i];
    }
    parts.push_back(std::move(part));
  }
  return parts;
}

std::vector<Truth> read_truths(const ReplaySettings& settings) {
  std::vector<Truth> truths;
  for (const RobotSettings& robot : settings.robots) {
    const std::string map = truths.empty() ? settings.truth_map : "";
    truths.emplace_back(robot.truth_path, map, robot.truth_point);
    truths.back().begin_at(robot.truth_step);
    if (settings.truth_datum) truths.back().refer_to(*settings.truth_datum);
    if (!robot.truth_associations.empty()) {
      truths.back().read_associations(robot.truth_associations);
    }
  }
  if (!settings.truth_movers.empty()) truths.front().read_movers(settings.truth_movers);
  return truths;
}

void adapt(std::vector<Truth>& truths, const std::vector<RobotPart>& parts) {
  std::optional<mrpt::poses::CPose3D> origin;
  for (std::size_t i = 0; i < truths.size() && !origin; ++i) {
    origin = truths[i].origin(parts[i].result, parts[i].log_rows);
  }
  for (Truth& truth : truths) truth.move(origin, parts.front().result.class_names);
}

GroundTruth joint_truth(const std::vector<Truth>& truths) {
  GroundTruth all = truths.front().get();
  for (std::size_t i = 1; i < truths.size(); ++i) all.others.push_back(truths[i].get().path);
  return all;
}

namespace {

/// The covariances of the poses that have a true one.
std::vector<Eigen::MatrixXd> covariances_of(const Truth::Pairs& pairs, const RobotPart& part) {
  std::vector<Eigen::MatrixXd> out;
  for (const std::size_t i : pairs.indices) out.push_back(part.covariances[i]);
  return out;
}

/// Mean NEES of the poses, where all have a covariance and a true orientation.
std::optional<double> pose_nees(TruthContent content, const std::vector<PosePair>& pairs,
                                const std::vector<Eigen::MatrixXd>& covariances) {
  const bool complete = std::all_of(covariances.begin(), covariances.end(),
                                    [](const auto& P) { return P.rows() > 0; });
  if (!complete || content == TruthContent::kPositions) return std::nullopt;
  return mean_nees(pairs, covariances);
}

/// Moves landmarks, not their covariances.
void move(std::vector<LandmarkEstimate>& landmarks, const mrpt::poses::CPose3D& T) {
  for (LandmarkEstimate& landmark : landmarks) {
    landmark.position = transformed(T, landmark.position);
  }
}

/// The true movers, and where the robots really were.
MoverTruth mover_truth(const std::vector<Truth>& truths, const std::vector<RobotPart>& parts,
                       const mrpt::poses::CPose3D& T_truth_map) {
  MoverTruth out{truths.front().get().movers, parts.front().rows_by_keyframe, {}, T_truth_map};
  const RobotPart& part = parts.front();  // the steps are those of its log
  if (truths.front().content() == TruthContent::kPositions) return out;
  if (truths.front().get().path.empty() || part.result.trajectory.empty()) return out;
  const Truth::Pairs pairs = truths.front().pairs(part.result.trajectory, part.log_rows);
  for (std::size_t i = 0; i < pairs.times.size(); ++i) out.poses[pairs.times[i]] = pairs.poses[i];
  return out;
}

/// Takes those decisions out that are about things which really move.
std::vector<AssociationDecision> about_standing(const std::vector<AssociationDecision>& decisions,
                                                const TrueMovers& movers) {
  std::vector<AssociationDecision> out;
  for (const AssociationDecision& d : decisions) {
    if (!d.true_id || movers.count(*d.true_id) == 0) out.push_back(d);
  }
  return out;
}

template <class T>
void append(std::vector<T>& to, const std::vector<T>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

/// The errors of the paths of all robots together, and the motion that aligns them.
void compare_paths(const std::vector<Truth>& truths, const std::vector<RobotPart>& parts,
                   TruthSummary& summary, mrpt::poses::CPose3D& T_truth_map) {
  if (parts.size() == 1) {
    summary = compare_path(truths.front(), parts.front());
    if (truths.front().get().path.empty()) return;
    const RobotPart& part = parts.front();
    T_truth_map = alignment(truths.front().pairs(part.result.trajectory, part.log_rows).poses);
    return;
  }
  std::vector<PosePair> estimate, reckoned;
  std::vector<Eigen::MatrixXd> covariances;
  TruthContent content = TruthContent::kPoses;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (truths[i].get().path.empty() || parts[i].result.trajectory.empty()) continue;
    const Truth::Pairs pairs = truths[i].pairs(parts[i].result.trajectory, parts[i].log_rows);
    append(estimate, pairs.poses);
    append(reckoned, truths[i].pairs(parts[i].result.dead_reckoning, parts[i].log_rows).poses);
    append(covariances, covariances_of(pairs, parts[i]));
    if (truths[i].content() == TruthContent::kPositions) content = TruthContent::kPositions;
  }
  if (estimate.empty()) return;
  summary.trajectory = trajectory_report(estimate, content);
  summary.dead_reckoning = trajectory_report(reckoned, content);
  summary.trajectory->relative.clear();  // stretches do not lead from robot to robot
  summary.dead_reckoning->relative.clear();
  summary.nees_pose = pose_nees(content, estimate, covariances);
  T_truth_map = alignment(estimate);
}

}  // namespace

TruthSummary compare_path(const Truth& truth, const RobotPart& part) {
  TruthSummary summary;
  if (truth.get().path.empty() || part.result.trajectory.empty()) return summary;
  const Truth::Pairs pairs = truth.pairs(part.result.trajectory, part.log_rows);
  summary.trajectory = trajectory_report(pairs.poses, truth.content());
  summary.dead_reckoning = trajectory_report(
      truth.pairs(part.result.dead_reckoning, part.log_rows).poses, truth.content());
  summary.nees_pose = pose_nees(truth.content(), pairs.poses, covariances_of(pairs, part));
  return summary;
}

TruthSummary compare(const std::vector<Truth>& truths, const std::vector<RobotPart>& parts,
                     const Mapper& mapper, double radius) {
  TruthSummary summary;
  const std::vector<LandmarkEstimate>& found = parts.front().result.landmarks;
  mrpt::poses::CPose3D T_truth_map;
  compare_paths(truths, parts, summary, T_truth_map);
  std::vector<LandmarkEstimate> aligned = found;
  move(aligned, T_truth_map);
  std::vector<AssociationDecision> decisions = mapper.decisions();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    truths[i].label(decisions, parts[i].rows_by_keyframe);
  }
  const TrueMovers& movers = truths.front().get().movers;
  if (!movers.empty() && !decisions.empty()) {
    summary.movers = mover_report(decisions, parts.front().result.movers,
                                  mover_truth(truths, parts, T_truth_map));
    decisions = about_standing(decisions, movers);
  }
  if (!decisions.empty()) summary.associations = association_report(decisions);
  const auto& landmarks = truths.front().get().landmarks;
  if (landmarks.empty()) return summary;
  const auto matching = decisions.empty() ? match_by_id(found, landmarks)
                                          : match_by_distance(aligned, landmarks, radius);
  summary.landmarks = landmark_errors(matching, found, landmarks);
  summary.landmarks_aligned = landmark_errors(matching, aligned, landmarks);
  summary.class_accuracy = class_accuracy(matching, found, landmarks);
  summary.nees_landmark = landmark_nees(matching, found, landmarks);
  return summary;
}

}  // namespace hybrid
