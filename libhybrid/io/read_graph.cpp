// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_graph.h"

#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/detail/graph_row.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

constexpr TextFormat kFormat{TextFormat::Cut::kWords, "#"};
constexpr std::size_t kMostHypotheses = 1000;
constexpr double kMostInformation = 1e30;  // of a standard deviation below the rounding of one

/// The likely kind, for a message, of a file whose rows begin with this word.
const char* other_form(std::string_view word) {
  if (word[0] == '[') return ": this is an INI file, not a pose graph";
  const bool is_table = word.find(',') != std::string_view::npos ||
                        std::string_view("+-.0123456789").find(word[0]) != std::string_view::npos;
  return is_table ? ": this is a table, not a pose graph" : "";
}

/// What the vertices of each number are: poses, landmarks, or one of each.
class Kinds {
 public:
  enum : char { kPose = 1, kLandmark = 2 };

  char& operator[](std::uint64_t number) {
    if (number >= kDense) return sparse_[number];
    if (number >= dense_.size()) dense_.resize(number + 1);
    return dense_[number];
  }

 private:
  static constexpr std::uint64_t kDense = std::uint64_t{1} << 24;  // at most 16 MiB

  std::vector<char> dense_;
  std::unordered_map<std::uint64_t, char> sparse_;
};

class Parser {
 public:
  Parser(const std::string& name, const ReadGraphOptions& options, ReadGraphRows read)
      : name_(name), options_(options), read_(std::move(read)) {}

  PoseGraph run() {
    read_([this](const TextRow& row) { parse(row); });
    if (graph_.values.empty() && graph_.edge_count() + graph_.prior_count() == 0) {
      throw Error(name_ + ": holds no vertex and no edge");
    }
    for (const TextRow& row : fixed_) fix(row);
    place_sensors();
    graph_.unseen = erase_unseen_landmarks(graph_);
    return std::move(graph_);
  }

 private:
  /// The form of the lines with a tag, and the function that reads them.
  struct Tag {
    std::size_t words;  // 0: any number of them
    const char* form;
    void (Parser::*read)(const TextRow&);
  };

  static const Tag* find(std::string_view name) {
    static const std::unordered_map<std::string_view, Tag> tags{
        {"VERTEX_SE2", {5, "VERTEX_SE2 id x y angle", &Parser::vertex_se2}},
        {"VERTEX2", {5, "VERTEX2 id x y angle", &Parser::vertex_se2}},
        {"VERTEX_SE3:QUAT", {9, "VERTEX_SE3:QUAT id x y z qx qy qz qw", &Parser::vertex_se3}},
        {"VERTEX3", {8, "VERTEX3 id x y z roll pitch yaw", &Parser::vertex3}},
        {"VERTEX_XY", {4, "VERTEX_XY id x y", &Parser::vertex_xy}},
        {"VERTEX_TRACKXYZ", {5, "VERTEX_TRACKXYZ id x y z", &Parser::vertex_xyz}},
        {"EDGE_SE2", {12, "EDGE_SE2 i j x y angle information(6)", &Parser::edge_se2}},
        {"EDGE2", {0, "EDGE2 i j x y angle information(6)", &Parser::edge2}},
        {"EDGE_SE3:QUAT",
         {31, "EDGE_SE3:QUAT i j x y z qx qy qz qw information(21)", &Parser::edge_se3}},
        {"EDGE3", {0, "EDGE3 i j x y z roll pitch yaw information(21)", &Parser::edge3}},
        {"EDGE_SE2_XY", {8, "EDGE_SE2_XY i j x y information(3)", &Parser::edge_xy}},
        {"EDGE_SE3_TRACKXYZ",
         {13, "EDGE_SE3_TRACKXYZ i j parameter x y z information(6)", &Parser::edge_xyz}},
        {"EDGE_PRIOR_SE2", {11, "EDGE_PRIOR_SE2 i x y angle information(6)", &Parser::prior_se2}},
        {"EDGE_SE2_PRIOR", {11, "EDGE_SE2_PRIOR i x y angle information(6)", &Parser::prior_se2}},
        {"EDGE_PRIOR_SE2_XY", {7, "EDGE_PRIOR_SE2_XY i x y information(3)", &Parser::prior_xy}},
        {"EDGE_SE2_XYPRIOR", {7, "EDGE_SE2_XYPRIOR i x y information(3)", &Parser::prior_xy}},
        {"EDGE_SE3_PRIOR",
         {31, "EDGE_SE3_PRIOR i parameter x y z qx qy qz qw information(21)", &Parser::prior_se3}},
        {"EDGE_SE3_XYZPRIOR",
         {12, "EDGE_SE3_XYZPRIOR i parameter x y z information(6)", &Parser::prior_xyz}},
        {"PARAMS_SE2OFFSET", {5, "PARAMS_SE2OFFSET id x y angle", &Parser::planar_offset}},
        {"PARAMS_SE3OFFSET", {9, "PARAMS_SE3OFFSET id x y z qx qy qz qw", &Parser::offset}},
        {"FIX", {0, "FIX id ...", &Parser::note_fixed}},
        {"EQUIV", {3, "EQUIV i j", &Parser::equivalence}},
    };
    const auto it = tags.find(name);
    return it == tags.end() ? nullptr : &it->second;
  }

