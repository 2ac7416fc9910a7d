// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/problem.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "libhybrid/core/paced_task.h"

namespace hybrid {
namespace {

/// Multiplications for each entry of a Jacobian that is made, about.
constexpr double kWorkOfEntry = 10.0;

constexpr int kTermsPerTask = 256;
/// Smaller problems, by entries of the Jacobian, are linearised by one thread.
constexpr std::size_t kParallelEntries = 60000;
constexpr std::size_t kFewVariables = 8;

/// Calls function(x) with x[i] pointing to variable i of a factor.
template <class Function>
double with_pointers(const int* offsets, std::size_t count, const double* state,
                     const Function& function) {
  std::array<const double*, kFewVariables> few;
  if (count <= kFewVariables) {
    for (std::size_t i = 0; i < count; ++i) few[i] = state + offsets[i];
    return function(few.data());
  }
  std::vector<const double*> many(count);
  for (std::size_t i = 0; i < count; ++i) many[i] = state + offsets[i];
  return function(many.data());
}

bool same_structure(const ResidualLayout& a, const ResidualLayout& b) {
  return a.blocks == b.blocks && a.residuals.size() == b.residuals.size() &&
         std::equal(a.residuals.begin(), a.residuals.end(), b.residuals.begin(),
                    [](const auto& x, const auto& y) {
                      return x.rows == y.rows && x.count == y.count && x.coupled == y.coupled;
                    });
}

}  // namespace

Problem::Problem(const HybridGraph& graph, const Values& values, const Assignment& assignment,
                 int threads, WeakComponents weak, Elimination elimination)
    : graph_(&graph),
      weak_(weak),
      elimination_(elimination),
      pool_(std::make_unique<WorkerPool>(threads)) {
  collect_blocks(values);
  compile(assignment);
}

void Problem::collect_blocks(const Values& values) {
  std::vector<bool> used(values.slot_count(), false);
  const auto visit = [&](const std::vector<Key>& keys) {
    for (Key key : keys) used[values.slot(key)] = true;
  };
  graph_->continuous().for_each([&](Handle, const auto& factor) { visit(factor->keys()); });
  graph_->hybrid().for_each([&](Handle, const auto& factor) { visit(factor->keys()); });
  block_index_.reserve(values.size());
  for (int slot = 0; slot < values.slot_count(); ++slot) {
    if (!used[slot]) continue;
    const VariableType type = values.type(slot);
    block_index_.emplace(values.key(slot), block_count());
    blocks_.push_back({values.key(slot), type, state_size_, slot});
    layout_.dims.push_back(type.dim);
    state_size_ += type.size;
  }

  std::vector<int> touched;
  graph_->continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    touched.clear();
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      touched.push_back(checked_block(factor->keys(), i, factor->types()[i]));
    }
    add_term(*factor, touched.data(), true);
    fixed_constant_ += factor->log_normalizer();
  });
  fixed_terms_ = terms_.size();
  graph_->hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    hybrid_terms_.push_back({factor.get(), static_cast<int>(hybrid_blocks_.size())});
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      hybrid_blocks_.push_back(checked_block(factor->keys(), i, factor->types()[i]));
    }
  });
}

int Problem::block(Key key) const {
  const auto it = block_index_.find(key);
  if (it == block_index_.end()) {
    throw Error("variable " + to_string(key) + " is in no factor of the graph");
  }
  return it->second;
}

int Problem::checked_block(const std::vector<Key>& keys, std::size_t i, VariableType type) const {
  const int b = block(keys[i]);
  if (blocks_[b].type != type) {
    throw Error("variable " + to_string(keys[i]) + " is " + to_string(blocks_[b].type) + ", but " +
                describe("a", keys) + " takes it as " + to_string(type));
  }
  return b;
}

void Problem::add_term(const ContinuousFactor& factor, const int* blocks, bool coupled) {
  const int count = static_cast<int>(factor.keys().size());
  terms_.push_back({&factor, static_cast<int>(offsets_.size())});
  for (int i = 0; i < count; ++i) offsets_.push_back(blocks_[blocks[i]].offset);
  layout_.add(factor.rows(), blocks, count, coupled);
}

void Problem::set_assignment(const Assignment& assignment) {
  compile(assignment);
}

void Problem::compile(const Assignment& assignment) {
  ResidualLayout before;
  if (system_ != nullptr) before = layout_;
  layout_.truncate(fixed_terms_);
  offsets_.resize(layout_.blocks.size());
  terms_.resize(fixed_terms_);
  constant_ = fixed_constant_;
  graph_->discrete().for_each(
      [&](Handle, const Table& table) { constant_ += table.cost(assignment); });
  std::vector<int> touched;
  for (const HybridTerm& term : hybrid_terms_) {
    const Component component = term.factor->given(assignment);
    constant_ += component.constant;
    if (component.factor == nullptr) continue;
    constant_ += component.factor->log_normalizer();
    touched.clear();
    for (std::size_t i = 0; i < component.factor->keys().size(); ++i) {
      touched.push_back(hybrid_blocks_[term.first + component.positions[i]]);
    }
    add_term(*component.factor, touched.data(),
             !component.weak || weak_ == WeakComponents::kCoupled);
  }
  residuals_.resize(layout_.residual_size);
  jacobians_.resize(layout_.jacobian_size);
  if (system_ != nullptr && (same_structure(before, layout_) || system_->rebind(layout_))) return;
  system_ = std::make_unique<NormalEquations>(layout_, elimination_);
  ++analyses_;
}

