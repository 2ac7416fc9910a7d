// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/elimination.h"

#include <algorithm>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/detail/scatter.h"
#include "libhybrid/linear/elimination.h"
#include "libhybrid/linear/tree/clique_charts.h"

namespace hybrid {
namespace {

/// What the factor of a leaf may leave for its separator, as a share of what it has of it:
/// rounding.
constexpr double kNothing = 1e-9;

/// One elimination of the part of the tree that changes of the system touch.
class TreeElimination {
 public:
  TreeElimination(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace)
      : tree_(tree),
        system_(tree.system),
        cliques_(tree.cliques),
        charts_(charts),
        places_(workspace.places),
        front_(workspace.front) {
    places_.resize(system_.variable_count());
  }

  ~TreeElimination() {
    for (int v : affected_) places_[v].local = -1;
    for (int v : system_.changes(LinearSystem::kRemovedVariables)) places_[v].local = -1;
  }

  /// See hybrid::eliminate_leaf.
  int eliminate_leaf(int variable, int factor) {
    const std::vector<int>& members = system_.factor(factor).variables;
    const int parent = clique_with_others(variable, members);
    if (parent < 0) return -1;
    const bool is_held = charts_ != nullptr && charts_->is_held(variable);
    if (is_held && cliques_[parent].free) return -1;
    SymbolicClique symbolic{{0}, {}, {0}, -1};
    affected_ = {variable};
    for (int v : members) {
      if (v == variable) continue;
      symbolic.separators.push_back(static_cast<int>(affected_.size()));
      affected_.push_back(v);
    }
    for (int v : affected_) problem_.dims.push_back(system_.dim(v));
    edges_ = {factor};
    const std::size_t born = cliques_.born();
    const int id = make_clique(symbolic, {});
    if (id < 0 || !lifted_variables_.empty() || leaves_something(cliques_[id])) {
      cliques_.refuse(born);
      return -1;
    }
    TreeClique& leaf = cliques_[id];
    const auto separator = static_cast<std::size_t>(leaf.order - leaf.frontal_dim);
    std::fill_n(const_cast<double*>(leaf.update(0)), packed_size(separator), 0.0);
    leaf.factors = {factor};
    leaf.factors_below = 1;
    leaf.free = charts_ != nullptr && !is_held;
    system_.set_clique(variable, id);
    system_.set_factor_clique(factor, id);
    cliques_.add_leaf(id, parent);
    return id;
  }

  EliminationReport eliminate(const LastVariables& last, const IsDetermined& is_determined) {
    EliminationReport report;
    const std::size_t born = cliques_.born();
    tree_.touch_waiting();
    cliques_.detach(system_.touched());
    gather_problem();
    const std::vector<SymbolicClique> symbolic =
        eliminate_symbolically(problem_, constrained_order(problem_, groups(last)));
    std::vector<std::vector<int>> children(symbolic.size());
    std::vector<int> made;
    for (std::size_t s = 0; s < symbolic.size(); ++s) {
      const int id = make_clique(symbolic[s], children[s]);
      if (id < 0) {
        report.singular = -1 - id;
        break;
      }
      made.push_back(id);
      if (symbolic[s].parent >= 0) children[symbolic[s].parent].push_back(id);
    }
    if (report.singular < 0 && !lifted_variables_.empty() &&
        !(is_determined && is_determined(lifted_variables_))) {
      report.singular = lifted_variables_.front();
    }
    if (report.singular >= 0) {
      cliques_.refuse(born);
      return report;
    }
    report.variables = problem_.count;
    report.cliques = static_cast<int>(made.size());
    link(symbolic, made);
    cliques_.replace_detached(made);
    tree_.pending.retire(work_);
    if (charts_ == nullptr) return report;
    for (int v : affected_) std::fill_n(system_.edit_delta(v), system_.dim(v), 0.0);
    return report;
  }