  void parse(const TextRow& row) {
    const Tag* tag = find(row[0]);
    if (tag == nullptr) row.fail("unknown tag " + in_quotes(row[0]) + other_form(row[0]));
    if (tag->words > 0) row.expect(tag->words, tag->form);
    (this->*tag->read)(row);
  }

  /// The key of the pose or landmark (`letter`) that word `at` of the row names.
  Key key(char letter, const TextRow& row, std::size_t at) {
    const std::uint64_t number = vertex_in(row, at);
    kinds_[number] |= letter == key_letter::kPose ? Kinds::kPose : Kinds::kLandmark;
    return Key(letter, number);
  }

  void check_space(int dimension, const TextRow& row) {
    if (dimension_ == 0) dimension_ = dimension;
    if (dimension_ != dimension) {
      row.fail("a " + std::to_string(dimension) + "-D line in a " + std::to_string(dimension_) +
               "-D graph");
    }
  }

  template <class T>
  void add_vertex(int dimension, char letter, const T& value, const TextRow& row) {
    check_space(dimension, row);
    const Key name = key(letter, row, 1);
    if (graph_.values.contains(name)) {
      row.fail(1, "vertex " + std::string(row[1]) + " is there already");
    }
    graph_.values.insert(name, value);
  }

  /// An edge between the vertices in words 1 and `to`.
  template <class T>
  void add_edge(int dimension, std::vector<GraphEdge<T>>& edges, const T& measured,
                const Eigen::MatrixXd& information, const TextRow& row, std::size_t to = 2) {
    check_space(dimension, row);
    const bool to_point = Variable<T>::type().kind == VariableKind::kVector;
    const Key i = key(key_letter::kPose, row, 1);
    const Key j = key(to_point ? key_letter::kLandmark : key_letter::kPose, row, to);
    if (i == j) row.fail(to, "an edge from vertex " + std::string(row[1]) + " to itself");
    edges.push_back({i, j, measured, noise(information, row)});
  }

  /// What is measured of the pose in word 1 in the frame of the map.
  template <class Measurement, class T>
  void add_absolute(int dimension, std::vector<Measurement>& priors, const T& measured,
                    const Eigen::MatrixXd& information, const TextRow& row) {
    check_space(dimension, row);
    priors.push_back({key(key_letter::kPose, row, 1), measured, noise(information, row)});
  }

  /// Most edges of a file have the information of the one before.
  Noise noise(const Eigen::MatrixXd& information, const TextRow& row) {
    if (information.maxCoeff() > kMostInformation) {
      row.fail("information beyond 1e30, more than any measurement has; is it to be fixed (FIX)?");
    }
    std::string why;
    try {
      const bool same = noise_ && noise_->dim() == information.rows();
      if (!same || information != information_) {
        noise_ = Noise::information(information);
        information_ = information;
      }
      return *noise_;
    } catch (const Error& error) {
      why = error.what();
    }
    if (options_.repair_information) {
      try {
        const Noise repaired = Noise::information(nearest_definite(information));
        ++graph_.repaired;
        return repaired;
      } catch (const Error&) {
        why += ", and none is near";
      }
    }
    try {
      row.fail(why);
    } catch (const Error& error) {
      throw InformationError(error.what());
    }
  }

  void vertex_se2(const TextRow& row) {
    add_vertex(2, key_letter::kPose, planar_pose(row, 2), row);
  }
  void vertex_se3(const TextRow& row) {
    add_vertex(3, key_letter::kPose, pose_from_quaternion(row, 2), row);
  }
  void vertex3(const TextRow& row) {
    add_vertex(3, key_letter::kPose, pose_from_angles(row, 2), row);
  }
  void vertex_xy(const TextRow& row) {
    add_vertex(2, key_letter::kLandmark, point_in<2>(row, 2), row);
  }
  void vertex_xyz(const TextRow& row) {
    add_vertex(3, key_letter::kLandmark, point_in<3>(row, 2), row);
  }

