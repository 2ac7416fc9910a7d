// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/smoother/incremental.h"
#include "mrpt_plugins/mapping/backend.h"

namespace hybrid {

/// Online smoothing: each keyframe costs what it touches, and the estimate is whole after each.
class IncrementalBackend : public Backend {
 public:
  explicit IncrementalBackend(const SmootherOptions& options) : smoother_(options) {}

  std::string mode() const override { return "incremental"; }
  BackendReport update(const Delta& delta) override;
  BackendReport finish() override;
  const Values& values() const override { return smoother_.values(); }
  const Assignment& assignment() const override { return smoother_.assignment(); }
  const HybridGraph& graph() const override { return smoother_.graph(); }
  Uncertainty uncertainty(const std::vector<Key>& continuous,
                          const std::vector<DiscreteKey>& discrete) const override;

 private:
  BackendReport report_of(const UpdateReport& update) const;

  IncrementalSmoother smoother_;
  double constant_ = 0;  // objective less cost
};

}  // namespace hybrid