 private:
  /// A clique that has all but one of some variables; -1 if there is none.
  int clique_with_others(int variable, const std::vector<int>& members) const {
    for (int v : members) {
      const int c = system_.clique_of(v);
      if (c < 0) continue;
      const std::vector<int>& all = cliques_[c].variables;
      const auto has = [&](int other) {
        return other == variable || std::find(all.begin(), all.end(), other) != all.end();
      };
      if (std::all_of(members.begin(), members.end(), has)) return c;
    }
    return -1;
  }

  /// Whether a clique of one factor leaves more than rounding for its separator.
  static bool leaves_something(const TreeClique& clique) {
    const int size = clique.order - clique.frontal_dim;
    double left = 0.0, had = 0.0;
    for (int k = 0; k + 1 < size; ++k) left += clique.update(k)[k];
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      had += clique.scales()[k - clique.frontals];
    }
    return !(left <= kNothing * had);
  }

  /// The elimination problem of the detached part: its variables, its factors, and the separators
  /// of the subtrees below it (orphans).
  void gather_problem() {
    for (int v : system_.changes(LinearSystem::kRemovedVariables)) places_[v].local = -2;
    const auto take = [&](int v) {
      if (places_[v].local != -1) return;
      affected_.push_back(v);
      places_[v].local = static_cast<int>(affected_.size()) - 1;
    };
    for (int c : cliques_.detached()) {
      for (int k = 0; k < cliques_[c].frontals; ++k) take(cliques_[c].variables[k]);
    }
    for (int v : system_.changes(LinearSystem::kNewVariables)) take(v);

    problem_.count = static_cast<int>(affected_.size());
    for (int v : affected_) problem_.dims.push_back(system_.dim(v));
    const auto add_edge = [&](const std::vector<int>& variables, int first, int edge) {
      for (std::size_t k = first; k < variables.size(); ++k) {
        problem_.members.push_back(places_[variables[k]].local);
      }
      problem_.close_edge();
      edges_.push_back(edge);
    };
    tree_.visit_factors([&](int f) { add_edge(system_.factor(f).variables, 0, f); });
    for (int o : cliques_.orphans()) add_edge(cliques_[o].variables, cliques_[o].frontals, -1 - o);
  }

  /// Groups the variables of the problem, without gaps, in the order in which they are eliminated.
  std::vector<int> groups(const LastVariables& last) const {
    std::vector<int> groups(affected_.size(), 0);
    const auto set = [&](const std::vector<int>& variables, int group) {
      for (int v : variables) {
        if (places_[v].local >= 0) groups[places_[v].local] = group;
      }
    };
    set(last.last, 1);
    set(last.behind, 2);
    for (int gap : {1, 0}) {
      if (std::find(groups.begin(), groups.end(), gap) != groups.end()) continue;
      for (int& group : groups) group -= group > gap ? 1 : 0;
    }
    return groups;
  }

  /// Eliminates one clique whose children among the new cliques are given. Returns its number, or
  /// -1 - v if the pivot of variable v is not finite.
  int make_clique(const SymbolicClique& symbolic, const std::vector<int>& children) {
    const int id = cliques_.add();
    TreeClique& clique = cliques_[id];
    clique.frontals = static_cast<int>(symbolic.frontals.size());
    clique.frontal_dim = 0;
    for (int k : symbolic.frontals) {
      clique.variables.push_back(affected_[k]);
      clique.frontal_dim += problem_.dims[k];
    }
    clique.order = clique.frontal_dim + 1;
    for (int k : symbolic.separators) {
      clique.variables.push_back(affected_[k]);
      clique.order += problem_.dims[k];
    }
    assemble(clique, symbolic, children);
    const int failed = factorize(clique);
    if (failed >= 0) return -1 - failed;
    if (charts_ == nullptr) hold_lifted(clique);  // steps begin at zero otherwise
    const int n = clique.order;
    const int f = clique.frontal_dim;
    const std::size_t separators = clique.variables.size() - clique.frontals;
    clique.charted = charts_ != nullptr;
    clique.storage =
        Block(static_cast<std::size_t>(n) * f + packed_size(n - f) + separators +
              clique.seen_size() + (clique.charted ? charts_->size(clique.variables) : 0));
    double* to = clique.columns();
    for (int j = 0; j < f; ++j, to += n) std::copy_n(front_.column(j) + j, n - j, to + j);
    for (int j = f; j < n; ++j) to = std::copy_n(front_.column(j) + j, n - j, to);
    for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
      *to++ = places_[clique.variables[k]].scale;
    }
    std::fill_n(clique.seen(), clique.seen_size(), 0.0);
    if (clique.charted) charts_->start(clique.variables, clique.seen() + clique.seen_size());
    return id;
  }

