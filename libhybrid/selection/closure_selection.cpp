// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/closure_selection.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/selection/detail/readmission.h"

namespace hybrid {
namespace {

constexpr std::size_t kCut = 4;  // a batch that fails is cut to this part, down to so many closures
constexpr double kContradictedShare = 0.02;  // largest share of a batch that is kept

/// One run of the selection.
class ClosureSelection {
 public:
  ClosureSelection(const RobustProblem& problem, const ClosureSelectionOptions& options)
      : options_(options), map_(problem, options), drops_(problem.closures.size(), 0) {}

  RobustResult run() {
    map_.begin();
    RobustResult result;
    result.objectives.push_back(map_.objective());
    if (try_all()) result.objectives.push_back(map_.objective());
    admit_all(result.objectives);
    if (!options_.trust_start) ask_again(result.objectives);
    admit_all(result.objectives, true);
    map_.finish(result);
    if (round_ >= options_.max_rounds) {
      result.converged = false;
      result.message = "closures were still admitted after " + std::to_string(options_.max_rounds) +
                       " macro-steps, the limit";
    }
    return result;
  }

 private:
  /// Closures to admit together.
  struct Batch {
    std::vector<Candidate> sure;    ///< by the evidence for each
    std::vector<Candidate> beyond;  ///< by what agrees with them, in the order of its discovery
    std::size_t size() const { return sure.size() + beyond.size(); }
    std::vector<Candidate> all() const {
      std::vector<Candidate> both = sure;
      both.insert(both.end(), beyond.begin(), beyond.end());
      return both;
    }
  };

  static void cut(std::vector<Candidate>& batch, double share) {
    batch.resize(static_cast<std::size_t>(std::ceil(share * double(batch.size()))));
  }

  /// Closures that pass alone; else clusters of them; else the best pair.
  Batch next_batch() {
    Batch batch;
    batch.sure = map_.candidates();
    if (!batch.sure.empty() || !options_.pairs) return batch;
    batch.beyond = map_.clusters();
    if (batch.beyond.empty()) batch.sure = map_.best_pair();
    return batch;
  }

  /// Macro-steps until no closure is left to admit; at last those that have no information to be
  /// told by. Adds the objective after each.
  void admit_all(std::vector<double>& objectives, bool last = false) {
    double share = 1.0;
    for (; round_ < options_.max_rounds; ++round_) {
      Batch batch = next_batch();
      if (batch.size() == 0 && unfolds()) {
        objectives.push_back(map_.objective());
        continue;
      }
      if (batch.size() == 0 && last) batch.sure = map_.uninformative();
      if (batch.size() == 0) break;
      if (batch.sure.empty() || batch.sure.front().partner < 0) {
        cut(batch.sure, share);
        cut(batch.beyond, share);
      }
      if (share == 1.0 && batch.beyond.empty()) batch.beyond = map_.beyond(batch.sure);
      if (macro_step(batch)) {
        objectives.push_back(map_.objective());
        share = std::min(1.0, 2.0 * share);
      } else if (batch.size() > kCut) {
        share /= kCut;
      } else {
        for (const Candidate& candidate : batch.all()) map_.refuse(candidate.closure);
      }
    }
  }

  /// Asks again what was refused while the map was another: one macro-step, which begins with the
  /// closures that agree with the map.
  void ask_again(std::vector<double>& objectives) {
    const Readmission::Snapshot before = map_.snapshot();
    map_.begin_again();
    std::fill(drops_.begin(), drops_.end(), 0);
    looked_for_folds_ = false;
    std::vector<double> on_the_way;
    admit_all(on_the_way);
    if (map_.objective() < before.objective) {
      objectives.push_back(map_.objective());
    } else {
      map_.restore(before);
    }
  }

  /// Once no closure is left to admit, solves again from chordal initial values if noise does not
  /// explain the map, which may be folded. Returns whether that lowered the objective.
  bool unfolds() {
    if (looked_for_folds_ || map_.is_explained()) return false;
    looked_for_folds_ = true;
    const double before = map_.objective();
    map_.unfold();
    return map_.objective() < before;
  }

  /// Admits all plausible closures at once if nearly all closures are plausible.
  bool try_all() {
    if (options_.trust_start) return false;
    const std::vector<Candidate> plausible = map_.all_plausible();
    const double out = double(drops_.size()) - double(plausible.size());
    const double few = kContradictedShare / kCut * double(drops_.size());
    return out <= few && macro_step({plausible, {}}, true);
  }

  /// Admits a batch and drops the closures, new or old, that the solution contradicts, and of an
  /// `untested` batch those that it would not admit. False, with nothing changed, unless the
  /// objective falls, and for a batch that the map does not afford, of which those beyond it are
  /// left for later first.
  bool macro_step(Batch batch, bool untested = false) {
    while (batch.size() > kCut && !map_.affords(batch.all())) {
      if (batch.beyond.empty()) return false;
      batch.beyond.resize(batch.beyond.size() / kCut);
    }
    const Readmission::Snapshot before = map_.snapshot();
    const std::vector<bool>* tested = untested ? &before.accepted : nullptr;
    map_.admit(batch.all());
    std::vector<int> contradicted = map_.contradicted(tested);
    const double allowed = std::max(2.0, kContradictedShare * double(batch.size()));
    if (batch.size() > kCut && double(contradicted.size()) > allowed) {
      // The solve may have folded the map, and the new closures may be true.
      map_.unfold();
      contradicted = map_.contradicted(tested);
      if (double(contradicted.size()) > allowed) {
        map_.restore(before);
        return false;
      }
    }
    std::vector<int> dropped;
    for (; !contradicted.empty(); contradicted = map_.contradicted(tested)) {
      contradicted.resize((contradicted.size() + 1) / 2);
      dropped.insert(dropped.end(), contradicted.begin(), contradicted.end());
      map_.drop(contradicted);
    }
    if (!(map_.objective() < before.objective)) {
      map_.restore(before);
      return false;
    }
    for (int closure : dropped) {
      if (++drops_[closure] >= 2) map_.refuse(closure);
    }
    return true;
  }

  const ClosureSelectionOptions& options_;
  Readmission map_;
  std::vector<int> drops_;  // how often a closure was dropped
  int round_ = 0;
  bool looked_for_folds_ = false;
};

}  // namespace

RobustResult select_closures(const RobustProblem& problem, const ClosureSelectionOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  RobustResult result = ClosureSelection(problem, options).run();
  result.method = "selection";
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
