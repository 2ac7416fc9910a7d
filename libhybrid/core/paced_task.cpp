// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/paced_task.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace hybrid {
namespace {

/// Ends a task that is no longer wanted.
struct Cancelled {};

/// What is told of the work of its thread.
struct Paced {
  virtual void work(double multiplications) = 0;

 protected:
  ~Paced() = default;
};

// Nothing that is to be destroyed with the thread: glibc ends the program where it lacks the memory
// to note that.
thread_local double noted = 0.0;
thread_local Paced* running = nullptr;  // the task that the thread runs

}  // namespace

struct PacedTask::State final : Paced {
  enum class Turn { kCaller, kTask };

  std::function<void()> function;
  std::mutex mutex;
  std::condition_variable changed;
  Turn turn = Turn::kCaller;
  double allowed = 0.0;  // work until the next pause
  bool done = false, cancelled = false;
  std::exception_ptr error;
  std::thread thread;

  /// Gives the turn to the other side and, unless all is done, waits for it to come back.
  void hand_over(Turn to) {
    std::unique_lock<std::mutex> lock(mutex);
    turn = to;
    changed.notify_all();
    if (!done) changed.wait(lock, [&] { return turn != to; });
  }

  void run();
  void work(double multiplications) override {
    allowed -= multiplications;
    while (allowed < 0.0) pause();
  }
  void pause() {
    if (!cancelled) hand_over(Turn::kCaller);
    if (cancelled) throw Cancelled();
  }
};

void note_work(double multiplications) {
  noted += multiplications;
  if (running != nullptr) running->work(multiplications);
}

double noted_work() {
  return noted;
}

void PacedTask::State::run() {
  running = this;
  try {
    function();
  } catch (const Cancelled&) {
  } catch (...) {
    error = std::current_exception();
  }
  running = nullptr;
  done = true;
  hand_over(Turn::kCaller);
}

PacedTask::PacedTask(std::function<void()> function) : state_(std::make_unique<State>()) {
  state_->function = std::move(function);
}

PacedTask::~PacedTask() {
  if (!state_->thread.joinable()) return;
  if (!state_->done) {
    state_->cancelled = true;
    state_->hand_over(State::Turn::kTask);
  }
  state_->thread.join();
}

bool PacedTask::advance(double multiplications) {
  State& state = *state_;
  if (!state.done) {
    state.allowed += multiplications;
    if (!state.thread.joinable()) {
      state.turn = State::Turn::kTask;
      state.thread = std::thread([&state] { state.run(); });
      std::unique_lock<std::mutex> lock(state.mutex);
      state.changed.wait(lock, [&] { return state.turn == State::Turn::kCaller; });
    } else {
      state.hand_over(State::Turn::kTask);
    }
  }
  if (state.done && state.error != nullptr) {
    std::rethrow_exception(std::exchange(state.error, nullptr));
  }
  return state.done;
}

}  // namespace hybrid
