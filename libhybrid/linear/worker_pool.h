// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace hybrid {

/// A few threads that share loops. Which thread runs which index is left open, so the results are
/// the same for any number of threads as long as every index writes only to its own place.
class WorkerPool {
 public:
  /// `threads` counts the caller: 1 starts no thread. Less than 1 means one per core, at most 4.
  explicit WorkerPool(int threads = 0);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  int threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls body(i) for i = 0 .. count - 1 and returns when all are done. `body` must not throw.
  /// Waking a thread costs some 10 us: with `worthwhile` false the caller does all alone.
  void run(int count, const std::function<void(int)>& body, bool worthwhile = true);

 private:
  void work();
  void drain();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(int)>* body_ = nullptr;
  std::atomic<int> next_{0};
  int count_ = 0;
  int busy_ = 0;
  unsigned round_ = 0;
  bool stop_ = false;
};

}  // namespace hybrid
