// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/ranks.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <thread>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace hybrid {
namespace {

// The first word of a message. To rank 0: hello HOST\nGREETING, done TEXT, alive, failed TEXT, bye.
// From rank 0: run TASK, stop.
constexpr const char* kHello = "hello";
constexpr const char* kDone = "done";
constexpr const char* kAlive = "alive";
constexpr const char* kFailed = "failed";
constexpr const char* kBye = "bye";
constexpr const char* kRun = "run";
constexpr const char* kStop = "stop";

constexpr std::chrono::milliseconds kPause(2);         // between looks for messages
constexpr std::chrono::milliseconds kHeartbeat(500);   // between messages of a rank
constexpr std::chrono::milliseconds kFarewell(10000);  // how long rank 0 waits for the others' end

std::pair<std::string, std::string> first_word(const std::string& text) {
  const std::size_t space = std::min(text.find(' '), text.size());
  return {text.substr(0, space), text.substr(std::min(space + 1, text.size()))};
}

/// The first line that only one of two texts has, as "'a' there, 'b' here".
std::string difference(const std::string& there, const std::string& here) {
  std::istringstream a(there), b(here);
  std::string x, y;
  do {
    if (!std::getline(a, x)) x = "nothing more";
    if (!std::getline(b, y)) y = "nothing more";
  } while (x == y && (a || b));
  return fmt::format("'{}' there, '{}' here", x, y);
}

}  // namespace

Workers::Workers(Channel& channel)
    : channel_(channel), workers_(static_cast<std::size_t>(channel.size())) {
  workers_.front().state = Worker::State::kGone;
}

Workers::~Workers() {
  try {
    stop();
  } catch (const std::exception&) {
    channel_.leave();  // the launcher ends what is left
  }
}

bool Workers::all_gone() const {
  return std::all_of(workers_.begin(), workers_.end(),
                     [](const Worker& w) { return w.state >= Worker::State::kLost; });
}

std::size_t Workers::give_up(Worker& worker, Worker::State state, const std::string& why,
                             const Events& events) {
  const bool busy = worker.state == Worker::State::kBusy;
  worker.state = state;
  reason_ = why;
  events.refused(why);
  if (busy) events.lost(worker.task, why);
  return busy ? 1 : 0;
}

void Workers::greet(int rank, const std::string& text, const std::string& greeting,
                    const Events& events) {
  Worker& worker = workers_[static_cast<std::size_t>(rank)];
  const std::size_t end = std::min(text.find('\n'), text.size());
  worker.host = text.substr(0, end);
  worker.state = Worker::State::kIdle;
  const std::string theirs = text.substr(std::min(end + 1, text.size()));
  if (theirs == greeting) return;
  give_up(worker, Worker::State::kRefused,
          fmt::format("rank {} on {} takes no part, its settings, files or version differ: {}",
                      rank, worker.host, difference(theirs, greeting)),
          events);
}

std::size_t Workers::read(const Channel::Message& message, const std::string& greeting,
                          const Events& events) {
  using State = Worker::State;
  Worker& worker = workers_.at(static_cast<std::size_t>(message.from));
  const auto [word, rest] = first_word(message.text);
  worker.heard = Clock::now();
  if (word == kHello) {
    greet(message.from, rest, greeting, events);
  } else if (word == kDone) {
    const bool awaited = worker.state == State::kBusy;
    worker.state = State::kIdle;
    events.done(worker.task, rest);
    return awaited ? 1 : 0;
  } else if (word == kFailed) {
    return give_up(worker, State::kRefused,
                   fmt::format("rank {} takes no part: {}", message.from, rest), events);
  } else if (word == kBye) {
    return give_up(worker, State::kGone, fmt::format("rank {} was ended", message.from), events);
  }
  return 0;
}

