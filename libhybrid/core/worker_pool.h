// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <memory>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Runs loops on a limited number of threads. The threads are those of oneTBB, shared by all pools
/// and the program itself, so that nested loops start no more of them. It is unspecified which
/// thread runs which index; results are the same for any number of threads as long as every index
/// writes only to its own place.
class WorkerPool {
 public:
  /// `threads` includes the calling thread: 1 means no other. Less than 1 means one per core, at
  /// most 4.
  explicit WorkerPool(int threads = 0);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return threads_; }

  /// Calls body(i) for i = 0 .. count - 1 and returns when all are done. If some calls throw, the
  /// exception of the smallest such i reaches the caller, whatever the number of threads. With
  /// `worthwhile` false the calling thread makes all calls itself, for loops too short for the 10
  /// us or so that waking a thread costs.
  void run(int count, const std::function<void(int)>& body, bool worthwhile = true);

 private:
  struct Arena;

  int threads_;
  std::unique_ptr<Arena> arena_;  // none for one thread
};

}  // namespace hybrid
