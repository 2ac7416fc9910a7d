// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/matching.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/core/infinity.h"

namespace hybrid {
namespace {

constexpr int kFree = -2;  // a row whose column is not prescribed

void check(const MatchingProblem& problem) {
  if (problem.matched.rows() != problem.unmatched.size()) {
    throw Error("a matching of " + std::to_string(problem.matched.rows()) + " detections has " +
                std::to_string(problem.unmatched.size()) + " costs of no match");
  }
  if (problem.matched.array().isNaN().any() || !problem.unmatched.allFinite()) {
    throw Error("a cost of a matching is not a number, or one of no match is not finite");
  }
}

/// What Murty's partition prescribes: fixed rows, and pairs that are forbidden. Column -1 is "no
/// match".
struct Node {
  std::vector<int> fixed;  // by row: a column, -1, or kFree
  std::vector<std::pair<int, int>> forbidden;
  Matching best;
};

/// The assignment problem in the form of the augmenting paths: every row has one private column for
/// "no match" behind the shared ones.
class Solver {
 public:
  Solver(const MatchingProblem& problem, const Node& node)
      : rows_(static_cast<int>(problem.unmatched.size())),
        shared_(static_cast<int>(problem.matched.cols())),
        cost_(Eigen::MatrixXd::Constant(rows_, shared_ + rows_, kInfinity)) {
    cost_.leftCols(shared_) = problem.matched;
    for (int i = 0; i < rows_; ++i) cost_(i, shared_ + i) = problem.unmatched[i];
    for (const auto& [i, j] : node.forbidden) cost_(i, place(i, j)) = kInfinity;
    for (int i = 0; i < rows_; ++i) {
      if (node.fixed[i] == kFree) continue;
      const int j = place(i, node.fixed[i]);
      const double c = cost_(i, j);
      cost_.row(i).setConstant(kInfinity);
      cost_(i, j) = c;
    }
  }

  /// False where there is no matching of finite cost.
  bool solve(Matching& out) {
    const int columns = shared_ + rows_;
    row_of_.assign(columns, -1);
    u_.assign(rows_, 0.0);
    v_.assign(columns, 0.0);
    for (int i = 0; i < rows_; ++i) {
      if (!augment(i)) return false;
    }
    out.column.assign(rows_, -1);
    out.cost = 0.0;
    for (int j = 0; j < columns; ++j) {
      if (row_of_[j] < 0) continue;
      out.cost += cost_(row_of_[j], j);
      if (j < shared_) out.column[row_of_[j]] = j;
    }
    return true;
  }

 private:
  int place(int row, int column) const { return column < 0 ? shared_ + row : column; }

  /// Gives row `i` a column, moving others along the shortest path in reduced costs.
  bool augment(int i) {
    const int columns = shared_ + rows_;
    std::vector<double> distance(columns, kInfinity);
    std::vector<int> from(columns, -1);
    std::vector<char> done(columns, 0);
    int row = i, end = -1, last = -1;
    double length = 0.0;
    while (end < 0) {
      int next = -1;
      for (int j = 0; j < columns; ++j) {
        if (done[j]) continue;
        const double d = length + cost_(row, j) - u_[row] - v_[j];
        if (d < distance[j]) {
          distance[j] = d;
          from[j] = last;
        }
        if (distance[j] < kInfinity && (next < 0 || distance[j] < distance[next])) next = j;
      }
      if (next < 0) return false;
      done[next] = 1;
      length = distance[next];
      last = next;
      if (row_of_[next] < 0) {
        end = next;
      } else {
        row = row_of_[next];
      }
    }
    u_[i] += length;
    for (int j = 0; j < columns; ++j) {
      if (!done[j] || j == end) continue;
      v_[j] -= length - distance[j];
      u_[row_of_[j]] += length - distance[j];
    }
    for (int j = end; j >= 0; j = from[j]) row_of_[j] = from[j] < 0 ? i : row_of_[from[j]];
    return true;
  }

  int rows_, shared_;
  Eigen::MatrixXd cost_;
  std::vector<int> row_of_;
  std::vector<double> u_, v_;  // dual variables of rows and columns
};

}  // namespace

Matching best_matching(const MatchingProblem& problem) {
  return k_best_matchings(problem, 1, 0.0).front();
}

// Murty: the best of a node splits it, by its first r rows kept and the next one forbidden.
std::vector<Matching> k_best_matchings(const MatchingProblem& problem, int k, double margin) {
  check(problem);
  const int rows = static_cast<int>(problem.unmatched.size());
  std::vector<Node> open(1);
  open[0].fixed.assign(rows, kFree);
  Solver(problem, open[0]).solve(open[0].best);
  std::vector<Matching> found;
  while (!open.empty() && static_cast<int>(found.size()) < k) {
    const auto least = std::min_element(open.begin(), open.end(), [](const Node& a, const Node& b) {
      return a.best.cost < b.best.cost;
    });
    const Node node = std::move(*least);
    open.erase(least);
    found.push_back(node.best);
    if (static_cast<int>(found.size()) == k) break;
    const double limit = found.front().cost + margin;
    Node child = node;
    for (int i = 0; i < rows; ++i) {
      if (node.fixed[i] != kFree) continue;
      child.forbidden.emplace_back(i, node.best.column[i]);
      const bool possible = Solver(problem, child).solve(child.best);
      if (possible && child.best.cost <= limit) open.push_back(child);
      child.forbidden.pop_back();
      child.fixed[i] = node.best.column[i];
    }
  }
  return found;
}

}  // namespace hybrid
