// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

namespace hybrid {

/// A closure that might be admitted.
struct Candidate {
  double evidence = 0.0;  ///< log, see EvidenceModel
  int closure = 0;
  int partner = -1;  ///< of a pair

  /// Whether its evidence is better.
  friend bool operator<(const Candidate& a, const Candidate& b) {
    return a.evidence != b.evidence ? a.evidence > b.evidence : a.closure < b.closure;
  }
};

}  // namespace hybrid
