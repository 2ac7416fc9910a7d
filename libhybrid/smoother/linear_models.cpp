// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/linear_models.h"

#include "libhybrid/core/paced_task.h"

namespace hybrid {

void LinearModels::enter(int t, const Values& values) {
  Term& term = terms_.edit(t);
  if (!belongs_in_tree(term.component)) {
    weak_.left_out = weak_.left_out || term.component.factor != nullptr;
    return;
  }
  term.tree_factor = tree_.add_factor(active_slots(term), point_size(*term.component.factor));
  own(term.tree_factor, t);
  linearize(term, values, tree_);
}

/// Notes whose factor of the tree it is.
void LinearModels::own(int factor, int t) {
  if (factor >= static_cast<int>(term_of_factor_.size())) term_of_factor_.resize(factor + 1, -1);
  term_of_factor_[factor] = t;
}

void LinearModels::leave(int t) {
  if (terms_[t].tree_factor >= 0) {
    lost_.push_back({terms_[t].component.factor, active_slots(terms_[t])});
  }
  take_out(t);
}

void LinearModels::take_out(int t) {
  Term& term = terms_.edit(t);
  if (term.tree_factor >= 0) tree_.remove_factor(term.tree_factor);
  for (int f : term.pulls) tree_.remove_factor(f);
  term.tree_factor = -1;
  term.pulls.clear();
}

void LinearModels::choose(int t, const Component& component, const Values& values) {
  Term& term = terms_.edit(t);
  const std::vector<int> before = term.tree_factor >= 0 ? active_slots(term) : std::vector<int>{};
  const Component previous = term.component;
  term.choose(component);
  term.cost = evaluate(term, values);
  const bool same_place =
      term.tree_factor >= 0 && belongs_in_tree(component) && active_slots(term) == before;
  if (same_place && component.index == previous.index) return;
  if (term.tree_factor >= 0) lost_.push_back({previous.factor, before});
  if (same_place) {
    linearize(term, values, tree_);
    return;
  }
  take_out(t);
  enter(t, values);
}

void LinearModels::enter_pulls(const Values& values) {
  for (int t = 0; t < terms_.count(); ++t) {
    if (!terms_[t].alive || terms_[t].component.factor == nullptr || terms_[t].tree_factor >= 0 ||
        !terms_[t].pulls.empty())
      continue;
    Term& term = terms_.edit(t);
    for (int slot : active_slots(term)) {
      term.pulls.push_back(tree_.add_factor({slot}));
      own(term.pulls.back(), t);
    }
    linearize(term, values, tree_);
  }
}

void LinearModels::couple_weak(const Values& values) {
  weak_.coupled = true;
  for (int t = 0; t < terms_.count(); ++t) {
    const Term& term = terms_[t];
    if (!term.alive || term.component.factor == nullptr || term.tree_factor >= 0) continue;
    leave(t);
    enter(t, values);
  }
}

bool LinearModels::is_whole() const {
  if (!weak_.left_out) return true;
  for (int t = 0; t < terms_.count(); ++t) {
    const Term& term = terms_[t];
    if (term.alive && term.component.factor != nullptr && term.tree_factor < 0) return false;
  }
  return true;
}

int LinearModels::add_penalty(int slot) {
  const int f = tree_.add_factor({slot});
  own(f, -1);
  return f;
}

int LinearModels::make_again(const std::vector<int>& terms) {
  int made = 0;
  for (int t : terms) {
    if (t >= terms_.count() || !terms_[t].alive) continue;
    if (terms_[t].tree_factor >= 0) tree_.assemble_again(terms_[t].tree_factor);
    for (int f : terms_[t].pulls) tree_.assemble_again(f);
    ++made;
  }
  return made;
}

void LinearModels::linearize_eliminated(const Values& values) {
  int last = -1;  // the pulls of a term are neighbours
  for (int f : tree_.factors_to_assemble()) {
    const int t = f < static_cast<int>(term_of_factor_.size()) ? term_of_factor_[f] : -1;
    if (t < 0 || t == last) continue;
    linearize(terms_.edit(t), values, tree_);
    note_work(kWorkOfTerm);
    last = t;
  }
}

void LinearModels::commit() noexcept {
  tree_.commit();
  terms_.commit();
  lost_.clear();
}

void LinearModels::roll_back(const Mark& mark) noexcept {
  tree_.roll_back(mark.tree);
  terms_.roll_back(mark.terms);
  weak_ = mark.weak;
  lost_.erase(lost_.begin() + static_cast<std::ptrdiff_t>(mark.lost), lost_.end());
}

}  // namespace hybrid
