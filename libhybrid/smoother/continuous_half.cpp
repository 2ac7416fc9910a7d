// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/continuous_half.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "libhybrid/smoother/detail/determination.h"
#include "libhybrid/smoother/detail/pose_charts.h"
#include "libhybrid/smoother/places.h"
#include "libhybrid/smoother/terms.h"

namespace hybrid {
namespace {

/// The map of a smoother as the charts of its tree see it. Where variables were is noted before
/// they move.
class MapOf : public MapVariables {
 public:
  MapOf(MapKind kind, const JournaledValues& estimate, const Terms& terms)
      : values_(estimate.get()),
        terms_(terms),
        charts_(make_charts(kind, values_, nullptr, *this)) {}
  MapOf(MapKind kind, JournaledValues& estimate, const Terms& terms, MovedVariables& moved)
      : values_(estimate.get()),
        terms_(terms),
        moved_(&moved),
        charts_(make_charts(kind, values_, &estimate, *this)) {}

  Charts* charts() const { return charts_.get(); }

  bool is_held(int slot) const override {
    const std::vector<int>& own = terms_.of_variable(slot);
    return std::any_of(own.begin(), own.end(),
                       [this](int t) { return terms_[t].alive && terms_[t].holds; });
  }
  void before_change(int slot) const override { moved_->note(slot, values_); }

