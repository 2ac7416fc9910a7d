// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Calls that change the disk and allocations go wrong, one at a time, in a replay over an older
// result: the folder holds one of the two results afterwards, and the exit code says which.

#include <array>
#include <csignal>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <vector>

#include "mrpt_plugins/bridge/sha256.h"
#include "tests/faults/injection.h"

namespace hybrid {
namespace {

class ReplayFaults : public InjectionTest {
 protected:
  /// A log of one round with a frame every `step` metres.
  void simulate(const std::string& name, const std::string& step) const {
    write(name + ".ini", "[world]\nlandmarks = 6\n[path]\nlaps = 1\nradius = 5\nstep = " + step +
                             "\n[sensor]\nmax_range = 100\n");
    const Ran ran =
        run_app("hybrid-simulate -c " + at(name + ".ini") + " -o " + at(name + ".rawlog"));
    ASSERT_EQ(ran.code, 0) << ran.text;
  }
  std::string command(const std::string& log) const {
    return "hybrid-replay --no-pictures -c " HYBRID_SOURCE_DIR "/config/classed_demo.ini" +
           std::string(" --set log.truth_path= --set log.truth_map= --rawlog ") +
           at(log + ".rawlog") + " -o " + at("out");
  }
  void SetUp() override {
    InjectionTest::SetUp();
    if (IsSkipped()) return;
    simulate("short", "4");
    simulate("long", "2.6");
    ASSERT_EQ(run_app(command("short")).code, 0);
    old_ = files("out");
    frames_old_ = frames();
    ASSERT_EQ(run_app(command("long")).code, 0);
    frames_new_ = frames();
    ASSERT_LT(frames_old_, frames_new_);
  }
  int frames() const { return nlohmann::json::parse(read("out/summary.json"))["keyframes"]; }
  /// Number of keyframes of the result in the folder, which must be whole and alone but for
  /// `others` and what is hidden.
  int whole_result(const std::set<std::string>& others = {}) const {
    const auto summary = nlohmann::json::parse(read("out/summary.json"), nullptr, false);
    EXPECT_FALSE(summary.is_discarded());
    if (summary.is_discarded()) return 0;
    std::set<std::string> listed{"summary.json"};
    for (const auto& file : summary["files"]) {
      const std::string name = file["path"];
      listed.insert(name);
      EXPECT_EQ(file["sha256"], sha256_of_file(folder / "out" / name)) << name;
    }
    for (const auto& [name, text] : files("out")) {
      EXPECT_TRUE(name[0] == '.' || listed.count(name) != 0 || others.count(name) != 0) << name;
    }
    return summary["keyframes"];
  }
  /// Runs with a fault over the old result, which `others` may accompany.
  void expect_old_or_new(const Fault& fault, const Files& others = {}) const {
    Files before = old_;
    before.insert(others.begin(), others.end());
    set_files("out", before);
    const Ran ran = run_with(fault, command("long"));
    ASSERT_TRUE(ran.code == 0 || ran.code == 1 || ran.code == 2)
        << to_string(fault) << ": " << ran.code << " " << ran.text;
    std::set<std::string> names;
    for (const auto& [name, text] : others) {
      names.insert(name);
      EXPECT_EQ(read("out/" + name), text);
    }
    if (ran.code == 1) {
      Files after = files("out");
      for (auto it = after.begin(); it != after.end();) {
        it = it->first[0] == '.' ? after.erase(it) : std::next(it);
      }
      EXPECT_EQ(after, before) << to_string(fault) << ": " << ran.text;
      EXPECT_EQ(std::count(ran.text.begin(), ran.text.end(), '\n'), 1) << ran.text;
      EXPECT_EQ(ran.text.rfind("hybrid-replay: ", 0), 0U) << ran.text;
    } else {
      const int frames = whole_result(names);
      if (ran.code == 0) {
        EXPECT_EQ(frames, frames_new_) << to_string(fault);
      }
    }
    leftovers(fault);
  }
  /// The same at all calls, or at `most` of them.
  void expect_old_or_new_at_calls(Fault fault, std::size_t most, const Files& others = {}) const {
    for (const long number : numbers(count(fault, command("long")), most)) {
      fault.at = number;
      expect_old_or_new(fault, others);
    }
  }
  /// Nothing temporary survives the next run.
  void leftovers(const Fault& fault) const {
    const auto has_hidden = [&] {
      for (const FolderEntry& entry : entries_of(folder)) {
        if (entry.name[0] == '.') return true;
      }
      return name_exists(folder / "out/.summary.json.part");
    };
    if (!has_hidden()) return;
    EXPECT_EQ(run_app(command("long")).code, 0);
    EXPECT_FALSE(has_hidden()) << to_string(fault);
    EXPECT_EQ(frames(), frames_new_);
  }

