// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/ranks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "libhybrid/core/error.h"

namespace hybrid {
namespace {

using Tasks = std::vector<std::string>;

constexpr double kForever = 1e6;  // s

/// Mailboxes of ranks that are threads of this process.
struct Post {
  explicit Post(int ranks) : boxes(static_cast<std::size_t>(ranks)) {}
  std::mutex mutex;
  std::vector<std::deque<Channel::Message>> boxes;
  std::set<int> left;
};

class ThreadChannel : public Channel {
 public:
  ThreadChannel(Post& post, int rank) : post_(post), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return static_cast<int>(post_.boxes.size()); }
  std::string host() const override { return "host" + std::to_string(rank_); }
  void send(int to, const std::string& text) override {
    const std::lock_guard lock(post_.mutex);
    post_.boxes.at(static_cast<std::size_t>(to)).push_back({rank_, text});
  }
  std::optional<Message> receive() override {
    const std::lock_guard lock(post_.mutex);
    auto& box = post_.boxes[static_cast<std::size_t>(rank_)];
    if (box.empty()) return std::nullopt;
    const Message message = box.front();
    box.pop_front();
    return message;
  }
  void leave() override {
    const std::lock_guard lock(post_.mutex);
    post_.left.insert(rank_);
  }

 private:
  Post& post_;
  int rank_;
};

/// What rank 0 heard.
struct Heard {
  std::map<std::size_t, std::string> done, lost;
  Tasks refused;
  std::set<int> left;                                ///< ranks that do not wait for the others
  std::vector<std::deque<Channel::Message>> unread;  ///< by rank

  Workers::Events events() {
    return {[this](std::size_t i, const std::string& text) { done[i] = text; },
            [this](std::size_t i, const std::string& why) { lost[i] = why; },
            [this](const std::string& why) { refused.push_back(why); },
            {}};
  }
};

using Serve = std::function<void(Channel&)>;
using Task = std::function<std::optional<std::string>(const std::string&, const AtWork&)>;

/// A rank that runs `task`.
Serve worker(Task task, std::string greeting = "a=1\n") {
  return [task = std::move(task), greeting = std::move(greeting)](Channel& channel) {
    serve(
        channel, [&] { return greeting; }, task);
  };
}

std::optional<std::string> shout(const std::string& task, const AtWork& /*at_work*/) {
  return task + "!\nsecond line";
}

/// Runs tasks on these workers, ranks 1 and following; rethrows the error of rank 0.
void run(const std::vector<Serve>& workers, const Tasks& tasks, double silence, Heard& heard) {
  Post post(static_cast<int>(workers.size()) + 1);
  std::vector<std::thread> threads;
  for (std::size_t r = 0; r < workers.size(); ++r) {
    threads.emplace_back([&, r] {
      ThreadChannel channel(post, static_cast<int>(r) + 1);
      workers[r](channel);
    });
  }
  std::exception_ptr error;
  try {
    ThreadChannel channel(post, 0);
    Workers others(channel);
    others.run(tasks, "a=1\n", silence, heard.events());
  } catch (...) {
    error = std::current_exception();
  }
  for (std::thread& thread : threads) thread.join();
  heard.left = post.left;
  heard.unread = post.boxes;
  if (error) std::rethrow_exception(error);
}

Tasks many(int count) {
  Tasks tasks;
  for (int i = 0; i < count; ++i) tasks.push_back("graph//method/0/" + std::to_string(i));
  return tasks;
}

TEST(Ranks, RunEveryTaskOnce) {
  const Tasks tasks = many(200);
  for (const std::size_t workers : {1U, 3U}) {
    Heard heard;
    run(std::vector<Serve>(workers, worker(shout)), tasks, kForever, heard);
    ASSERT_EQ(heard.done.size(), tasks.size());
    for (const auto& [i, text] : heard.done) EXPECT_EQ(text, tasks[i] + "!\nsecond line");
    EXPECT_TRUE(heard.lost.empty());
    EXPECT_TRUE(heard.refused.empty());
    EXPECT_TRUE(heard.left.empty());
  }
}

TEST(Ranks, EndWithoutTasks) {
  Heard heard;
  run({worker(shout), worker(shout)}, {}, kForever, heard);
  EXPECT_TRUE(heard.done.empty());
  EXPECT_TRUE(heard.left.empty());
}

TEST(Ranks, RefuseOtherSettings) {
  Heard heard;
  run({worker(shout, "a=2\n"), worker(shout)}, many(5), kForever, heard);
  EXPECT_EQ(heard.done.size(), 5U);
  ASSERT_EQ(heard.refused.size(), 1U);
  EXPECT_NE(heard.refused.front().find("rank 1 on host1"), std::string::npos);
  EXPECT_NE(heard.refused.front().find("'a=2' there, 'a=1' here"), std::string::npos);
  Heard nobody;
  try {
    run({worker(shout, "a=1\nb=3\n")}, many(5), kForever, nobody);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("'b=3' there, 'nothing more' here"), std::string::npos);
    EXPECT_NE(std::string(e.what()).find("5 trials"), std::string::npos) << e.what();
  }
}

