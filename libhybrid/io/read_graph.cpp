// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_graph.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <unordered_map>
#include <utility>

namespace hybrid {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// The words of one line, and errors that say where it is.
class Line {
 public:
  Line(std::string_view text, const std::string& file, int number)
      : rest_(text), file_(file), number_(number) {}

  /// Empty at the end of the line, or at a comment.
  std::string_view word() {
    while (!rest_.empty() && is_space(rest_.front())) rest_.remove_prefix(1);
    if (rest_.empty() || rest_.front() == '#') return {};
    std::size_t n = 0;
    while (n < rest_.size() && !is_space(rest_[n])) ++n;
    const std::string_view found = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return found;
  }

  void set_tag(std::string_view tag) { tag_ = tag; }

  std::uint64_t id() {
    const std::string_view text = word();
    if (text.empty()) fail(std::string(tag_) + " ends where the id of a vertex should be");
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || (value >> 56) != 0) {
      fail("'" + std::string(text) + "' is not the id of a vertex");
    }
    return value;
  }

  /// n finite numbers, if they are the last ones exactly up to the end of the line.
  template <std::size_t n>
  void numbers(double (&out)[n], bool last = true) {
    for (std::size_t i = 0; i < n; ++i) out[i] = number(i, n);
    if (last && !word().empty()) {
      fail(std::string(tag_) + " has more than the " + std::to_string(n) + " numbers it needs");
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(file_ + ":" + std::to_string(number_) + ": " + what);
  }

 private:
  double number(std::size_t i, std::size_t n) {
    const std::string_view text = word();
    if (text.empty()) {
      fail(std::string(tag_) + " needs " + std::to_string(n) + " numbers after the ids, got " +
           std::to_string(i));
    }
    const char* first = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-');
    double value = 0.0;
    const auto [end, error] = std::from_chars(first, text.data() + text.size(), value);
    if (error == std::errc::invalid_argument || end != text.data() + text.size()) {
      fail("'" + std::string(text) + "' is not a number");
    }
    // Out of range both ways: what underflows is malformed data too.
    if (error != std::errc() || !std::isfinite(value)) {
      fail("'" + std::string(text) + "' is not a finite number");
    }
    return value;
  }

  std::string_view rest_;
  std::string_view tag_;
  const std::string& file_;
  int number_;
};

/// Symmetric matrix from its upper triangle, row by row.
template <int n>
Eigen::MatrixXd symmetric(const double* upper) {
  Eigen::MatrixXd m(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) m(i, j) = m(j, i) = *upper++;
  }
  return m;
}

/// Whether any EDGE2 line holds a single hypothesis, which no line of TORO looks like.
bool has_hypotheses(std::string_view text) {
  constexpr int kWords = 8;
  const std::string name;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    Line line(text.substr(0, end), name, 0);
    if (line.word() == "EDGE2") {
      int words = 0;
      while (!line.word().empty()) ++words;
      if (words == kWords) return true;
    }
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
  }
  return false;
}

class Parser {
 public:
  explicit Parser(const std::string& name) : name_(name) {}

  PoseGraph run(std::string_view text) {
    hypotheses_ = has_hypotheses(text);
    for (int number = 1; !text.empty(); ++number) {
      const std::size_t end = text.find('\n');
      Line line(text.substr(0, end), name_, number);
      parse(line);
      text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    }
    if (graph_.values.empty() && graph_.edge_count() == 0) {
      throw Error(name_ + ": holds no vertex and no edge");
    }
    for (const auto& [id, line] : fixed_) {
      const auto it = letters_.find(id);
      if (it == letters_.end()) line.fail("FIX names unknown vertex " + std::to_string(id));
      graph_.fixed.push_back(Key(it->second, id));
    }
    return std::move(graph_);
  }

 private:
  using Handler = void (Parser::*)(Line&);

