// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What the smoother does when a full step would raise the objective.
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

constexpr int kTries = 14;

/// A share of the way along the full step, straight or, where there is a bend, to it in the first
/// half and on from it in the second (Powell's dogleg).
void part_of_way(double share, const std::vector<double>& full, const std::vector<double>& bend,
                 std::vector<double>& part) {
  part.resize(full.size());
  for (std::size_t i = 0; i < full.size(); ++i) {
    if (bend.empty()) {
      part[i] = share * full[i];
    } else if (share < 0.5) {
      part[i] = 2.0 * share * bend[i];
    } else {
      part[i] = bend[i] + (2.0 * share - 1.0) * (full[i] - bend[i]);
    }
  }
}

}  // namespace

/// Goes a part of the way from the old estimate to the present one, the largest tried that does not
/// raise the objective; at worst none, with everything to be linearised again in the next update.
/// Returns whether it went any.
bool IncrementalSmoother::back_off(double before) {
  const std::vector<int> slots = old_slots_;
  const auto for_each_old = [&](const auto& visit) {
    const double* x = old_.data();
    for (int slot : slots) {
      visit(slot, x);
      x += values().type(slot).size;
    }
  };
  std::vector<double> full;
  for_each_old([&](int slot, const double* x) {
    const VariableType type = values().type(slot);
    full.resize(full.size() + type.dim);
    local(type, x, values().data(slot), full.data() + full.size() - type.dim);
  });
  const auto restore = [&] {
    for_each_old([&](int slot, const double* x) {
      std::copy_n(x, values().type(slot).size, estimate_.edit(slot));
    });
  };
  std::vector<double> bend, part;
  if (options_.step == SmootherOptions::Step::kDogleg) {
    restore();
    bend = cauchy_step(slots);
  }
  const auto move = [&](double share) {
    part_of_way(share, full, bend, part);
    const double* step = part.data();
    for_each_old([&](int slot, const double* x) {
      const VariableType type = values().type(slot);
      retract(type, x, step, estimate_.edit(slot));
      step += type.dim;
    });
  };
  std::vector<double> delta;
  double share = 1.0;
  for (int k = 0;; ++k) {
    share *= bend.empty() ? 0.5 : 0.7;
    const bool give_up = k == kTries;
    if (give_up) {
      restore();
    } else {
      move(share);
    }
    for (int slot : slots) {
      delta.resize(theta_->type(slot).dim);
      local(theta_->type(slot), theta_->data(slot), values().data(slot), delta.data());
      tree_.set_delta(slot, delta.data());
    }
    refresh_costs(slots);
    if (!give_up && term_cost_.value() > before) continue;
    if (give_up) moved_ = slots;
    return !give_up;
  }
}

/// The minimiser of the linearised objective along steepest descent, over some variables at the
/// estimate.
std::vector<double> IncrementalSmoother::cauchy_step(const std::vector<int>& slots) const {
  std::vector<int> offset(theta_->slot_count(), -1);
  int size = 0;
  for (int slot : slots) {
    offset[slot] = size;
    size += theta_->type(slot).dim;
  }
  std::vector<int> terms;
  for (int slot : slots)
    terms.insert(terms.end(), terms_.of_variable(slot).begin(), terms_.of_variable(slot).end());
  std::sort(terms.begin(), terms.end());
  terms.erase(std::unique(terms.begin(), terms.end()), terms.end());
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  double curvature = 0.0;
  // Once for the gradient g = J'r, once for g'J'J g.
  for (const bool second : {false, true}) {
    for (int t : terms) {
      const Term& term = terms_[t];
      if (!term.alive || term.component.factor == nullptr) continue;
      const ContinuousFactor& factor = *term.component.factor;
      const std::vector<int> own = active_slots(term);
      std::vector<const double*> x;
      for (int slot : own) x.push_back(values().data(slot));
      Eigen::VectorXd r(factor.rows());
      Eigen::MatrixXd J(factor.rows(), factor.cols());
      factor.linearize(x.data(), r.data(), J.data());
      Eigen::VectorXd Jg = Eigen::VectorXd::Zero(factor.rows());
      int column = 0;
      for (std::size_t i = 0; i < own.size(); ++i) {
        const int dim = factor.types()[i].dim;
        if (offset[own[i]] >= 0) {
          auto block = gradient.segment(offset[own[i]], dim);
          if (second) {
            Jg += J.middleCols(column, dim) * block;
          } else {
            block += J.middleCols(column, dim).transpose() * r;
          }
        }
        column += dim;
      }
      curvature += Jg.squaredNorm();
    }
  }
  const double scale = curvature > 0.0 ? gradient.squaredNorm() / curvature : 0.0;
  std::vector<double> step(size);
  Eigen::Map<Eigen::VectorXd>(step.data(), size) = -scale * gradient;
  return step;
}

}  // namespace hybrid
