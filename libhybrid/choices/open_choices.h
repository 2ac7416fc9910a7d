// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/hybrid/hybrid_factor.h"

namespace HYBRID_API hybrid {

/// A measurement with several hypotheses: a hybrid factor of one discrete variable.
struct Choice {
  DiscreteKey key;
  HybridFactorPtr factor;
};

/// A closure that is kept back until the choices that it spans are decided.
struct WaitingClosure {
  ContinuousFactorPtr factor;
  std::optional<std::size_t> number;  ///< among those that may be false; none for a true one
  bool in = true;                     ///< under some remaining joint value
};

/// Choices that common closures span, their remaining joint values, and these closures.
struct ChoiceGroup {
  std::vector<std::size_t> choices;
  std::vector<std::vector<int>> values;  ///< joint values, the best first: a value of each choice
  std::vector<WaitingClosure> closures;
  bool compared = false;  ///< with all these closures
};

/// Choices about the step from one pose to the next that no closure has decided yet, and groups of
/// them. Choices that no common closure spans are independent, so that the number of joint values
/// stays small.
class OpenChoices {
 public:
  /// Takes note of choice `number`.
  void open(std::size_t number, const Choice& choice);

  /// Those between two poses.
  std::vector<std::size_t> between(Key a, Key b) const;

  /// A group of the given choices, merged with all groups that share one of them. A choice that
  /// comes new has all its values, `cardinality[i]` for choices[i], as far as the number of joint
  /// values allows, the newest choices first, and else its `present` one.
  ChoiceGroup& join(const std::vector<std::size_t>& choices, const std::vector<int>& cardinality,
                    const std::vector<int>& present);

  std::vector<ChoiceGroup>& groups() { return groups_; }
  const std::vector<ChoiceGroup>& groups() const { return groups_; }
  /// Ends what is decided in a group: its choices that closures which are in tie together are no
  /// longer open once one joint value of them is left, or so many such closures wait. Returns the
  /// closures that span no open choice any longer, and those that are out once so many are.
  std::vector<WaitingClosure> settle(std::size_t group, std::size_t patience);
  /// No choice is open any longer, and there is no group; returns all closures.
  std::vector<WaitingClosure> close_all();
  /// Number of closures kept back.
  std::size_t waiting() const;

 private:
  struct Step {
    std::size_t number;
    Key from, to;
  };
  std::vector<std::size_t> spanned(const WaitingClosure& closure,
                                   const std::vector<std::size_t>& choices) const;
  std::vector<std::vector<std::size_t>> tied(const ChoiceGroup& group) const;

  std::vector<Step> open_;
  std::vector<ChoiceGroup> groups_;
};

}  // namespace hybrid