  /// Sums the factors and the Schur complements of the children into the front.
  void assemble(const TreeClique& clique, const SymbolicClique& symbolic,
                const std::vector<int>& children) {
    int row = 0;
    for (int v : clique.variables) {
      places_[v].offset = row;
      places_[v].scale = 0.0;
      row += system_.dim(v);
    }
    front_.reset(clique.order);
    for (int edge : symbolic.edges) {
      const int f = edges_[edge];
      if (f >= 0) {
        assemble_factor(f);
        continue;
      }
      const TreeClique& orphan = cliques_[-1 - f];
      Chart own = orphan.chart();
      CliqueMotion motion;
      if (charts_ != nullptr && find_motion(orphan, *charts_, motion)) {
        own.motion = motion.in_all.data();
      }
      assemble_child(orphan, charts_ == nullptr ? orphan.update(0)
                                                : carrier_.carry(system_, *charts_, orphan, own));
    }
    for (int c : children) assemble_child(cliques_[c], cliques_[c].update(0));
  }

  void assemble_factor(int f) {
    const LinearSystem::Factor& factor = system_.factor(f);
    const double* hessian = system_.hessian(f);
    int row = 0;
    for (int v : factor.variables) {
      for (int k = 0; k < system_.dim(v); ++k, ++row) {
        places_[v].scale += packed_column(hessian, factor.order, row)[row];
      }
    }
    scatter_packed(factor.variables, 0, hessian, factor.order);
  }

  void assemble_child(const TreeClique& child, const double* update) {
    const double* scales = child.scales();
    for (std::size_t k = child.frontals; k < child.variables.size(); ++k) {
      places_[child.variables[k]].scale += *scales++;
    }
    scatter_packed(child.variables, child.frontals, update, child.separator_dim() + 1);
  }

  /// Adds the Hessian of variables from number `first` on.
  void scatter_packed(const std::vector<int>& variables, int first, const double* packed,
                      int order) {
    std::vector<Run> runs;
    int from = 0;
    for (std::size_t k = first; k < variables.size(); ++k) {
      append_run(runs, from, places_[variables[k]].offset, system_.dim(variables[k]));
      from += system_.dim(variables[k]);
    }
    append_run(runs, from, front_.order() - 1, 1);
    scatter(
        runs, [&](int c) { return packed_column(packed, order, c); }, front_);
  }

  /// Eliminates the frontals in the front, with lifted pivots where these are lost; least pivots
  /// are 1 for variables in no factor. Returns -1, or a variable whose pivot is not finite.
  int factorize(const TreeClique& clique) {
    const int f = clique.frontal_dim;
    std::vector<int> variable_of;  // by column
    least_.clear();
    for (int k = 0; k < clique.frontals; ++k) {
      const int v = clique.variables[k];
      const double scale = places_[v].scale;
      least_.insert(least_.end(), system_.dim(v), scale > 0.0 ? kPivotShare * scale : 1.0);
      variable_of.insert(variable_of.end(), system_.dim(v), v);
    }
    lifted_.clear();
    diagonal_.resize(f);
    for (int j = 0; j < f; ++j) diagonal_[j] = front_.column(j)[j];
    const int failed = front_.factorize(f, least_.data(), lifted_);
    const double work = double(f) * clique.order * clique.order;
    note_work(work);
    work_ += work;
    if (failed >= 0) return variable_of[failed];
    for (int column : lifted_) lifted_variables_.push_back(variable_of[column]);
    return -1;
  }