Problem::State Problem::load(const Values& values) const {
  State state(state_size_);
  for (const Block& block : blocks_) {
    std::copy_n(values.data(block.slot), block.type.size, state.data() + block.offset);
  }
  return state;
}

void Problem::store(const State& state, Values& values) const {
  for (const Block& block : blocks_) {
    std::copy_n(state.data() + block.offset, block.type.size, values.data(block.slot));
  }
}

void Problem::retract(const State& state, const double* step, State& out) const {
  out.resize(state.size());
  for (int b = 0; b < block_count(); ++b) {
    const Block& block = blocks_[b];
    hybrid::retract(block.type, state.data() + block.offset, step + system_->start(b),
                    out.data() + block.offset);
  }
}

template <class Function>
double Problem::sum_over_terms(const Function& function) const {
  const int count = static_cast<int>(terms_.size());
  const int tasks = (count + kTermsPerTask - 1) / kTermsPerTask;
  std::vector<double> sums(tasks, 0.0);
  pool_->run(
      tasks,
      [&](int task) {
        const int end = std::min(count, (task + 1) * kTermsPerTask);
        for (int t = task * kTermsPerTask; t < end; ++t) sums[task] += function(t);
      },
      layout_.jacobian_size >= kParallelEntries);
  double sum = 0.0;
  for (double part : sums) sum += part;
  return sum;
}

double Problem::term_cost(int t, const State& state) const {
  const Term& term = terms_[t];
  return with_pointers(&offsets_[term.first], layout_.residuals[t].count, state.data(),
                       [&](const double* const* x) { return term.factor->cost(x); });
}

double Problem::cost(const State& state) const {
  return sum_over_terms([&](int t) { return term_cost(t, state); });
}

std::vector<FactorCost> Problem::factor_costs(const State& state) const {
  std::vector<FactorCost> costs(terms_.size());
  for (std::size_t t = 0; t < costs.size(); ++t) {
    costs[t] = {term_cost(static_cast<int>(t), state), layout_.residuals[t].rows};
  }
  return costs;
}

double Problem::linearize(const State& state) {
  note_work(kWorkOfEntry * double(jacobians_.size()));
  return sum_over_terms([&](int t) {
    const Term& term = terms_[t];
    const auto& place = layout_.residuals[t];
    double* r = residuals_.data() + place.residual;
    double* J = jacobians_.data() + place.jacobian;
    return with_pointers(&offsets_[term.first], place.count, state.data(),
                         [&](const double* const* x) { return term.factor->linearize(x, r, J); });
  });
}

double Problem::curvature(const double* v) const {
  return sum_over_terms([&](int t) {
    const auto& place = layout_.residuals[t];
    Eigen::VectorXd product = Eigen::VectorXd::Zero(place.rows);
    const double* J = jacobians_.data() + place.jacobian;
    for (int i = 0; i < place.count; ++i) {
      const int b = layout_.blocks[place.first + i];
      const int dim = layout_.dims[b];
      product += Eigen::Map<const Eigen::MatrixXd>(J, place.rows, dim) *
                 Eigen::Map<const Eigen::VectorXd>(v + system_->start(b), dim);
      J += place.rows * dim;
    }
    return product.squaredNorm();
  });
}

ExtendedCholesky Problem::extended_factor() const {
  for (std::size_t t = 0; t < terms_.size(); ++t) {
    const auto& place = layout_.residuals[t];
    const double* J = jacobians_.data() + place.jacobian;
    const int size = place.rows * terms_[t].factor->cols();
    if (!std::all_of(J, J + size, [](double entry) { return std::isfinite(entry); })) {
      const ContinuousFactor& factor = *terms_[t].factor;
      throw Error("the derivatives of a " + factor.name() + " factor on " +
                  to_string(factor.keys().at(0)) + " are not finite");
    }
  }
  return {layout_, jacobians_.data()};
}

std::vector<Table> Problem::tables(const State& state) const {
  std::vector<Table> result;
  result.reserve(hybrid_terms_.size());
  std::vector<const double*> x;
  for (const HybridTerm& term : hybrid_terms_) {
    x.clear();
    for (std::size_t i = 0; i < term.factor->keys().size(); ++i) {
      x.push_back(state.data() + blocks_[hybrid_blocks_[term.first + i]].offset);
    }
    for (Table& table : term.factor->given(x.data())) result.push_back(std::move(table));
  }
  return result;
}

}  // namespace hybrid
