// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

/// A change on trial: what is done to a smoother during its life is rolled back at its end, unless
/// it was committed.
class Transaction {
 public:
  /// Throws Error where the smoother is in a transaction already. The smoother must outlive it.
  explicit Transaction(IncrementalSmoother& smoother) : smoother_(&smoother) { smoother.begin(); }
  ~Transaction() {
    if (smoother_ != nullptr) smoother_->roll_back();
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// Throws Error where an update has failed, which has rolled all back.
  void commit() {
    smoother_->commit();
    smoother_ = nullptr;
  }

 private:
  IncrementalSmoother* smoother_;
};

}  // namespace hybrid