  void edge_se2(const TextRow& row) {
    add_edge(2, graph_.poses2, planar_pose(row, 3), symmetric<3>(row, 6), row);
  }
  void edge_se3(const TextRow& row) {
    add_edge(3, graph_.poses3, pose_from_quaternion(row, 3), symmetric<6>(row, 10), row);
  }
  void edge3(const TextRow& row) {
    if (forms().hypotheses) {
      return edge_with_hypotheses<SE3>(
          row, 6, "EDGE3 i 1 j 0 n, then x y z roll pitch yaw n times, n from 1 to 1000",
          [&](std::size_t at) { return pose_from_angles(row, at); }, graph_.poses3,
          graph_.alternatives3);
    }
    row.expect(30, find("EDGE3")->form);
    add_edge(3, graph_.poses3, pose_from_angles(row, 3), symmetric<6>(row, 9), row);
  }
  void edge_xy(const TextRow& row) {
    add_edge(2, graph_.points2, point_in<2>(row, 3), symmetric<2>(row, 5), row);
  }
  void edge_xyz(const TextRow& row) {
    add_edge(3, graph_.points3, point_in<3>(row, 4), symmetric<3>(row, 7), row);
    point_sensors_.push_back(sensor(row, 3));
  }
  void prior_se2(const TextRow& row) {
    add_absolute(2, graph_.priors2, planar_pose(row, 2), symmetric<3>(row, 5), row);
  }
  void prior_xy(const TextRow& row) {
    add_absolute(2, graph_.positions2, point_in<2>(row, 2), symmetric<2>(row, 4), row);
  }
  void prior_se3(const TextRow& row) {
    add_absolute(3, graph_.priors3, pose_from_quaternion(row, 3), symmetric<6>(row, 10), row);
    pose_sensors_.push_back(sensor(row, 2));
  }
  void prior_xyz(const TextRow& row) {
    add_absolute(3, graph_.positions3, point_in<3>(row, 3), symmetric<3>(row, 6), row);
    position_sensors_.push_back(sensor(row, 2));
  }
  void edge2(const TextRow& row) {
    if (forms().hypotheses) {
      return edge_with_hypotheses<SE2>(
          row, 3, "EDGE2 i 1 j 0 n, then x y angle n times, n from 1 to 1000",
          [&](std::size_t at) { return planar_pose(row, at); }, graph_.poses2,
          graph_.alternatives2);
    }
    row.expect(12, find("EDGE2")->form);
    const bool by_rows = forms().by_rows;
    graph_.edge2_by_rows = by_rows;
    add_edge(2, graph_.poses2, planar_pose(row, 3),
             by_rows ? symmetric<3>(row, 6) : symmetric_toro(row, 6), row);
  }

  const GraphForms& forms() {
    if (!forms_) forms_ = graph_forms(read_);
    return *forms_;
  }

  /// `numbers` make a pose, which `read` takes from a word on.
  template <class Pose, class Read>
  void edge_with_hypotheses(const TextRow& row, std::size_t numbers, const char* form,
                            const Read& read, std::vector<GraphEdge<Pose>>& edges,
                            std::vector<EdgeAlternatives<Pose>>& alternatives) {
    row.expect(6 + numbers, 6 + numbers * kMostHypotheses, form);
    const std::uint64_t n = vertex_in(row, 5);
    if (vertex_in(row, 2) != 1 || vertex_in(row, 4) != 0 || n < 1 || n > kMostHypotheses) {
      row.fail("expected: " + std::string(form));
    }
    row.expect(6 + numbers * n, form);
    std::vector<Pose> measured;
    for (std::uint64_t k = 0; k < n; ++k) measured.push_back(read(6 + numbers * k));
    constexpr int kPoint = Pose::Point::RowsAtCompileTime;
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(Pose::kDim, 1.0 / 100);
    sigmas.head(kPoint).setConstant(1.0 / 30);
    const Eigen::MatrixXd information = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
    add_edge(kPoint, edges, measured[0], information, row, 3);
    if (n == 1) return;
    measured.erase(measured.begin());
    alternatives.push_back({edges.size() - 1, std::move(measured)});
  }