  /// Lets lifted pivots hold the present steps: what was added to a pivot pulls to them, not to
  /// zero. So the steps end where they would without it, after as many eliminations as that takes.
  void hold_lifted(const TreeClique& clique) {
    if (lifted_.empty()) return;
    const int n = clique.order;
    const int f = clique.frontal_dim;
    std::vector<double> steps(f);
    system_.copy_deltas(clique.variables, 0, clique.frontals, steps.data());
    std::vector<double> pull(n - 1, 0.0);  // on the right-hand side, before elimination
    for (int j : lifted_) {
      double pivot = diagonal_[j];
      for (int k = 0; k < j; ++k) pivot -= front_.column(k)[j] * front_.column(k)[j];
      pull[j] = -(least_[j] - pivot) * steps[j];
    }
    for (int j = 0; j < f; ++j) {
      const double* column = front_.column(j);
      const double x = pull[j] / column[j];
      for (int i = j + 1; i < n - 1; ++i) pull[i] -= column[i] * x;
      front_.column(j)[n - 1] += x;
    }
    for (int i = f; i < n - 1; ++i) front_.column(i)[n - 1] += pull[i];
  }

  /// Links new cliques, children before their parents, to each other, to their factors and to the
  /// orphans.
  void link(const std::vector<SymbolicClique>& symbolic, const std::vector<int>& made) {
    for (std::size_t s = 0; s < made.size(); ++s) {
      TreeClique& clique = cliques_[made[s]];
      for (int k = 0; k < clique.frontals; ++k) system_.set_clique(clique.variables[k], made[s]);
      if (symbolic[s].parent >= 0) {
        clique.parent = made[symbolic[s].parent];
        cliques_[clique.parent].children.push_back(made[s]);
      }
      for (int edge : symbolic[s].edges) {
        const int f = edges_[edge];
        if (f >= 0) {
          system_.set_factor_clique(f, made[s]);
          clique.factors.push_back(f);
        } else {
          cliques_[-1 - f].parent = made[s];
          clique.children.push_back(-1 - f);
        }
      }
      clique.factors_below = static_cast<int>(clique.factors.size());
      for (int child : clique.children) clique.factors_below += cliques_[child].factors_below;
      clique.free =  // to move with its separator, as its children are
          charts_ != nullptr &&
          std::none_of(clique.variables.begin(), clique.variables.begin() + clique.frontals,
                       [&](int v) { return charts_->is_held(v); }) &&
          std::all_of(clique.children.begin(), clique.children.end(),
                      [&](int child) { return cliques_[child].free; });
    }
  }

  const TreeParts tree_;
  LinearSystem& system_;
  Cliques& cliques_;
  const Charts* const charts_;
  double work_ = 0.0;  // multiplications
  std::vector<EliminationWorkspace::Place>& places_;
  Front& front_;
  HessianCarrier carrier_;
  std::vector<int> affected_;  // variables
  Hypergraph problem_;
  std::vector<int> edges_;        // of the problem: its factor, or -1 - orphan
  std::vector<double> least_;     // least pivots of the front
  std::vector<double> diagonal_;  // of its frontals, before elimination
  std::vector<int> lifted_;       // columns of the front
  std::vector<int> lifted_variables_;
};

}  // namespace

EliminationReport eliminate(const TreeParts& tree, const Charts* charts,
                            EliminationWorkspace& workspace, const LastVariables& last,
                            const IsDetermined& is_determined) {
  const EliminationReport report =
      TreeElimination(tree, charts, workspace).eliminate(last, is_determined);
  if (report.singular < 0) tree.system.note_eliminated();
  return report;
}

int eliminate_leaf(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace,
                   int variable, int factor) {
  return TreeElimination(tree, charts, workspace).eliminate_leaf(variable, factor);
}

}  // namespace hybrid
