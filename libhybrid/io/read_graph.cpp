// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_graph.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/io/escaped.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {
namespace {

constexpr TextFormat kFormat{TextFormat::Cut::kWords, "#"};
constexpr std::size_t kMostHypotheses = 1000;

using Visit = std::function<void(const TextRow&)>;
/// Reads all rows of the graph from its start.
using ReadRows = std::function<void(const Visit&)>;

/// The likely kind, for a message, of a file whose rows begin with this word.
const char* other_form(std::string_view word) {
  if (word[0] == '[') return ": this is an INI file, not a pose graph";
  const bool is_table = word.find(',') != std::string_view::npos ||
                        std::string_view("+-.0123456789").find(word[0]) != std::string_view::npos;
  return is_table ? ": this is a table, not a pose graph" : "";
}

std::uint64_t id(const TextRow& row, std::size_t i) {
  return static_cast<std::uint64_t>(row.id(i, kLargestVertexId));
}

SE2 planar_pose(const TextRow& row, std::size_t i) {
  return {row.coordinate(i), row.coordinate(i + 1), row.coordinate(i + 2)};
}

template <int n>
Eigen::Matrix<double, n, 1> point(const TextRow& row, std::size_t i) {
  Eigen::Matrix<double, n, 1> p;
  for (int axis = 0; axis < n; ++axis) p[axis] = row.coordinate(i + std::size_t(axis));
  return p;
}

SE3 pose_from_quaternion(const TextRow& row, std::size_t i) {
  Eigen::Quaterniond q(row.coordinate(i + 6), row.coordinate(i + 3), row.coordinate(i + 4),
                       row.coordinate(i + 5));
  const double norm = q.coeffs().norm();
  if (!(norm > 1e-6)) row.fail(i + 3, "a quaternion that has no direction");
  q.coeffs() /= norm;
  return {point<3>(row, i), q};
}

SE3 pose_from_angles(const TextRow& row, std::size_t i) {
  const Eigen::Quaterniond q = Eigen::AngleAxisd(row.coordinate(i + 5), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(row.coordinate(i + 4), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(row.coordinate(i + 3), Eigen::Vector3d::UnitX());
  return {point<3>(row, i), q};
}

/// Symmetric matrix from its upper triangle, row by row.
template <int n>
Eigen::Matrix<double, n, n> symmetric(const TextRow& row, std::size_t at) {
  Eigen::Matrix<double, n, n> m;
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) m(i, j) = m(j, i) = row.number(at++);
  }
  return m;
}

/// The same in the order of TORO's EDGE2: I11 I12 I22 I33 I13 I23.
Eigen::Matrix3d symmetric_toro(const TextRow& row, std::size_t at) {
  constexpr std::size_t kPlace[3][3] = {{0, 1, 4}, {1, 2, 5}, {4, 5, 3}};
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m(i, j) = row.number(at + kPlace[i][j]);
  }
  return m;
}

/// The nearest matrix whose smallest eigenvalue is at least the root of epsilon times its largest.
Eigen::MatrixXd nearest_definite(const Eigen::MatrixXd& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(m);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const double least = std::sqrt(std::numeric_limits<double>::epsilon()) * values.maxCoeff();
  const Eigen::MatrixXd& V = eigen.eigenvectors();
  const Eigen::MatrixXd near = V * values.cwiseMax(least).asDiagonal() * V.transpose();
  return 0.5 * (near + near.transpose());
}

/// The letter of the key of each vertex by its number; 0 for a vertex that no line has named.
class Letters {
 public:
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
  Parser(const std::string& name, const ReadGraphOptions& options, ReadRows read)
      : name_(name), options_(options), read_(std::move(read)) {}

