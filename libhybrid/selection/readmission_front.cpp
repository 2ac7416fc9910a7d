// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Closures that the selection in batch admits by short paths, before the map is solved with them.
#include <algorithm>
#include <limits>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/selection/detail/readmission.h"

namespace hybrid {
namespace {

/// Seeds of a cluster in a row, in order of their evidence, after which no more are tried: those
/// that follow have less. A budget of time.
constexpr std::size_t kMostInVain = 40;

}  // namespace

/// Closures that are neither in nor refused, inside the gate, and without alternatives.
std::vector<bool> Readmission::open_closures() const {
  std::vector<bool> open(accepted_.size());
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    open[k] = !accepted_[k] && !refused_[k] &&
              evidence_[k] > -std::numeric_limits<double>::infinity() &&
              closure_problem_.alternatives.set_of(k).empty();
  }
  return open;
}

ClosureFront::Known Readmission::known(const std::vector<bool>& open) const {
  return {values_, accepted_, open, model_, threshold()};
}

std::vector<Candidate> Readmission::beyond(const std::vector<Candidate>& batch) {
  if (front_ == nullptr || asks_uninformative_) return {};
  const std::vector<bool> open = open_closures();
  const auto count = static_cast<std::size_t>(std::count(open.begin(), open.end(), true));
  if (count < 2 * batch.size()) return {};
  return front_->beyond(batch, known(open));
}

std::vector<Candidate> Readmission::clusters() {
  if (front_ == nullptr || asks_uninformative_) return {};
  std::vector<bool> open = open_closures();
  std::vector<Candidate> seeds;
  for (std::size_t k = 0; k < accepted_.size(); ++k) {
    if (open[k] && evidence_[k] >= 0.0) seeds.push_back({evidence_[k], static_cast<int>(k)});
  }
  std::sort(seeds.begin(), seeds.end());
  std::vector<Candidate> found;
  std::size_t in_vain = 0;
  for (const Candidate& seed : seeds) {
    if (!open[seed.closure]) continue;
    std::vector<Candidate> cluster = front_->beyond({seed}, known(open));
    double evidence = seed.evidence;
    for (const Candidate& other : cluster) evidence += other.evidence;
    const double more = double(cluster.size()) * (threshold() - options_.margin);
    if (evidence <= threshold() + more) {
      if (++in_vain == kMostInVain) break;
      continue;
    }
    in_vain = 0;
    cluster.insert(cluster.begin(), seed);
    for (const Candidate& member : cluster) open[member.closure] = false;
    found.insert(found.end(), cluster.begin(), cluster.end());
  }
  return found;
}

/// Starts from the poses along the tree of shortest paths where these have the lower cost, since
/// the map has drifted far.
void Readmission::chain() {
  if (front_ == nullptr) return;
  problem_->set_assignment(to_assignment(accepted_));
  Problem::State chained = problem_->load(front_->chained(values_, accepted_));
  if (problem_->cost(chained) < problem_->cost(state_)) state_ = std::move(chained);
}

}  // namespace hybrid
