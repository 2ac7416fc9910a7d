// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/detail/variable_elimination.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/infinity.h"

namespace hybrid {
namespace {

/// Iterates over the rows of a dense table (joint values of all but its last variable) with the
/// matching offset in another table.
class RowWalk {
 public:
  RowWalk(const Strides& strides, std::vector<int>& counter) : s_(strides), counter_(counter) {
    counter_.assign(s_.dims.size(), 0);
  }
  std::size_t offset() const { return offset_; }
  void next() {
    for (int d = static_cast<int>(s_.dims.size()) - 2; d >= 0; --d) {
      offset_ += s_.steps[d];
      if (++counter_[d] < s_.dims[d]) return;
      offset_ -= s_.steps[d] * s_.dims[d];
      counter_[d] = 0;
    }
  }

 private:
  const Strides& s_;
  std::vector<int>& counter_;
  std::size_t offset_ = 0;
};

}  // namespace

VariableElimination::VariableElimination(const DiscreteGraph& graph, const JunctionForest& forest)
    : graph_(graph), forest_(forest) {
  message_begin_.reserve(forest_.size() + 1);
  message_begin_.push_back(0);
  for (int p = 0; p < forest_.size(); ++p) {
    message_begin_.push_back(message_begin_.back() + forest_.entries[p] / dim(p));
  }
  messages_.resize(message_begin_.back());
  offset_.assign(forest_.size(), 0.0);
  next_child_.assign(forest_.size(), -1);
  list_tables();
}

// A table belongs to the clique of its first variable to be eliminated.
void VariableElimination::list_tables() {
  const int tables = static_cast<int>(graph_.tables().size());
  first_table_.assign(forest_.size(), -1);
  next_table_.assign(tables, -1);
  for (int t = tables - 1; t >= 0; --t) {
    int first = forest_.size();
    for (int v : graph_.scope(t)) {
      if (forest_.position[v] < 0) continue;
      first = std::min(first, forest_.position[v]);
    }
    if (first == forest_.size()) continue;
    next_table_[t] = first_table_[first];
    first_table_[first] = t;
  }
}

void VariableElimination::adopt(int p) {
  const int parent = forest_.parent(p);
  if (parent < 0) return;
  next_child_[p] = first_child_[parent];
  first_child_[parent] = p;
}

void VariableElimination::load_scope(int p) {
  const IntSpan separator = forest_.separator(p);
  scope_.assign(separator.begin(), separator.end());
  scope_.push_back(p);
  strides_.dims.clear();
  for (int q : scope_) strides_.dims.push_back(dim(q));
}

void VariableElimination::strides_of_table(int t) {
  strides_.steps.assign(scope_.size(), 0);
  const IntSpan variables = graph_.scope(t);
  std::size_t step = 1;
  for (int i = variables.size() - 1; i >= 0; --i) {
    const auto place = std::find(scope_.begin(), scope_.end(), forest_.position[variables[i]]);
    strides_.steps[place - scope_.begin()] = step;
    step *= graph_.cardinality(variables[i]);
  }
}

// The separator of a child is a subset of the current scope, in the same order.
void VariableElimination::strides_of_separator(int p) {
  strides_.steps.assign(scope_.size(), 0);
  const IntSpan separator = forest_.separator(p);
  std::size_t step = 1;
  int i = separator.size() - 1;
  for (int d = static_cast<int>(scope_.size()) - 1; d >= 0 && i >= 0; --d) {
    if (scope_[d] != separator[i]) continue;
    strides_.steps[d] = step;
    step *= strides_.dims[d];
    --i;
  }
}

void VariableElimination::add(const double* source, double* table, std::size_t size) {
  const std::size_t row = strides_.dims.back();
  const std::size_t step = strides_.steps.back();
  RowWalk walk(strides_, counter_);
  for (std::size_t begin = 0; begin < size; begin += row, walk.next()) {
    const double* from = source + walk.offset();
    for (std::size_t j = 0; j < row; ++j) table[begin + j] += from[j * step];
  }
}

void VariableElimination::fill_clique(int p, double* table) {
  load_scope(p);
  std::fill(table, table + forest_.entries[p], 0.0);
  for (int t = first_table_[p]; t >= 0; t = next_table_[t]) {
    strides_of_table(t);
    add(graph_.tables()[t]->costs().data(), table, forest_.entries[p]);
  }
  for (int c = first_child_[p]; c >= 0; c = next_child_[c]) {
    strides_of_separator(c);
    add(messages_.data() + message_begin_[c], table, forest_.entries[p]);
  }
}

// Subtracts the minimum of a message. If all entries are infinite, lists the clique as impossible
// and returns false.
bool VariableElimination::normalize_message(int p) {
  double* first = messages_.data() + message_begin_[p];
  double* last = messages_.data() + message_begin_[p + 1];
  const double least = *std::min_element(first, last);
  if (least == kInfinity) {
    // Reported once, where it arises: the message becomes zero and rules nothing out.
    std::fill(first, last, 0.0);
    impossible_.emplace_back();
    for (int q : scope_) impossible_.back().push_back(forest_.order[q]);
    return false;
  }
  for (double* m = first; m != last; ++m) *m -= least;
  offset_[p] = least;
  return true;
}

void VariableElimination::minimize_clique(int p, const double* table, int incumbent) {
  const int row = dim(p);
  const int start = incumbent >= 0 ? incumbent : 0;
  for (std::size_t i = message_begin_[p]; i < message_begin_[p + 1]; ++i, table += row) {
    int best = start;
    for (int j = 0; j < row; ++j) {
      if (table[j] < table[best]) best = j;
    }
    messages_[i] = table[best];
    choices_[i] = best;
  }
}

void VariableElimination::minimize(std::vector<int>& values) {
  impossible_.clear();
  first_child_.assign(forest_.size(), -1);
  choices_.resize(messages_.size());
  for (int p = 0; p < forest_.size(); ++p) {
    if (scratch_.size() < forest_.entries[p]) scratch_.resize(forest_.entries[p]);
    fill_clique(p, scratch_.data());
    minimize_clique(p, scratch_.data(), values[forest_.order[p]]);
    normalize_message(p);
    adopt(p);
  }
  for (int p = forest_.size() - 1; p >= 0; --p) {
    std::size_t index = 0;
    for (int q : forest_.separator(p)) index = index * dim(q) + values[forest_.order[q]];
    values[forest_.order[p]] = choices_[message_begin_[p] + index];
  }
}

void VariableElimination::sum_clique(int p, const double* table) {
  const int row = dim(p);
  for (std::size_t i = message_begin_[p]; i < message_begin_[p + 1]; ++i, table += row) {
    const double least = *std::min_element(table, table + row);
    double sum = 0.0;
    for (int j = 0; j < row; ++j) sum += std::exp(least - table[j]);
    messages_[i] = least == kInfinity ? kInfinity : least - std::log(sum);
  }
}

double VariableElimination::calibrate() {
  impossible_.clear();
  first_child_.assign(forest_.size(), -1);
  clique_begin_.assign(1, 0);
  for (std::size_t entries : forest_.entries) {
    clique_begin_.push_back(clique_begin_.back() + entries);
  }
  cliques_.resize(clique_begin_.back());
  double log_sum = 0.0;
  for (int p = 0; p < forest_.size(); ++p) {
    double* table = cliques_.data() + clique_begin_[p];
    fill_clique(p, table);
    sum_clique(p, table);
    if (!normalize_message(p)) return -kInfinity;
    log_sum -= offset_[p];
    adopt(p);
  }
  for (int p = forest_.size() - 1; p >= 0; --p) distribute(p);
  return log_sum;
}

// Turns the table of a clique into its belief: the message it sent is replaced by the belief of its
// parent over the separator. Where the message is infinite, so are the clique and the parent.
void VariableElimination::distribute(int p) {
  scratch_.assign(message_begin_[p + 1] - message_begin_[p], 0.0);
  const int parent = forest_.parent(p);
  if (parent >= 0) {
    load_scope(parent);
    strides_of_separator(p);
    sum_onto(cliques_.data() + clique_begin_[parent], forest_.entries[parent], scratch_);
  }
  double* row = cliques_.data() + clique_begin_[p];
  for (std::size_t i = 0; i < scratch_.size(); ++i, row += dim(p)) {
    const double sent = messages_[message_begin_[p] + i];
    if (sent == kInfinity) continue;
    for (int j = 0; j < dim(p); ++j) row[j] += scratch_[i] - sent - offset_[p];
  }
}

// -log sum exp of a clique table over all variables along which the strides are zero.
void VariableElimination::sum_onto(const double* table, std::size_t size,
                                   std::vector<double>& out) {
  const std::size_t row = strides_.dims.back();
  const std::size_t step = strides_.steps.back();
  std::vector<double> least(out.size(), kInfinity);
  RowWalk minima(strides_, counter_);
  for (std::size_t begin = 0; begin < size; begin += row, minima.next()) {
    for (std::size_t j = 0; j < row; ++j) {
      double& m = least[minima.offset() + j * step];
      m = std::min(m, table[begin + j]);
    }
  }
  std::fill(out.begin(), out.end(), 0.0);
  RowWalk sums(strides_, counter_);
  for (std::size_t begin = 0; begin < size; begin += row, sums.next()) {
    for (std::size_t j = 0; j < row; ++j) {
      const std::size_t i = sums.offset() + j * step;
      if (table[begin + j] < kInfinity) out[i] += std::exp(least[i] - table[begin + j]);
    }
  }
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = least[i] == kInfinity ? kInfinity : least[i] - std::log(out[i]);
  }
}

std::vector<double> VariableElimination::marginal(const std::vector<int>& variables) {
  int p = forest_.size();
  for (int v : variables) p = std::min(p, forest_.position[v]);
  load_scope(p);
  strides_.steps.assign(scope_.size(), 0);
  std::size_t size = 1;
  for (std::size_t i = variables.size(); i-- > 0;) {
    const auto place = std::find(scope_.begin(), scope_.end(), forest_.position[variables[i]]);
    strides_.steps[place - scope_.begin()] = size;
    size *= graph_.cardinality(variables[i]);
  }
  std::vector<double> out(size);
  sum_onto(cliques_.data() + clique_begin_[p], forest_.entries[p], out);
  const double least = *std::min_element(out.begin(), out.end());
  double sum = 0.0;
  for (double& m : out) sum += m = std::exp(least - m);
  for (double& m : out) m /= sum;
  return out;
}

}  // namespace hybrid