TEST(Ranks, OneThatFailsLosesOnlyItsTask) {
  const Serve fails = worker([](const std::string&, const AtWork&) -> std::optional<std::string> {
    throw std::runtime_error("no such graph");
  });
  Heard heard;
  run({fails, worker(shout)}, many(20), kForever, heard);
  EXPECT_LE(heard.lost.size(), 1U);  // none if the other one ran all of them first
  EXPECT_EQ(heard.done.size() + heard.lost.size(), 20U);
  for (const auto& [i, why] : heard.lost) {
    EXPECT_EQ(heard.done.count(i), 0U);
    EXPECT_NE(why.find("on host1: no such graph"), std::string::npos) << why;
  }
  Heard nobody;
  EXPECT_THROW(run({fails}, many(2), kForever, nobody), Error);
  EXPECT_EQ(nobody.lost.size(), 1U);
}

/// A rank that dies with its first task.
void die(Channel& channel) {
  channel.send(0, "hello dead\na=1\n");
  while (!channel.receive()) std::this_thread::yield();
}

TEST(Ranks, OneThatDiesLosesOnlyItsTask) {
  Heard heard;
  run({die, worker(shout)}, many(20), 0.2, heard);
  EXPECT_EQ(heard.done.size(), 19U);
  ASSERT_EQ(heard.lost.size(), 1U);
  EXPECT_NE(heard.lost.begin()->second.find("rank 1 on dead has said nothing"), std::string::npos);
  EXPECT_EQ(heard.left, std::set<int>{0});  // nobody waits for the dead
  EXPECT_TRUE(heard.unread[1].empty());     // nor sends to it: some networks wait for ever
  Heard nobody;
  EXPECT_THROW(run({die}, many(2), 0.2, nobody), Error);
}

TEST(Ranks, OneThatDiesWithoutATaskIsLost) {
  // Both have greeted; the last one says nothing more while the other runs the only task.
  const auto long_one = [](const std::string& task, const AtWork& at_work) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::seconds(2)) {
      EXPECT_TRUE(at_work());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return std::optional<std::string>(task);
  };
  const auto late = [](Channel& channel) {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    channel.send(0, "hello dead\na=1\n");
  };
  Heard heard;
  run({worker(long_one), late}, {"a"}, 1.0, heard);
  EXPECT_EQ(heard.done.size(), 1U);
  ASSERT_EQ(heard.refused.size(), 1U);
  EXPECT_TRUE(heard.unread[2].empty());
}

TEST(Ranks, OneThatIsAtWorkMayTakeLong) {
  // Longer than the silence that is allowed, with a sign of life.
  const double silence = 1.0;
  const auto slow = [&](const std::string& task, const AtWork& at_work) {
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::duration<double>(2 * silence)) {
      EXPECT_TRUE(at_work());
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return std::optional<std::string>(task);
  };
  Heard heard;
  run({worker(slow)}, many(1), silence, heard);
  EXPECT_EQ(heard.done.size(), 1U);
  EXPECT_TRUE(heard.lost.empty());
}

TEST(Ranks, StopEndsRunningTasks) {
  Post post(2);
  std::thread other([&] {
    ThreadChannel channel(post, 1);
    worker([](const std::string&, const AtWork& at_work) -> std::optional<std::string> {
      while (at_work()) std::this_thread::yield();
      return std::nullopt;
    })(channel);
  });
  Heard heard;
  {
    ThreadChannel channel(post, 0);
    Workers workers(channel);
    Workers::Events events = heard.events();
    int looks = 0;
    events.stop = [&] { return ++looks > 20; };
    workers.run(many(3), "a=1\n", kForever, events);
  }
  other.join();
  EXPECT_TRUE(heard.done.empty());
  EXPECT_TRUE(post.left.empty());
}

}  // namespace
}  // namespace hybrid
