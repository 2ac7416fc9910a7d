// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/cliques.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

namespace hybrid {

std::vector<int> Cliques::top_down() const {
  std::vector<int> cliques;
  cliques.reserve(count());
  for (int c = 0; c < static_cast<int>(cliques_.size()); ++c) {
    const TreeClique& clique = cliques_[c];
    if (clique.parent < 0 && !clique.variables.empty() && !clique.detached) cliques.push_back(c);
  }
  for (std::size_t k = 0; k < cliques.size(); ++k) {
    const TreeClique& clique = cliques_[cliques[k]];
    cliques.insert(cliques.end(), clique.children.begin(), clique.children.end());
  }
  return cliques;
}

std::vector<int> Cliques::paths_of(const std::vector<int>& variables,
                                   const LinearSystem& system) const {
  // Each path ends where it meets an earlier one; later paths come first.
  std::vector<std::vector<int>> paths;
  std::unordered_set<int> seen;
  for (int v : variables) {
    paths.emplace_back();
    for (int c = system.clique_of(v); c >= 0 && seen.insert(c).second; c = cliques_[c].parent) {
      paths.back().push_back(c);
    }
  }
  std::vector<int> all;
  for (auto p = paths.rbegin(); p != paths.rend(); ++p) all.insert(all.end(), p->begin(), p->end());
  return all;
}

std::vector<int> Cliques::order() const {
  std::vector<int> order;
  const std::vector<int> cliques = top_down();
  for (auto c = cliques.rbegin(); c != cliques.rend(); ++c) {
    const auto first = cliques_[*c].variables.begin();
    order.insert(order.end(), first, first + cliques_[*c].frontals);
  }
  return order;
}

std::vector<std::pair<int, int>> Cliques::blocks() const {
  std::vector<std::pair<int, int>> blocks;
  for (const TreeClique& clique : cliques_) {
    if (clique.detached) continue;
    for (int j = 0; j < clique.frontals; ++j) {
      for (std::size_t i = j; i < clique.variables.size(); ++i) {
        blocks.emplace_back(clique.variables[i], clique.variables[j]);
      }
    }
  }
  return blocks;
}

std::size_t Cliques::factor_size() const {
  std::size_t size = 0;
  for (const TreeClique& clique : cliques_) {
    if (clique.variables.empty() || clique.detached) continue;
    const std::size_t f = clique.frontal_dim;
    size += f * (clique.order - 1) - f * (f - 1) / 2;
  }
  return size;
}

double Cliques::log_determinant() const {
  double sum = 0.0;
  for (int c : top_down()) {
    const TreeClique& clique = cliques_[c];
    double own = 0.0;
    for (int j = 0; j < clique.frontal_dim; ++j) {
      own += std::log(clique.columns()[static_cast<std::size_t>(j) * (clique.order + 1)]);
    }
    sum += 2.0 * own;
  }
  return sum;
}

std::size_t Cliques::bytes() const {
  std::size_t bytes = cliques_.capacity() * sizeof(TreeClique);
  for (const TreeClique& clique : cliques_) {
    bytes += clique.storage.bytes() + (clique.children.capacity() + clique.variables.capacity() +
                                       clique.factors.capacity()) *
                                          sizeof(int);
  }
  return bytes;
}

void Cliques::detach(const std::vector<int>& touched) {
  detached_.clear();
  for (int c : touched) {
    for (; c >= 0 && !cliques_[c].detached; c = cliques_[c].parent) {
      detached_.push_back(c);
      cliques_[c].detached = true;
    }
  }
  orphans_.clear();
  for (int c : detached_) {
    for (int child : cliques_[c].children) {
      if (!cliques_[child].detached) orphans_.push_back(child);
    }
  }
}

int Cliques::add() {
  const int c = numbers_.take();
  if (c >= static_cast<int>(cliques_.size())) cliques_.resize(c + 1);
  born_.push_back(c);
  TreeClique& clique = cliques_[c];
  clique.born = clique.saved = clique.saved_motion = saved_.epoch();
  ++count_;
  return c;
}

/// Frees a clique, whose number may then be used again.
void Cliques::free(int c) noexcept {
  TreeClique& clique = cliques_[c];
  clique.storage = {};
  clique.parent = -1;
  for (std::vector<int>* list : {&clique.children, &clique.variables, &clique.factors})
    list->clear();
  clique.frontals = 0;
  clique.detached = clique.unsolved = clique.free = clique.charted = false;
  clique.pulled = -1;
  clique.born = clique.saved = clique.saved_motion = 0;
  numbers_.give(c);
  --count_;
}

void Cliques::replace_detached(const std::vector<int>& made) {
  const auto is_detached = [&](int c) { return cliques_[c].detached; };
  for (std::vector<int>* list : {&fresh_, &unsolved_}) {
    list->erase(std::remove_if(list->begin(), list->end(), is_detached), list->end());
  }
  fresh_.insert(fresh_.end(), made.begin(), made.end());
  for (int c : detached_) {
    cliques_[c].unsolved = false;
    if (cliques_[c].born == saved_.epoch()) {
      free(c);
    } else {
      retired_.push_back(c);
    }
  }
  detached_.clear();
}

void Cliques::add_leaf(int c, int parent) {
  leaves_.emplace_back(c, parent);
  cliques_[c].parent = parent;
  cliques_[parent].children.push_back(c);
  set_unsolved(c);
}

void Cliques::cut_leaves(std::size_t leaves) noexcept {
  for (; leaves_.size() > leaves; leaves_.pop_back()) {
    const auto [c, parent] = leaves_.back();
    std::vector<int>& children = cliques_[parent].children;
    if (!children.empty() && children.back() == c) children.pop_back();
    if (!unsolved_.empty() && unsolved_.back() == c) unsolved_.pop_back();
    cliques_[c].unsolved = false;
  }
}

void Cliques::commit() noexcept {
  for (int c : retired_) free(c);
  numbers_.commit();
  saved_.commit();
  retired_.clear();
  born_.clear();
  leaves_.clear();
}

/// Restores a clique that was replaced.
void Cliques::reinstate(int c, LinearSystem& system) noexcept {
  TreeClique& clique = cliques_[c];
  clique.detached = false;
  for (int k = 0; k < clique.frontals; ++k) system.set_clique(clique.variables[k], c);
  for (int f : clique.factors) system.set_factor_clique(f, c);
  for (int child : clique.children) cliques_[child].parent = c;
}

void Cliques::roll_back(const Mark& mark, LinearSystem& system) noexcept {
  saved_.roll_back(mark.seen,
                   [&](int c) { return c < 0 ? cliques_[~c].motion() : cliques_[c].seen(); });
  cut_leaves(mark.leaves);
  for (std::size_t i = mark.born; i < born_.size(); ++i) {
    if (cliques_[born_[i]].born >= mark.epoch) free(born_[i]);
  }
  for (std::size_t i = mark.retired; i < retired_.size(); ++i) reinstate(retired_[i], system);
  for (int c : detached_) reinstate(c, system);  // by an interrupted elimination
  numbers_.roll_back(mark.numbers);
  for (int c : unsolved_) cliques_[c].unsolved = false;
  fresh_ = mark.fresh;
  unsolved_ = mark.unsolved;
  for (int c : unsolved_) cliques_[c].unsolved = true;
  retired_.resize(mark.retired);
  born_.resize(mark.born);
  detached_.clear();
}

}  // namespace hybrid