  Files old_;
  int frames_old_ = 0, frames_new_ = 0;
};

TEST_F(ReplayFaults, ACallOfTheDiskThatFails) {
  expect_old_or_new_at_calls({"disk", "once"}, 60);
}

TEST_F(ReplayFaults, ACallOfTheDiskThatFailsBesideFilesOfOthers) {
  set_files("out", {{"notes.txt", "mine"}});
  expect_old_or_new_at_calls({"disk", "once"}, 60, {{"notes.txt", "mine"}});
}

TEST_F(ReplayFaults, AFileThatDoesNotOpen) {
  expect_old_or_new_at_calls({"open", "once"}, 60);
}

TEST_F(ReplayFaults, ADiskThatStaysFull) {
  expect_old_or_new_at_calls({"space", "on"}, 40);
}

TEST_F(ReplayFaults, AnAllocationThatFails) {
  expect_old_or_new_at_calls({"memory", "once"}, 100);
}

TEST_F(ReplayFaults, KilledAtAnyCallOfTheDiskItIsTheOldResultOrTheNewOne) {
  Fault fault{"disk", "9"};
  for (const long number : numbers(count(fault, command("long")), 60)) {
    fault.at = number;
    set_files("out", old_);
    EXPECT_EQ(run_with(fault, command("long")).code, 128 + 9);
    const int frames = whole_result();
    EXPECT_TRUE(frames == frames_old_ || frames == frames_new_) << to_string(fault);
    leftovers(fault);
  }
}

TEST_F(ReplayFaults, ASignalAtAnyMomentGivesThePartialResultOrLeavesTheOldOne) {
  Fault fault{"memory", ""};
  const long all = count({"memory", "once"}, command("long"));
  const std::array<int, 3> signals = {SIGINT, SIGTERM, SIGHUP};
  const std::vector<long> moments = numbers(all, 36);  // a third of which are while it maps
  std::size_t interrupted = 0;
  for (std::size_t s = 0; s < signals.size(); ++s) {
    const int signal = signals[s];
    fault.how = std::to_string(signal);
    for (std::size_t k = s; k < moments.size(); k += signals.size()) {
      fault.at = moments[k];
      set_files("out", old_);
      const Ran ran = run_with(fault, command("long"));
      const int frames = whole_result();
      if (ran.code == 0) {  // it came when the log was at its end
        EXPECT_EQ(frames, frames_new_) << to_string(fault);
        continue;
      }
      EXPECT_EQ(ran.code, 128 + signal) << to_string(fault) << ": " << ran.text;
      const auto summary = nlohmann::json::parse(read("out/summary.json"));
      if (summary["status"] == "ok") {  // before the first keyframe
        EXPECT_EQ(frames, frames_old_) << to_string(fault);
        continue;
      }
      ++interrupted;
      EXPECT_EQ(summary["status"], "interrupted");
      EXPECT_LT(frames, frames_new_);
    }
  }
  EXPECT_GT(interrupted, 0U);
}

}  // namespace
}  // namespace hybrid
