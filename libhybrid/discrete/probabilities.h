// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/discrete/table.h"

namespace HYBRID_API hybrid {

/// The joint distribution proportional to exp(-cost), in the order of the costs; it sums to one.
/// Throws Error if every joint value is impossible.
std::vector<double> to_probabilities(const Table& table);

/// Bayes' rule over the values of one variable: proportional to prior * exp(log_likelihood), and
/// sums to one. Both have one entry per value; at least one product must be positive.
std::vector<double> posterior(std::vector<double> prior, const std::vector<double>& log_likelihood);

/// -log p(class scores) of a thing whose class probabilities are `belief`, up to a constant of the
/// scores; `likelihood` is that of the scores, one per class. 0 where there are none, or the belief
/// is of other classes.
double class_cost(const std::vector<double>& likelihood, const std::vector<double>& belief);

/// The first of the most probable values; -1 for none at all.
int most_probable(const std::vector<double>& probabilities);

}  // namespace hybrid
