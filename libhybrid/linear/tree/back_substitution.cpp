// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/back_substitution.h"

#include <algorithm>
#include <vector>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/kernels/kernels.h"
#include "libhybrid/linear/tree/clique_charts.h"

namespace hybrid {
namespace {

/// Of what new steps bring, the share that it may cost that parts of the tree stay.
constexpr double kShareForRest = 0.5;

/// One solution for the steps, from the top of the tree down to where they matter.
class BackSubstitution {
 public:
  BackSubstitution(const TreeParts& tree, Charts* charts, double threshold, const Bend& bend)
      : system_(tree.system),
        cliques_(tree.cliques),
        pending_(tree.pending),
        charts_(charts),
        threshold_(threshold),
        bend_(bend) {}
  /// Resets the marks of the solution, finished or interrupted.
  ~BackSubstitution() {
    if (!began_) return;
    for (int c : cliques_.fresh()) cliques_[c].unsolved = false;
    for (int c : cliques_.unsolved()) cliques_[c].unsolved = false;
    for (int c : visited_) cliques_[c].visit = TreeClique::Visit::kNone;
  }

  /// Returns whether it was worth it.
  bool solve() {
    const double gain = gain_of_all();
    if (gain <= bend_.whole) return false;
    began_ = true;
    may_rise_ = kShareForRest * gain;
    // All above a new clique is new.
    for (int c : cliques_.fresh()) {
      cliques_[c].unsolved = true;
      if (cliques_[c].parent < 0) stack_.push_back(c);
    }
    // What is below a root that is to be solved comes after it.
    for (int c : cliques_.unsolved()) {
      if (cliques_[c].parent < 0) stack_.push_back(c);
    }
    propagate();
    for (int c : cliques_.unsolved()) {
      if (!cliques_[c].unsolved) continue;
      stack_.push_back(c);
      propagate();
    }
    return true;
  }

 private:
  /// By how much the linearised objective falls where all that is to be solved is, if all below
  /// follows.
  double gain_of_all() {
    double gain = 0.0;
    std::vector<double> by_pending;
    for (const std::vector<int>* cliques : {&cliques_.fresh(), &cliques_.unsolved()}) {
      for (int c : *cliques) {
        see(cliques_[c]);
        gain += prepare(cliques_[c], view_.data());
        pending_.add_rows(cliques_[c], left_.data(), by_pending);
      }
    }
    for (double row : by_pending) gain += 0.5 * row * row;
    return gain;
  }

  /// Solves cliques on the stack and below. Where that gains no more than the threshold a clique
  /// keeps its steps, and what is below is visited all the same: the change above may matter there.
  /// But before anything is solved below it, it is solved itself. Else its error, worth little
  /// there, would be a bend of all that hangs on it: a chain of a kilometre would swing to and fro.
  void propagate() {
    while (!stack_.empty()) {
      const int c = stack_.back();
      stack_.pop_back();
      TreeClique& clique = cliques_[c];
      if (clique.visit == TreeClique::Visit::kSolved || is_left(c)) continue;
      const bool worth = prepare(clique, clique.seen()) > threshold_ || clique.pulled >= 0;
      if (worth && solve_kept_ancestors(c)) {
        clique.unsolved = true;  // what it sees next is not compared with what it has seen now
        continue;
      }
      if (worth && follow_.found) {
        std::copy(follow_.motion.in_all.begin(), follow_.motion.in_all.end(), clique.motion());
        std::copy(follow_.view.begin(), follow_.view.end(), clique.seen());
        prepare(clique, clique.seen());
      }
      if (worth) solve_prepared(clique);
      if (clique.visit == TreeClique::Visit::kNone) visited_.push_back(c);
      clique.visit = worth ? TreeClique::Visit::kSolved : TreeClique::Visit::kKept;
      clique.unsolved = false;
      stack_.insert(stack_.end(), clique.children.begin(), clique.children.end());
    }
  }

  /// Whether a clique and all below it stay as they are, moved with their separator where they may.
  /// Otherwise it has noted what it sees. Where pending rows pull, which the bounds of what staying
  /// costs do not know, a clique stays only where nothing has changed.
  bool is_left(int c) {
    TreeClique& clique = cliques_[c];
    see(clique);
    follow_.found = false;
    const bool is_pulled = clique.pulled >= 0;
    const bool is_as_before = !clique.unsolved && clique.visit == TreeClique::Visit::kNone;
    const bool stays =
        is_pulled
            ? std::equal(view_.begin(), view_.end(), clique.seen())
            : is_as_before && may_bend(clique, view_, [&] { return rise_of_leaving(c, nullptr); });
    if (is_as_before && stays) return true;
    follow_.found = charts_ != nullptr && (is_as_before || is_pulled) && follow(clique);
    if (follow_.found && !is_pulled && may_bend(clique, follow_.view, [&] {
          return rise_of_leaving(c, &follow_.motion.newest);
        })) {
      move(c);
      return true;
    }
    cliques_.save_seen(c);
    std::copy(view_.begin(), view_.end(), clique.seen());
    return false;
  }

