// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <memory>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A limit on how many threads share a loop; the threads are those of oneTBB, which all pools and
/// the program itself have in common, so that loops inside loops start no more of them. Which
/// thread runs which index is left open, so the results are the same for any number of threads as
/// long as every index writes only to its own place.
class WorkerPool {
 public:
  /// `threads` counts the caller: 1 means no other. Less than 1 means one per core, at most 4.
  explicit WorkerPool(int threads = 0);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return threads_; }

  /// Calls body(i) for i = 0 .. count - 1 and returns when all are done. If some calls throw, the
  /// exception of the smallest such i reaches the caller, whatever the number of threads. Waking a
  /// thread costs some 10 us: with `worthwhile` false the caller does all alone.
  void run(int count, const std::function<void(int)>& body, bool worthwhile = true);

 private:
  struct Arena;

  int threads_;
  std::unique_ptr<Arena> arena_;  // none for one thread
};

}  // namespace hybrid
