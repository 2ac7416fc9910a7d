// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <utility>

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

/// A part of a transaction on trial: what is done to the smoother during its life is rolled back at
/// its end, unless it was released. They nest.
class Savepoint {
 public:
  /// Throws Error where no transaction is under way. The smoother must outlive it.
  explicit Savepoint(IncrementalSmoother& smoother) : smoother_(smoother), mark_(smoother.mark()) {}
  ~Savepoint() {
    if (!released_) smoother_.roll_back_to(mark_);
  }
  Savepoint(const Savepoint&) = delete;
  Savepoint& operator=(const Savepoint&) = delete;

  /// Keeps what was done. Throws Error where an update has failed, which has rolled all back.
  void release() {
    smoother_.release(mark_);
    released_ = true;
  }

 private:
  IncrementalSmoother& smoother_;
  std::size_t mark_;
  bool released_ = false;
};

/// Thrown where the smoother refuses an update that a larger change consists of.
struct Refused {
  UpdateReport report;
};

/// Returns the report of an update; throws Refused if the smoother refused it.
inline UpdateReport taken(UpdateReport report) {
  if (report.status != UpdateReport::Status::kOk) throw Refused{std::move(report)};
  return report;
}

/// Runs part() within a transaction. Returns whether it returned true; if not, or if an update was
/// refused, the smoother is as it was before.
template <class Part>
bool attempt(IncrementalSmoother& smoother, const Part& part) {
  Savepoint savepoint(smoother);
  try {
    if (!part()) return false;
  } catch (const Refused&) {
    return false;
  }
  savepoint.release();
  return true;
}

}  // namespace hybrid