  /// Solves the ancestors of a clique that were visited and kept their steps, from the top, and
  /// puts what is below them, the clique too, on the stack once more. Returns whether there were
  /// any.
  bool solve_kept_ancestors(int c) {
    std::vector<int> kept;
    for (int a = cliques_[c].parent; a >= 0 && cliques_[a].visit == TreeClique::Visit::kKept;
         a = cliques_[a].parent) {
      kept.push_back(a);
    }
    for (auto a = kept.rbegin(); a != kept.rend(); ++a) {
      TreeClique& clique = cliques_[*a];
      see(clique);
      cliques_.save_seen(*a);
      std::copy(view_.begin(), view_.end(), clique.seen());
      prepare(clique, clique.seen());
      solve_prepared(clique);
      clique.visit = TreeClique::Visit::kSolved;
      stack_.insert(stack_.end(), clique.children.begin(), clique.children.end());
    }
    return !kept.empty();
  }

  /// The steps of a clique's separator as it is now: as its chart sees it, or those of the
  /// variables.
  void see(const TreeClique& clique) {
    view_.resize(clique.separator_dim());
    if (charts_ != nullptr) {
      charts_->see(clique.variables, clique.frontals, clique.chart(), view_.data());
    } else {
      system_.copy_deltas(clique.variables, clique.frontals, clique.variables.size(), view_.data());
    }
  }

  /// Finds the motion by which a clique can follow its separator, and what it sees then.
  bool follow(const TreeClique& clique) {
    if (!find_motion(clique, *charts_, follow_.motion)) return false;
    follow_.view.resize(clique.separator_dim());
    charts_->see(clique.variables, clique.frontals,
                 {follow_.motion.in_all.data(), clique.chart().points}, follow_.view.data());
    return true;
  }

  /// Moves a clique and all below it by the motion that was found.
  void move(int c) {
    for (std::vector<int> left{c}; !left.empty();) {
      const int b = left.back();
      left.pop_back();
      TreeClique& clique = cliques_[b];
      cliques_.save_motion(b);
      charts_->add(follow_.motion.newest, clique.motion());
      charts_->move(clique.variables, clique.frontals, follow_.motion.newest);
      left.insert(left.end(), clique.children.begin(), clique.children.end());
    }
    const TreeClique& clique = cliques_[c];
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      system_.note_moved(clique.variables[k]);  // past what has moved
    }
  }

  /// By how much the objective may rise, at most, where all below a clique stays though its
  /// separator has come to what is seen: by the information that the factors below have of it.
  double strain(const TreeClique& clique, const std::vector<double>& view) const {
    const double* scale = clique.scales();
    const double* seen = clique.seen();
    const double* now = view.data();
    double strain = 0.0;
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k, ++scale) {
      const int dim = system_.dim(clique.variables[k]);
      double square = 0.0;
      for (int i = 0; i < dim; ++i, ++seen, ++now) square += (*now - *seen) * (*now - *seen);
      strain += *scale * square;
    }
    return 0.5 * strain;
  }

  /// Whether a clique and all below it may be left while it sees its separator as given: what that
  /// costs at most is little for so many factors, and what it costs, `rise()`, is no more than is
  /// left for it of what the new steps bring. Without the latter, a part of 100,000 factors would
  /// stay at a cost of a hundred beside steps that bring one.
  template <class Rise>
  bool may_bend(const TreeClique& clique, const std::vector<double>& view, const Rise& rise) {
    const double most = strain(clique, view);
    if (most <= std::min(bend_.whole, threshold_)) return true;
    if (most > bend_.whole + bend_.per_factor * clique.factors_below) return false;
    const double cost = most <= may_rise_ && most <= bend_.whole ? most : rise();
    if (cost > may_rise_) return false;
    may_rise_ -= cost;
    return true;
  }