  void parse(Line& line) {
    static const std::unordered_map<std::string_view, Handler> handlers{
        {"VERTEX_SE2", &Parser::vertex_se2},      {"VERTEX2", &Parser::vertex_se2},
        {"VERTEX_SE3:QUAT", &Parser::vertex_se3}, {"VERTEX3", &Parser::vertex3},
        {"VERTEX_XY", &Parser::vertex_xy},        {"VERTEX_TRACKXYZ", &Parser::vertex_xyz},
        {"EDGE_SE2", &Parser::edge_se2},          {"EDGE2", &Parser::edge2},
        {"EDGE_SE3:QUAT", &Parser::edge_se3},     {"EDGE3", &Parser::edge3},
        {"EDGE_SE2_XY", &Parser::edge_xy},        {"EDGE_SE3_TRACKXYZ", &Parser::edge_xyz},
        {"PARAMS_SE3OFFSET", &Parser::offset},    {"FIX", &Parser::fix},
    };
    const std::string_view tag = line.word();
    if (tag.empty()) return;
    const auto it = handlers.find(tag);
    if (it == handlers.end()) line.fail("unknown tag '" + std::string(tag) + "'");
    line.set_tag(tag);
    (this->*it->second)(line);
  }

  /// The key of a vertex, which must be a pose ('x') or a landmark ('l') throughout the file.
  Key key(char letter, std::uint64_t id, const Line& line) {
    const auto [it, is_new] = letters_.emplace(id, letter);
    if (it->second != letter) {
      line.fail("vertex " + std::to_string(id) + " is both a pose and a landmark");
    }
    return Key(letter, id);
  }

  void check_space(int dimension, const Line& line) {
    if (dimension_ == 0) dimension_ = dimension;
    if (dimension_ != dimension) {
      line.fail("a " + std::to_string(dimension) + "-D line in a " + std::to_string(dimension_) +
                "-D graph");
    }
  }

  template <class T>
  void add_vertex(int dimension, char letter, std::uint64_t id, const T& value, Line& line) {
    check_space(dimension, line);
    const Key name = key(letter, id, line);
    if (graph_.values.contains(name)) {
      line.fail("vertex " + std::to_string(id) + " is there already");
    }
    graph_.values.insert(name, value);
  }

  template <class T>
  void add_edge(int dimension, std::vector<GraphEdge<T>>& edges, std::uint64_t i, std::uint64_t j,
                const T& measured, const Eigen::MatrixXd& information, Line& line) {
    check_space(dimension, line);
    if (i == j) line.fail("an edge from vertex " + std::to_string(i) + " to itself");
    const char letter = Variable<T>::type().kind == VariableKind::kVector ? 'l' : 'x';
    const Key from = key('x', i, line);
    const Key to = key(letter, j, line);
    edges.push_back({from, to, measured, noise(information, line)});
  }

  static Noise noise(const Eigen::MatrixXd& information, const Line& line) {
    try {
      return Noise::information(information);
    } catch (const Error& error) {
      line.fail(error.what());
    }
  }

  static SE3 pose_from_quaternion(const double* v, const Line& line) {
    Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
    const double norm = q.coeffs().norm();
    if (!(norm > 1e-6) || !std::isfinite(norm)) line.fail("a quaternion that has no direction");
    q.coeffs() /= norm;
    return {{v[0], v[1], v[2]}, q};
  }