  PoseGraph run() {
    read_([this](const TextRow& row) { parse(row); });
    if (graph_.values.empty() && graph_.edge_count() == 0) {
      throw Error(name_ + ": holds no vertex and no edge");
    }
    for (const TextRow& row : fixed_) fix(row);
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

  /// The key of vertex `number`, word `at` of the row, which must be a pose (key_letter::kPose) or
  /// a landmark (key_letter::kLandmark) throughout the file.
  Key key(char letter, std::uint64_t number, const TextRow& row, std::size_t at) {
    char& known = letters_[number];
    if (known == 0) known = letter;
    if (known != letter) {
      row.fail(at, "vertex " + std::to_string(number) + " is both a pose and a landmark");
    }
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
    const Key name = key(letter, id(row, 1), row, 1);
    if (graph_.values.contains(name)) {
      row.fail(1, "vertex " + std::to_string(name.index()) + " is there already");
    }
    graph_.values.insert(name, value);
  }

  /// An edge between the vertices in words 1 and `to`.
  template <class T>
  void add_edge(int dimension, std::vector<GraphEdge<T>>& edges, const T& measured,
                const Eigen::MatrixXd& information, const TextRow& row, std::size_t to = 2) {
    check_space(dimension, row);
    const bool to_point = Variable<T>::type().kind == VariableKind::kVector;
    const std::uint64_t i = id(row, 1), j = id(row, to);
    if (i == j) row.fail(to, "an edge from vertex " + std::to_string(i) + " to itself");
    const Key from = key(key_letter::kPose, i, row, 1);
    edges.push_back({from, key(to_point ? key_letter::kLandmark : key_letter::kPose, j, row, to),
                     measured, noise(information, row)});
  }

  /// Most edges of a file have the information of the one before.
  Noise noise(const Eigen::MatrixXd& information, const TextRow& row) {
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
    add_vertex(2, key_letter::kLandmark, point<2>(row, 2), row);
  }
  void vertex_xyz(const TextRow& row) {
    add_vertex(3, key_letter::kLandmark, point<3>(row, 2), row);
  }

  void edge_se2(const TextRow& row) {
    add_edge(2, graph_.poses2, planar_pose(row, 3), symmetric<3>(row, 6), row);
  }
  void edge_se3(const TextRow& row) {
    add_edge(3, graph_.poses3, pose_from_quaternion(row, 3), symmetric<6>(row, 10), row);
  }
  void edge3(const TextRow& row) {
    if (has_hypotheses("EDGE3", 12)) {
      return edge_with_hypotheses<SE3>(
          row, 6, "EDGE3 i 1 j 0 n, then x y z roll pitch yaw n times, n from 1 to 1000",
          [&](std::size_t at) { return pose_from_angles(row, at); }, graph_.poses3,
          graph_.alternatives3);
    }
    row.expect(30, find("EDGE3")->form);
    add_edge(3, graph_.poses3, pose_from_angles(row, 3), symmetric<6>(row, 9), row);
  }
  void edge_xy(const TextRow& row) {
    add_edge(2, graph_.points2, point<2>(row, 3), symmetric<2>(row, 5), row);
  }
  void edge_xyz(const TextRow& row) {
    id(row, 3);  // of the sensor offset, which is the identity
    add_edge(3, graph_.points3, point<3>(row, 4), symmetric<3>(row, 7), row);
  }
  void edge2(const TextRow& row) {
    if (has_hypotheses("EDGE2", 9)) {
      return edge_with_hypotheses<SE2>(
          row, 3, "EDGE2 i 1 j 0 n, then x y angle n times, n from 1 to 1000",
          [&](std::size_t at) { return planar_pose(row, at); }, graph_.poses2,
          graph_.alternatives2);
    }
    row.expect(12, find("EDGE2")->form);
    add_edge(2, graph_.poses2, planar_pose(row, 3), symmetric_toro(row, 6), row);
  }

  /// Whether any line of that tag has a single hypothesis and so many words, which no line of TORO
  /// has.
  bool has_hypotheses(const char* tag, std::size_t words) {
    if (!hypotheses_) {
      bool found = false;
      read_([&](const TextRow& row) { found = found || (row[0] == tag && row.size() == words); });
      hypotheses_ = found;
    }
    return *hypotheses_;
  }

  /// `numbers` make a pose, which `read` takes from a word on.
  template <class Pose, class Read>
  void edge_with_hypotheses(const TextRow& row, std::size_t numbers, const char* form,
                            const Read& read, std::vector<GraphEdge<Pose>>& edges,
                            std::vector<EdgeAlternatives<Pose>>& alternatives) {
    row.expect(6 + numbers, 6 + numbers * kMostHypotheses, form);
    const std::uint64_t n = id(row, 5);
    if (id(row, 2) != 1 || id(row, 4) != 0 || n < 1 || n > kMostHypotheses) {
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

  void offset(const TextRow& row) {
    id(row, 1);
    if (pose_from_quaternion(row, 2).log().norm() > 1e-9) {
      row.fail("a sensor offset other than the identity is not supported");
    }
  }

  void equivalence(const TextRow& row) {
    id(row, 1);
    id(row, 2);
    ++graph_.equivalences;
  }

  void note_fixed(const TextRow& row) {
    row.expect(2, row.size(), find("FIX")->form);
    for (std::size_t i = 1; i < row.size(); ++i) id(row, i);
    fixed_.push_back(row);
  }
  void fix(const TextRow& row) {
    for (std::size_t i = 1; i < row.size(); ++i) {
      const std::uint64_t number = id(row, i);
      const char letter = letters_[number];
      if (letter == 0) row.fail(i, "FIX names unknown vertex " + std::to_string(number));
      graph_.fixed.push_back(Key(letter, number));
    }
  }

  const std::string& name_;
  ReadGraphOptions options_;
  ReadRows read_;
  PoseGraph graph_;
  int dimension_ = 0;
  std::optional<bool> hypotheses_;
  Letters letters_;
  std::vector<TextRow> fixed_;
  Eigen::MatrixXd information_;  // of noise_
  std::optional<Noise> noise_;   // the newest
};

void read_rows(TextReader& text, const Visit& visit) {
  TextRow row;
  while (text.next(row)) visit(row);
}

}  // namespace

PoseGraph parse_graph(std::string_view text, const std::string& name,
                      const ReadGraphOptions& options) {
  return Parser(name, options,
                [&](const Visit& visit) {
                  TextReader reader(text, name, kFormat);
                  read_rows(reader, visit);
                })
      .run();
}

PoseGraph read_graph(const std::string& path, const ReadGraphOptions& options) {
  return Parser(path, options,
                [&](const Visit& visit) {
                  TextReader reader(path, kFormat);
                  read_rows(reader, visit);
                })
      .run();
}

}  // namespace hybrid