std::size_t Workers::give_up_silent(double silence, const Events& events) {
  std::size_t ended = 0;
  for (std::size_t r = 1; r < workers_.size(); ++r) {
    Worker& worker = workers_[r];
    const std::chrono::duration<double> silent = Clock::now() - worker.heard;
    if (worker.state >= Worker::State::kLost || silent.count() <= silence) continue;
    ended += give_up(worker, Worker::State::kLost,
                     fmt::format("rank {}{}{} has said nothing for {:g} s", r,
                                 worker.host.empty() ? "" : " on ", worker.host, silence),
                     events);
  }
  return ended;
}

void Workers::run(const std::vector<std::string>& tasks, const std::string& greeting,
                  double silence, const Events& events) {
  std::size_t next = 0, open = tasks.size();
  while (open > 0 && !(events.stop && events.stop())) {
    bool heard = false;
    while (const auto message = channel_.receive()) {
      open -= read(*message, greeting, events);
      heard = true;
    }
    for (std::size_t r = 1; r < workers_.size() && next < tasks.size(); ++r) {
      Worker& worker = workers_[r];
      if (worker.state != Worker::State::kIdle) continue;
      channel_.send(static_cast<int>(r), std::string(kRun) + " " + tasks[next]);
      worker.state = Worker::State::kBusy;
      worker.task = next++;
      worker.heard = Clock::now();
    }
    open -= give_up_silent(silence, events);
    if (open > 0 && all_gone()) {
      throw Error(
          fmt::format("no rank is left for {} trials: {}; run again to go on", open, reason_));
    }
    if (!heard) std::this_thread::sleep_for(kPause);
  }
}

void Workers::stop() {
  for (std::size_t r = 1; r < workers_.size(); ++r) {
    const Worker::State state = workers_[r].state;
    if (state == Worker::State::kGone || state == Worker::State::kLost) continue;
    channel_.send(static_cast<int>(r), kStop);
  }
  const auto all_ended = [&] {
    return std::all_of(workers_.begin(), workers_.end(),
                       [](const Worker& w) { return w.state == Worker::State::kGone; });
  };
  const auto lost = [](const Worker& w) { return w.state == Worker::State::kLost; };
  const auto patience =
      std::any_of(workers_.begin(), workers_.end(), lost) ? kHeartbeat : kFarewell;
  const Clock::time_point end = Clock::now() + patience;
  while (!all_ended() && Clock::now() < end) {
    const auto message = channel_.receive();
    if (!message) {
      std::this_thread::sleep_for(kPause);
    } else if (message->text == kBye) {
      workers_.at(static_cast<std::size_t>(message->from)).state = Worker::State::kGone;
    }
  }
  if (!all_ended()) channel_.leave();
}

void serve(
    Channel& channel, const std::function<std::string()>& greeting,
    const std::function<std::optional<std::string>(const std::string&, const AtWork&)>& task) {
  using Clock = std::chrono::steady_clock;
  const auto tell = [&](const std::string& text) { channel.send(0, text); };
  const auto failing = [&](const auto& step) {
    try {
      step();
    } catch (const std::exception& e) {
      tell(std::string(kFailed) + " on " + channel.host() + ": " + e.what());
    }
  };
  failing([&] {
    const std::string text = greeting();
    tell(std::string(kHello) + " " + channel.host() + "\n" + text);
  });
  bool stopped = false;
  Clock::time_point told = Clock::now();
  const auto say_alive = [&] {
    if (stopped || Clock::now() - told < kHeartbeat) return;
    tell(kAlive);
    told = Clock::now();
  };
  const AtWork at_work = [&] {
    if (const auto message = channel.receive()) stopped = stopped || message->text == kStop;
    say_alive();
    return !stopped && interrupted() == 0;
  };
  while (!stopped && interrupted() == 0) {
    say_alive();
    const auto message = channel.receive();
    if (!message) {
      std::this_thread::sleep_for(kPause);
      continue;
    }
    const auto [word, rest] = first_word(message->text);
    stopped = word == kStop;
    if (word != kRun) continue;
    failing([&, name = rest] {
      if (const auto text = task(name, at_work)) tell(std::string(kDone) + " " + *text);
    });
  }
  tell(kBye);
}

}  // namespace hybrid
