// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <set>
#include <unordered_map>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/window_options.h"

namespace HYBRID_API hybrid {

/// Variables that leave a window together, and what goes with them.
struct Departure {
  std::vector<Key> keys;
  std::vector<Handle> breaks = {};    ///< factors that are left out
  double loss = 0.0;                  ///< divergence of that
  std::optional<Key> anchor = {};     ///< the state before the break, which stays
  std::vector<Handle> absorbed = {};  ///< factors that become one with what they leave behind
};

/// The states of a bounded window, in the order in which they entered: which of them are to leave,
/// and where their chain is broken.
class StateChain {
 public:
  explicit StateChain(const WindowOptions& options) : options_(options) {}

  void enter(Key state) {
    states_.push_back(state);
    ++entered_;
  }
  void forget(const std::vector<Key>& keys);
  /// Notes that states have left.
  void leave(const Departure& gone);

  /// The states to marginalise now but for those that are held, oldest first; none until there is a
  /// batch of them.
  std::vector<Departure> surplus(const IncrementalSmoother& smoother, const std::set<Key>& held);
  /// How the prior of a new anchor becomes one with that of an earlier one that holds nearly the
  /// same variables, if there is one: the earlier anchor leaves.
  std::optional<Departure> absorption(Key anchor, const IncrementalSmoother& smoother) const;

 private:
  std::vector<Departure> split(const std::vector<Key>& run,
                               const IncrementalSmoother& smoother) const;
  bool break_behind(Departure& going, const IncrementalSmoother& smoother) const;
  std::set<Key> tied_to(Key state, const IncrementalSmoother& smoother) const;
  bool is_needed(Key state, const IncrementalSmoother& smoother,
                 std::unordered_map<Key, int>& newer) const;

  WindowOptions options_;
  std::vector<Key> states_;
  int entered_ = 0;        // states so far
  int look_again_ = 0;     // so many have entered when it is next looked for surplus ones
  std::set<Key> anchors_;  // states behind which the chain is broken, one for a prior
};

}  // namespace hybrid
