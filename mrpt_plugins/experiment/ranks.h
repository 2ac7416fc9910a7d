// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Messages between the processes (ranks) that a launcher started as one program.
class Channel {
 public:
  struct Message {
    int from = 0;  ///< rank
    std::string text;
  };

  virtual ~Channel() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  virtual std::string host() const = 0;
  /// Does not wait for the other rank to receive it.
  virtual void send(int to, const std::string& text) = 0;
  /// The oldest message that has arrived, if any. Does not wait.
  virtual std::optional<Message> receive() = 0;
  /// Lets this process end without waiting for the others.
  virtual void leave() = 0;
};

/// The other ranks, as rank 0 sees them: each runs one task at a time. They are told to end when
/// this object goes. A rank that was given up is sent nothing any more.
class Workers {
 public:
  struct Events {
    /// The task with this index ended with this text.
    std::function<void(std::size_t, const std::string&)> done;
    /// The rank that ran this task said nothing for too long. The task may still end.
    std::function<void(std::size_t, const std::string&)> lost;
    /// A rank takes no part, for this reason.
    std::function<void(const std::string&)> refused;
    /// Whether to stop; running tasks are then ended without an event.
    std::function<bool()> stop;
  };

  explicit Workers(Channel& channel);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Runs the tasks of these names, handed out in order. Ranks must have the same `greeting`, lines
  /// of settings and versions; others are refused. A rank that says nothing for `silence`
  /// [s] is given up. Throws Error if no worker is left.
  void run(const std::vector<std::string>& tasks, const std::string& greeting, double silence,
           const Events& events);

 private:
  using Clock = std::chrono::steady_clock;
  struct Worker {
    enum class State { kNew, kIdle, kBusy, kLost, kRefused, kGone };
    State state = State::kNew;
    std::size_t task = 0;  ///< newest one handed out
    std::string host;
    Clock::time_point heard = Clock::now();
  };

  /// These return how many tasks ended.
  std::size_t read(const Channel::Message& message, const std::string& greeting,
                   const Events& events);
  std::size_t give_up_silent(double silence, const Events& events);
  std::size_t give_up(Worker& worker, Worker::State state, const std::string& why,
                      const Events& events);

  void greet(int rank, const std::string& text, const std::string& greeting, const Events& events);
  bool all_gone() const;
  void stop();

  Channel& channel_;
  std::string reason_;           // why the newest rank was given up
  std::vector<Worker> workers_;  // by rank; that of rank 0 is kGone
};

/// Tells rank 0 that this rank is at work; false if the task is to be ended. Call it often.
using AtWork = std::function<bool()>;

/// A rank other than 0: runs tasks by name until rank 0 tells it to end. `task` returns its text,
/// or nothing if `AtWork` returned false. An error that it throws takes this rank out of the run.
/// `greeting` is called once, likewise.
void serve(
    Channel& channel, const std::function<std::string()>& greeting,
    const std::function<std::optional<std::string>(const std::string&, const AtWork&)>& task);

}  // namespace hybrid