  void offset(const TextRow& row) { offsets_[sensor(row, 1)] = pose_from_quaternion(row, 2); }
  void planar_offset(const TextRow& row) { sensor(row, 1); }  // no line that is read uses it

  static std::int64_t sensor(const TextRow& row, std::size_t i) {
    return row.id(i, std::numeric_limits<std::int64_t>::max());
  }

  /// The pose of a sensor on the robot: the identity in a file that gives none.
  SE3 sensor_pose(std::int64_t sensor) const {
    if (offsets_.empty()) return {};
    const auto offset = offsets_.find(sensor);
    if (offset != offsets_.end()) return offset->second;
    throw Error(name_ + ": no PARAMS_SE3OFFSET line gives sensor offset " + std::to_string(sensor) +
                ", which a measurement names");
  }

  /// Measurements of sensors become those of the robot: exactly for points, and for poses too.
  void place_sensors() {
    for (std::size_t k = 0; k < point_sensors_.size(); ++k) {
      const SE3 T_robot_sensor = sensor_pose(point_sensors_[k]);
      if (T_robot_sensor.log().isZero(0)) continue;
      GraphEdge<Eigen::Vector3d>& edge = graph_.points3[k];
      const Eigen::Matrix3d R = T_robot_sensor.rotation().matrix();
      edge.measured = T_robot_sensor * edge.measured;
      edge.noise = Noise::information(R * edge.noise.information() * R.transpose());
    }
    for (std::size_t k = 0; k < pose_sensors_.size(); ++k) {
      const SE3 T_sensor_robot = sensor_pose(pose_sensors_[k]).inverse();
      if (T_sensor_robot.log().isZero(0)) continue;
      GraphPrior<SE3>& prior = graph_.priors3[k];
      const SE3::Jacobian A = T_sensor_robot.adjoint();
      prior.measured = prior.measured * T_sensor_robot;
      prior.noise = Noise::information(A.transpose() * prior.noise.information() * A);
    }
    for (std::size_t k = 0; k < position_sensors_.size(); ++k) {
      graph_.positions3[k].lever_arm = sensor_pose(position_sensors_[k]).translation();
    }
  }

  void equivalence(const TextRow& row) {
    vertex_in(row, 1);
    vertex_in(row, 2);
    ++graph_.equivalences;
  }

  void note_fixed(const TextRow& row) {
    row.expect(2, row.size(), find("FIX")->form);
    for (std::size_t i = 1; i < row.size(); ++i) vertex_in(row, i);
    fixed_.push_back(row);
  }
  /// A number of both a pose and a landmark is that of the pose.
  void fix(const TextRow& row) {
    for (std::size_t i = 1; i < row.size(); ++i) {
      const std::uint64_t number = vertex_in(row, i);
      const char kinds = kinds_[number];
      if (kinds == 0) row.fail(i, "FIX names unknown vertex " + std::string(row[i]));
      const bool pose = (kinds & Kinds::kPose) != 0;
      graph_.fixed.push_back(Key(pose ? key_letter::kPose : key_letter::kLandmark, number));
    }
  }

  const std::string& name_;
  ReadGraphOptions options_;
  ReadGraphRows read_;
  PoseGraph graph_;
  int dimension_ = 0;
  std::optional<GraphForms> forms_;
  Kinds kinds_;
  std::unordered_map<std::int64_t, SE3> offsets_;  // by the number of the sensor
  std::vector<std::int64_t> point_sensors_;        // of points3
  std::vector<std::int64_t> pose_sensors_;         // of priors3
  std::vector<std::int64_t> position_sensors_;     // of positions3
  std::vector<TextRow> fixed_;
  Eigen::MatrixXd information_;  // of noise_
  std::optional<Noise> noise_;   // the newest
};

void read_rows(TextReader& text, const VisitRow& visit) {
  TextRow row;
  while (text.next(row)) visit(row);
}

}  // namespace

PoseGraph parse_graph(std::string_view text, const std::string& name,
                      const ReadGraphOptions& options) {
  return Parser(name, options,
                [&](const VisitRow& visit) {
                  TextReader reader(text, name, kFormat);
                  read_rows(reader, visit);
                })
      .run();
}

PoseGraph read_graph(const std::string& path, const ReadGraphOptions& options) {
  return Parser(path, options,
                [&](const VisitRow& visit) {
                  TextReader reader(path, kFormat);
                  read_rows(reader, visit);
                })
      .run();
}

}  // namespace hybrid