  /// By how much the linearised objective rises where a clique and all below it stay, or are moved
  /// as a whole: the sum over the cliques that see something else than they have seen, from level
  /// to level of the tree. Where a level adds less than half of the one above, those below count as
  /// a geometric series. Ends at more than may be spent.
  double rise_of_leaving(int c, const MapMotion* motion) {
    double rise = 0.0, above = 0.0;
    std::vector<int> level{c}, below;
    while (!level.empty() && rise <= may_rise_) {
      double own = 0.0;
      below.clear();
      for (std::size_t k = 0; k < level.size() && rise + own <= may_rise_; ++k) {
        const TreeClique& clique = cliques_[level[k]];
        see_as_left(clique, cliques_[c], motion);
        const double most = strain(clique, left_view_);
        if (most <= bend_.whole) {
          own += most;
          continue;
        }
        own += prepare(clique, left_view_.data());
        below.insert(below.end(), clique.children.begin(), clique.children.end());
      }
      rise += own;
      if (2.0 * own < above) {
        rise += own * own / (above - own);
        break;
      }
      above = own;
      level.swap(below);
    }
    return rise;
  }

  /// What a clique in the subtree below `top`, itself included, sees where all of it stays, or is
  /// moved as a whole: what it has seen, but for the separator of `top`, which is where it is.
  void see_as_left(const TreeClique& clique, const TreeClique& top, const MapMotion* motion) {
    const auto first = top.variables.begin() + top.frontals;
    left_view_.resize(clique.separator_dim());
    Chart chart = clique.chart();
    MapMotion moved;
    if (motion != nullptr) {
      std::copy_n(chart.motion, moved.size(), moved.begin());
      charts_->add(*motion, moved.data());
      chart.motion = moved.data();
    }
    if (charts_ != nullptr) {
      charts_->see(clique.variables, clique.frontals, chart, left_view_.data());
    } else {
      system_.copy_deltas(clique.variables, clique.frontals, clique.variables.size(),
                          left_view_.data());
    }
    std::size_t at = 0;
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      const int dim = system_.dim(clique.variables[k]);
      if (std::find(first, top.variables.end(), clique.variables[k]) == top.variables.end()) {
        std::copy_n(clique.seen() + at, dim, left_view_.data() + at);
      }
      at += dim;
    }
  }

  /// Gathers the steps of a clique's variables and its right-hand side given the steps that it sees
  /// of its separator. Returns by how much solving for the frontals lowers the linearised
  /// objective.
  double prepare(const TreeClique& clique, const double* seen) {
    note_work(2.0 * clique.order * clique.frontal_dim);
    const int n = clique.order;
    const int f = clique.frontal_dim;
    const int s = clique.separator_dim();
    step_.resize(n);
    std::copy_n(seen, s, system_.copy_deltas(clique.variables, 0, clique.frontals, step_.data()));
    rhs_.resize(f);
    left_.resize(f);
    const auto dot = kernels().dot;
    const double* pull = pending_.pull_on(clique);
    double gain = 0.0;
    for (int j = 0; j < f; ++j) {
      const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
      rhs_[j] = column[n - 1] + dot(column + f, step_.data() + f, s);
      if (pull != nullptr) rhs_[j] += pull[j];
      left_[j] = rhs_[j] + dot(column + j, step_.data() + j, f - j);
      gain += left_[j] * left_[j];
    }
    return 0.5 * gain;
  }

  /// Solves for the frontals of the clique that was prepared last.
  void solve_prepared(const TreeClique& clique) {
    const int n = clique.order;
    const int f = clique.frontal_dim;
    const auto dot = kernels().dot;
    for (int j = f - 1; j >= 0; --j) {
      const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
      step_[j] = -(rhs_[j] + dot(column + j + 1, step_.data() + j + 1, f - 1 - j)) / column[j];
    }
    const double* from = step_.data();
    for (int k = 0; k < clique.frontals; ++k) {
      const int v = clique.variables[k];
      std::copy_n(from, system_.dim(v), system_.edit_delta(v));
      system_.note_moved(v);
      from += system_.dim(v);
    }
    if (charts_ != nullptr) {
      charts_->place(clique.variables, clique.frontals, clique.chart(), step_.data());
    }
  }

  LinearSystem& system_;
  Cliques& cliques_;
  const PendingRows& pending_;
  Charts* const charts_;
  const double threshold_;
  const Bend bend_;
  bool began_ = false;
  double may_rise_ = 0.0;                  // by how much the objective may still rise
  std::vector<int> stack_;                 // cliques to be solved
  std::vector<int> visited_;               // cliques
  std::vector<double> step_, rhs_, left_;  // of the clique that was prepared last
  std::vector<double> view_;               // of the separator that was seen last
  std::vector<double> left_view_;          // the same, of one that may be left
  struct {
    bool found = false;
    CliqueMotion motion;
    std::vector<double> view;
  } follow_;
};

}  // namespace

void back_substitute(const TreeParts& tree, Charts* charts, double threshold, const Bend& bend) {
  if (BackSubstitution(tree, charts, threshold, bend).solve()) tree.cliques.note_solved();
}

}  // namespace hybrid