  static SE3 pose_from_angles(const double* v) {
    const Eigen::Quaterniond q = Eigen::AngleAxisd(v[5], Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(v[4], Eigen::Vector3d::UnitY()) *
                                 Eigen::AngleAxisd(v[3], Eigen::Vector3d::UnitX());
    return {{v[0], v[1], v[2]}, q};
  }

  void vertex_se2(Line& line) {
    const std::uint64_t id = line.id();
    double v[3];
    line.numbers(v);
    add_vertex(2, 'x', id, SE2(v[0], v[1], v[2]), line);
  }
  void vertex_se3(Line& line) {
    const std::uint64_t id = line.id();
    double v[7];
    line.numbers(v);
    add_vertex(3, 'x', id, pose_from_quaternion(v, line), line);
  }
  void vertex3(Line& line) {
    const std::uint64_t id = line.id();
    double v[6];
    line.numbers(v);
    add_vertex(3, 'x', id, pose_from_angles(v), line);
  }
  void vertex_xy(Line& line) {
    const std::uint64_t id = line.id();
    double v[2];
    line.numbers(v);
    add_vertex(2, 'l', id, Eigen::Vector2d(v[0], v[1]), line);
  }
  void vertex_xyz(Line& line) {
    const std::uint64_t id = line.id();
    double v[3];
    line.numbers(v);
    add_vertex(3, 'l', id, Eigen::Vector3d(v[0], v[1], v[2]), line);
  }

  void edge_se2(Line& line) {
    const std::uint64_t i = line.id(), j = line.id();
    double v[9];
    line.numbers(v);
    add_edge(2, graph_.poses2, i, j, SE2(v[0], v[1], v[2]), symmetric<3>(v + 3), line);
  }
  /// i 1 j 0 n, then n motions.
  void edge_with_hypotheses(Line& line) {
    constexpr std::uint64_t kMost = 1000;
    const std::uint64_t i = line.id(), one = line.id(), j = line.id(), zero = line.id();
    const std::uint64_t n = line.id();
    if (one != 1 || zero != 0 || n < 1 || n > kMost) {
      line.fail("EDGE2 with hypotheses should read 'i 1 j 0 n', n from 1 to 1000");
    }
    std::vector<SE2> measured;
    for (std::uint64_t k = 0; k < n; ++k) {
      double v[3];
      line.numbers(v, k + 1 == n);
      measured.emplace_back(v[0], v[1], v[2]);
    }
    Eigen::Vector3d sigmas(1.0 / 30, 1.0 / 30, 1.0 / 100);
    const Eigen::MatrixXd information = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
    add_edge(2, graph_.poses2, i, j, measured[0], information, line);
    if (n == 1) return;
    measured.erase(measured.begin());
    graph_.alternatives.push_back({graph_.poses2.size() - 1, std::move(measured)});
  }
  void edge2(Line& line) {
    if (hypotheses_) return edge_with_hypotheses(line);
    const std::uint64_t i = line.id(), j = line.id();
    double v[9];
    line.numbers(v);
    const double upper[] = {v[3], v[4], v[7], v[5], v[8], v[6]};
    add_edge(2, graph_.poses2, i, j, SE2(v[0], v[1], v[2]), symmetric<3>(upper), line);
  }
  void edge_se3(Line& line) {
    const std::uint64_t i = line.id(), j = line.id();
    double v[28];
    line.numbers(v);
    add_edge(3, graph_.poses3, i, j, pose_from_quaternion(v, line), symmetric<6>(v + 7), line);
  }
  void edge3(Line& line) {
    const std::uint64_t i = line.id(), j = line.id();
    double v[27];
    line.numbers(v);
    add_edge(3, graph_.poses3, i, j, pose_from_angles(v), symmetric<6>(v + 6), line);
  }
  void edge_xy(Line& line) {
    const std::uint64_t i = line.id(), j = line.id();
    double v[5];
    line.numbers(v);
    add_edge(2, graph_.points2, i, j, Eigen::Vector2d(v[0], v[1]), symmetric<2>(v + 2), line);
  }
  void edge_xyz(Line& line) {
    const std::uint64_t i = line.id(), j = line.id();
    line.id();  // of the sensor offset, which is the identity
    double v[9];
    line.numbers(v);
    add_edge(3, graph_.points3, i, j, Eigen::Vector3d(v[0], v[1], v[2]), symmetric<3>(v + 3), line);
  }

  void offset(Line& line) {
    line.id();
    double v[7];
    line.numbers(v);
    if (pose_from_quaternion(v, line).log().norm() > 1e-9) {
      line.fail("a sensor offset other than the identity is not supported");
    }
  }
  void fix(Line& line) {
    do {
      const std::uint64_t id = line.id();
      fixed_.emplace_back(id, line);
    } while (!Line(line).word().empty());
  }

  const std::string& name_;
  PoseGraph graph_;
  int dimension_ = 0;
  bool hypotheses_ = false;
  std::unordered_map<std::uint64_t, char> letters_;
  std::vector<std::pair<std::uint64_t, Line>> fixed_;
};

}  // namespace

PoseGraph parse_graph(std::string_view text, const std::string& name) {
  return Parser(name).run(text);
}

PoseGraph read_graph(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw Error(path + ": cannot be opened");
  std::string text;
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  while (in) {
    const std::size_t size = text.size();
    text.resize(size + kChunk);
    in.read(text.data() + size, kChunk);
    text.resize(size + static_cast<std::size_t>(in.gcount()));
  }
  if (in.bad()) throw Error(path + ": cannot be read");
  return parse_graph(text, path);
}

}  // namespace hybrid
