// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/evaluation/association_truth.h"
#include "mrpt_plugins/evaluation/trajectory_metrics.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// What was mapped of one robot.
struct RobotPart {
  std::string name;                           ///< empty where there is but one
  MapResult result;                           ///< with the poses and steps of this robot alone
  std::vector<std::size_t> log_rows;          ///< of these poses
  std::vector<Eigen::MatrixXd> covariances;   ///< of these poses, empty where not known
  std::vector<std::size_t> rows_by_keyframe;  ///< of all robots; npos for those of others
};

/// The robots of a map, each for itself; one part, which is the whole, where there is but one. With
/// the covariances of the poses where these are `wanted`.
std::vector<RobotPart> parts_of(const MapResult& result, const Mapper& mapper, bool wanted);

/// What really was of one robot and of the landmarks, as far as files tell it.
class Truth {
 public:
  /// Reads the files; an empty name means unknown. `point` is the place on the robot of what gives
  /// positions without orientation [m]. Throws Error for a missing or malformed file.
  Truth(const std::string& path_file, const std::string& map_file,
        const Eigen::Vector3d& point = Eigen::Vector3d::Zero());

  /// The step of the log that the first row of a path without times is of.
  void begin_at(std::size_t step) { first_step_ = step; }

  /// Its axes are east, north and up of that place: a map that knows where it lies is not aligned.
  void refer_to(const GeodeticPoint& datum) { frame_.emplace(datum); }

  /// Reads what measurements without an id saw. Throws Error for a missing or malformed file.
  void read_associations(const std::string& file) { associations_ = read_true_associations(file); }

  /// Reads where things that move were. Throws Error for a missing or malformed file.
  void read_movers(const std::string& file);

  /// Gives the true ids that the file of associations knows; `log_rows` is that of each keyframe.
  void label(std::vector<AssociationDecision>& decisions,
             const std::vector<std::size_t>& log_rows) const;

  bool empty() const { return truth_.path.empty() && truth_.landmarks.empty(); }

  /// The motion that takes the truth into the frame of the map, if there is one: that of the first
  /// pose, or where only positions are known the one that fits them best.
  std::optional<mrpt::poses::CPose3D> origin(const MapResult& result,
                                             const std::vector<std::size_t>& log_rows) const;
  /// Makes a motion, and gives the landmarks the class indices of the map. Throws Error for a class
  /// that it does not know.
  void move(const std::optional<mrpt::poses::CPose3D>& origin,
            const std::vector<std::string>& class_names);

  const GroundTruth& get() const { return truth_; }

  /// What is odd about the true path, given the dead reckoning of the log, how few keyframes it
  /// tells of where they are few, and what is odd about the ids of the
  /// true landmarks, given those of the map.
  std::vector<std::string> warnings(const RobotPart& part) const;

  /// What the path file tells of each pose.
  TruthContent content() const { return content_; }

  /// Poses with the true ones of the same instant, and when that was [s].
  struct Pairs {
    std::vector<double> times;
    std::vector<PosePair> poses;
    std::vector<std::size_t> indices;  ///< of the poses in the trajectory
  };
  Pairs pairs(const Trajectory& estimate, const std::vector<std::size_t>& log_rows) const;

 private:
  std::string about_path(const RobotPart& part) const;
  std::string about_number(const RobotPart& part) const;
  /// The origin of the map in the frame of the truth.
  mrpt::poses::CPose3D origin_of_map(const Trajectory& estimate,
                                     const std::vector<std::size_t>& log_rows) const;

  mrpt::poses::CPose3D origin_by_datum(const MapResult& result) const;

  GroundTruth truth_;
  std::optional<LocalFrame> frame_;
  AssociationTruth associations_;
  std::string path_file_, map_file_;
  std::vector<std::string> landmark_classes_;  // one per landmark, empty where unknown
  bool has_times_ = false;                     // else row i belongs to step first_step_ + i
  std::size_t first_step_ = 0;
  bool real_part_first_ = false;  // of the quaternions, as it seems
  bool may_end_early_ = false;    // steps after the last row are not known
  TruthContent content_ = TruthContent::kPoses;
  mrpt::poses::CPose3D T_robot_point_;  // what the positions are those of
};

/// The truths of the robots of a replay; that of the landmarks belongs to the first.
std::vector<Truth> read_truths(const ReplaySettings& settings);

/// Moves all truths, whose frame is one, into that of the map by the first robot whose path is
/// known.
void adapt(std::vector<Truth>& truths, const std::vector<RobotPart>& parts);

/// The truths as one, for pictures.
GroundTruth joint_truth(const std::vector<Truth>& truths);

/// All errors of a map against the truths, once they are adapted to it. Landmarks are matched by id
/// where the mapping took those of the log for granted, and else by distance, up to `radius`
/// metres.
TruthSummary compare(const std::vector<Truth>& truths, const std::vector<RobotPart>& parts,
                     const Mapper& mapper, double radius);
/// The errors of the path of one robot.
TruthSummary compare_path(const Truth& truth, const RobotPart& part);

}  // namespace hybrid