 private:
  const Values& values_;
  const Terms& terms_;
  MovedVariables* moved_ = nullptr;
  std::unique_ptr<Charts> charts_;
};

/// Of a factor, where its noise is as stated: half for each of its rows, of which it has two or
/// more.
constexpr double kCostByNoise = 1.0;

/// Whether all of some variables are in the cliques of a tree.
bool are_in(const BayesTree& tree, const std::vector<int>& slots) {
  return std::all_of(slots.begin(), slots.end(),
                     [&](int slot) { return tree.system().clique_of(slot) >= 0; });
}

}  // namespace

void ContinuousHalf::add_variable(Key key, const Values& initial) {
  const VariableType type = initial.type(key);
  estimate_.insert(key, type, initial.data(key));
  const int slot = values().slot(key);
  note_map_kind(type);
  models_.tree().add_variable(slot, type.dim);
  models_.terms().reserve_variable(slot);
  if (is_pose(type)) order_.enter_pose(key);
}

/// With the first landmark the steps of poses are along other lines, so that all linear models are
/// made again.
void ContinuousHalf::note_map_kind(VariableType type) {
  if (is_pose(type) && map_kind_.pose == VariableKind::kVector) map_kind_.pose = type.kind;
  const bool is_point = type.kind == VariableKind::kVector && (type.dim == 2 || type.dim == 3);
  if (!is_point || map_kind_.has_points) return;
  map_kind_.has_points = true;
  UpdateReport uncounted;
  renew_all(uncounted);
}

void ContinuousHalf::remove_variable(Key key) {
  models_.tree().remove_variable(values().slot(key));
  estimate_.remove(key);
}

int ContinuousHalf::add_term(Term term) {
  std::vector<const double*> x;
  for (Key key : term.keys()) {
    term.slots.push_back(values().slot(key));
    x.push_back(values().data(term.slots.back()));
  }
  term.holds = term.hybrid != nullptr ? !moves_with_map(map_kind_.pose, *term.hybrid, x.data())
                                      : !moves_with_map(map_kind_.pose, *term.continuous, x.data());
  term.cost = evaluate(term, values());
  const int t = models_.terms().add(std::move(term));
  const Term& added = terms()[t];
  costs_.enter(added);
  if (added.hybrid == nullptr) {
    models_.enter(t, values());
  } else {
    costs_.add_stale(t);
  }
  // What the tree has made of its variables does not know that they are held.
  if (added.holds && added.tree_factor < 0) {
    for (int slot : added.slots) models_.tree().eliminate_again(slot);
  }
  return t;
}

void ContinuousHalf::remove_term(int t) {
  costs_.leave(terms()[t]);
  models_.leave(t);
  models_.terms().remove(t);
}

/// Hybrid terms enter with the components that the discrete half-step has chosen, so that a
/// measurement rejected at once never touches the tree.
void ContinuousHalf::enter_new(const std::vector<int>& terms) {
  std::vector<int> slots;
  for (int t : terms) {
    const Term& term = this->terms()[t];
    if (term.tree_factor < 0) models_.enter(t, values());
    if (term.tree_factor >= 0) slots.insert(slots.end(), term.slots.begin(), term.slots.end());
  }
  order_.start(slots, models_.tree().pending() > 0, estimate_);
}

void ContinuousHalf::choose(int t, const Component& component) {
  costs_.leave(terms()[t]);
  models_.choose(t, component, values());
  costs_.enter(terms()[t]);
}

void ContinuousHalf::keep_last(const std::vector<Key>& keys) {
  order_.keep_last(keys);
  for (Key key : keys) {
    if (values().contains(key) && !estimate_.is_removed(key)) {
      models_.tree().eliminate_again(values().slot(key));
    }
  }
}

void ContinuousHalf::renew_off(UpdateReport& report) {
  make_again(costs_.take_off(), report);
}

void ContinuousHalf::renew_all(UpdateReport& report) {
  std::vector<int> all(terms().count());
  std::iota(all.begin(), all.end(), 0);
  make_again(all, report);
}

void ContinuousHalf::renew_moved(UpdateReport& report) {
  touched_.start(changed_, terms());
  costs_.take_off();
  make_again(touched_.get(), report);
}

void ContinuousHalf::leave_off(const std::vector<int>& slots) {
  touched_.start(slots, terms());
  costs_.set_off(touched_.get());
}

bool ContinuousHalf::eliminate(const Given& given, UpdateReport& report) {
  const MapOf map(map_kind_, estimate_, terms(), moved_);
  const std::vector<int> behind = order_.behind(values());
  if (are_in(models_.tree(), behind) && models_.tree().defer(leeway_.defer, map.charts()))
    return true;
  models_.linearize_eliminated(values());
  const auto determined = [&](const std::vector<int>& slots) {
    return are_determined(slots, models_, estimate_, given.graph, given.assignment);
  };
  const EliminationReport done =
      models_.tree().eliminate(order_.last(), determined, behind, map.charts());
  report.eliminated += done.variables;
  report.cliques += done.cliques;
  if (done.singular < 0) return true;
  report.status = UpdateReport::Status::kSingular;
  report.under_constrained = values().key(done.singular);
  report.message = "the factors do not determine " + to_string(report.under_constrained) +
                   "; give it a prior or more measurements";
  return false;
}

bool ContinuousHalf::eliminate_new(const Given& given, UpdateReport& report) {
  if (eliminate(given, report)) return true;
  if (models_.weak_are_coupled() || models_.is_whole()) return false;
  report.status = UpdateReport::Status::kOk;
  report.message.clear();
  report.under_constrained = Key();
  models_.couple_weak(values());
  return eliminate(given, report);
}

void ContinuousHalf::solve(const Leeway& leeway, const Given& given) {
  const MapOf map(map_kind_, estimate_, terms(), moved_);
  changed_ = models_.tree().solve(leeway.wildfire, bend_of(leeway, given.graph), map.charts());
  touched_.start(changed_, terms());
  if (given.graph.hybrid().size() > 0) touch_untied();
  refresh_costs();
}

/// By how much parts of the map may stay bent.
Bend ContinuousHalf::bend_of(const Leeway& leeway, const HybridGraph& graph) const {
  const auto factors = static_cast<double>(graph.continuous().size() + graph.hybrid().size());
  const double cost = costs_.value() - costs_.constant();
  const double mean = std::clamp(cost / std::max(factors, 1.0), 0.0, kCostByNoise);
  return {leeway.bend, leeway.bend_share * mean};
}

/// Adds to the touched terms the hybrid ones of which the tree does not know that they tie their
/// variables, and of which one has moved: parts of the tree may have moved past each other.
void ContinuousHalf::touch_untied() {
  const std::size_t before = touched_.size();
  for (int slot : moved().slots) {
    for (int t : terms().of_variable(slot)) {
      const Term& term = terms()[t];
      if (!term.alive || term.hybrid == nullptr) continue;
      const bool tied =
          term.tree_factor >= 0 && term.component.factor->keys().size() == term.slots.size();
      if (!tied) touched_.add(t);
    }
  }
  touched_.sort_from(before);
}

void ContinuousHalf::refresh_costs(const std::vector<int>& slots) {
  touched_.start(slots, terms());
  refresh_costs();
}

/// Brings the costs of the touched terms up to date.
void ContinuousHalf::refresh_costs() {
  costs_.refresh(touched_.get(), values(), map_kind_, models_);
  choose_off();
}

void ContinuousHalf::set(const Places& places) {
  const double* x = places.numbers.data();
  for (int slot : places.slots) {
    const int size = values().type(slot).size;
    std::copy_n(x, size, estimate_.edit(slot));
    x += size;
  }
}

void ContinuousHalf::go_to(const Places& places, UpdateReport& report) {
  set(places);
  refresh_costs(places.slots);
  costs_.forget_errors();
  make_again(touched_.get(), report);
}

void ContinuousHalf::go_along(const Places& start, const std::vector<double>& way, double share) {
  const double* x = start.numbers.data();
  const double* whole = way.data();
  std::vector<double> step;
  for (int slot : start.slots) {
    const VariableType type = values().type(slot);
    double* at = estimate_.edit(slot);
    if (share > 0.0) {
      step.assign(whole, whole + type.dim);
      for (double& number : step) number *= share;
      retract(type, x, step.data(), at);
    } else {
      std::copy_n(x, type.size, at);
    }
    whole += type.dim;
    x += type.size;
  }
  const MapOf map(map_kind_, estimate_, terms(), moved_);
  for (int slot : start.slots) models_.tree().set_delta(slot, *map.charts());
  refresh_costs(start.slots);
}

bool ContinuousHalf::jump(const Places& places, const Given& given, UpdateReport& report) {
  set(places);
  touched_.start(places.slots, terms());
  make_again(touched_.get(), report);
  if (!eliminate(given, report)) return false;
  refresh_costs(places.slots);
  return true;
}

std::vector<int> ContinuousHalf::slots_of(const std::vector<Key>& keys) const {
  std::vector<int> slots;
  for (Key key : keys) slots.push_back(values().slot(key));
  return slots;
}

Eigen::MatrixXd ContinuousHalf::joint_covariance(const std::vector<Key>& keys) const {
  const MapOf map(map_kind_, estimate_, terms());
  return models_.tree().covariances(map.charts()).joint(slots_of(keys));
}

Eigen::MatrixXd ContinuousHalf::joint_covariance(const std::vector<Key>& keys,
                                                 const Eigen::MatrixXd& J) const {
  const MapOf map(map_kind_, estimate_, terms());
  return models_.tree().covariances(map.charts()).joint(slots_of(keys), J);
}

void ContinuousHalf::visit_covariances(
    const std::function<void(Key, const Eigen::MatrixXd&)>& visit) const {
  const MapOf map(map_kind_, estimate_, terms());
  models_.tree().covariances(map.charts()).visit([&](int slot, const Eigen::MatrixXd& covariance) {
    visit(values().key(slot), covariance);
  });
}

std::size_t ContinuousHalf::bytes() const {
  return models_.tree().bytes() + terms().bytes() + estimate_->bytes();
}

void ContinuousHalf::commit(int recent) noexcept {
  models_.commit();
  estimate_.commit();
  order_.forget(recent);
}

void ContinuousHalf::roll_back(Mark&& mark) noexcept {
  models_.roll_back(mark.models);
  estimate_.roll_back(mark.values);
  costs_.roll_back(std::move(mark.costs));
  map_kind_ = mark.map_kind;
  order_ = std::move(mark.order);
}

}  // namespace hybrid
