// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/worker_pool.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace hybrid {
namespace {

#ifdef __SANITIZE_THREAD__
/// The same by threads of its own: ThreadSanitizer does not see how oneTBB, which is not compiled
/// for it, hands work from thread to thread.
void run_on_arena(tbb::task_arena& arena, int count, const std::function<void(int)>& call) {
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < count; i = next++) call(i);
  };
  std::vector<std::thread> others;
  for (int t = 1; t < arena.max_concurrency(); ++t) others.emplace_back(work);
  work();
  for (std::thread& other : others) other.join();
}
#else
void run_on_arena(tbb::task_arena& arena, int count, const std::function<void(int)>& call) {
  arena.execute([&] { tbb::parallel_for(0, count, call, tbb::simple_partitioner()); });
}
#endif

}  // namespace

struct WorkerPool::Arena {
  tbb::task_arena arena;
};

WorkerPool::WorkerPool(int threads)
    : threads_(threads < 1 ? std::clamp<int>(std::thread::hardware_concurrency(), 1, 4) : threads) {
  if (threads_ > 1) arena_ = std::make_unique<Arena>(Arena{tbb::task_arena(threads_)});
}

WorkerPool::~WorkerPool() = default;

void WorkerPool::run(int count, const std::function<void(int)>& body, bool worthwhile) {
  if (arena_ == nullptr || count < 2 || !worthwhile) {
    for (int i = 0; i < count; ++i) body(i);
    return;
  }
  std::mutex mutex;
  std::exception_ptr first;
  int thrower = count;
  const auto call = [&](int i) {
    try {
      body(i);
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      if (i > thrower) return;
      thrower = i;
      first = std::current_exception();
    }
  };
  run_on_arena(arena_->arena, count, call);
  if (first != nullptr) std::rethrow_exception(first);
}

}  // namespace hybrid
