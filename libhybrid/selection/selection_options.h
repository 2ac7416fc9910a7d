// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/core/option.h"
#include "libhybrid/solvers/options.h"

namespace HYBRID_API hybrid {

/// Options of select_closures().
struct ClosureSelectionOptions {
  MixtureOptions mixture;
  /// On the evidence see EvidenceModel. The number of closures counts, so that false admissions are
  /// rare in the whole graph, not only for each closure.
  double margin = 1.5;
  double degrees_of_freedom = 4.0;
  double gate = 4.0;
  bool pairs = true;
  bool trust_start = false;
  double min_redundancy = 0.09;
  bool refuse_uncheckable = false;
  int max_rounds = 500;
  SolverOptions solver;

  template <class Table>
  static void describe(Table& table) {
    using O = ClosureSelectionOptions;
    table.field("mixture", &O::mixture, "the model of false closures");
    table.option("margin", &O::margin, {0.0, 1e3},
                 "a closure is admitted once the log of its evidence exceeds that of the number of "
                 "closures that are out by this, and leaves once it falls short of it by as much");
    table.option("degrees_of_freedom", &O::degrees_of_freedom, {0.1, 1e6},
                 "of the Student t of the innovations of true closures");
    table.option("gate", &O::gate, {1e-3, 1e6},
                 "innovations beyond this multiple of the 0.9999 quantile of their chi-square are "
                 "refused, whatever the evidence");
    table.option("pairs", &O::pairs,
                 "where no closure passes alone, admit the best two that agree with each other");
    table.option("trust_start", &O::trust_start,
                 "start with the closures that agree with the initial values, not with none");
    table.option("min_redundancy", &O::min_redundancy, kProbability,
                 "below it nothing else would reveal a false closure: it is flagged");
    table.option("refuse_uncheckable", &O::refuse_uncheckable, "refuse closures so flagged");
    table.option("max_rounds", &O::max_rounds, {1, 1e6}, "macro-steps tried");
    table.field("solver", &O::solver, "settings of the last solve; those between are rougher");
  }
};

}  // namespace hybrid
