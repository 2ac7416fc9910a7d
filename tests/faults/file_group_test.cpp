// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Every call that changes the disk, and every allocation, goes wrong once in the commit of a group
// of files; and the process is killed there.

#include <iterator>

#include "tests/faults/injection.h"

namespace hybrid {
namespace {

class FileGroupFaults : public InjectionTest {
 protected:
  const Files old_{{"main", "old"}, {"a", "old"}, {"below/b", "old"}, {"notes", "mine"}};
  const Files new_{
      {"main", "new"}, {"a", "new"}, {"c", "new"}, {"below/d", "new"}, {"notes", "mine"}};

  std::string command() const {
    return "commit_driver " + at("out/main") + " main=new a=new c=new below/d=new -below/b";
  }
  /// What a reader of the folder sees.
  Files seen() const {
    Files found = files("out");
    for (auto it = found.begin(); it != found.end();) {
      it = it->first.rfind(".main.part/", 0) == 0 ? found.erase(it) : std::next(it);
    }
    return found;
  }
  /// The next writer, which fails itself, leaves a whole group and nothing temporary.
  void expect_recovery(const Fault& fault) const {
    const Ran next = run_app("commit_driver " + at("out/main") + " a=newer");
    EXPECT_EQ(next.code, 1) << next.text;
    const Files found = files("out");
    EXPECT_TRUE(found == old_ || found == new_) << to_string(fault);
    EXPECT_FALSE(name_exists(folder / "out/.main.part")) << to_string(fault);
  }
};

TEST_F(FileGroupFaults, AFailureLeavesTheOldGroupOrTheNewOne) {
  for (const char* calls : {"disk", "memory"}) {
    Fault fault{calls, "once"};
    set_files("out", old_);
    const long all = count(fault, command());
    ASSERT_GT(all, 30);
    for (const long number : numbers(all, 150)) {
      fault.at = number;
      set_files("out", old_);
      const Ran ran = run_with(fault, command());
      ASSERT_TRUE(ran.code == 0 || ran.code == 1) << to_string(fault) << ": " << ran.text;
      EXPECT_EQ(seen(), ran.code == 0 ? new_ : old_) << to_string(fault) << ": " << ran.text;
      if (ran.code == 1) {
        EXPECT_FALSE(ran.text.empty());
      }
      expect_recovery(fault);
    }
  }
}

TEST_F(FileGroupFaults, ARecoveryThatCannotReadLeavesItToTheNext) {
  const std::string next = "commit_driver " + at("out/main") + " a=newer";
  set_files("out", old_);
  const long all = count({"disk", "once"}, command());
  for (long number = 1; number <= all; ++number) {
    const Fault kill{"disk", "9", number};
    const auto recover = [&](long opening) {
      set_files("out", old_);
      EXPECT_EQ(run_with(kill, command()).code, 128 + 9);
      EXPECT_EQ(run_with({"open", "once", opening}, next).code, 1);
    };
    recover(0);
    const long openings = std::stol(read("calls.txt"));
    for (long opening = 1; opening <= openings; ++opening) {
      recover(opening);
      expect_recovery(kill);
    }
  }
}

TEST_F(FileGroupFaults, ADiskThatStaysFullLeavesTheOldGroup) {
  Fault fault{"space", "on"};
  set_files("out", old_);
  for (const long number : numbers(count(fault, command()), 100)) {
    fault.at = number;
    set_files("out", old_);
    const Ran ran = run_with(fault, command());
    EXPECT_EQ(seen(), ran.code == 0 ? new_ : old_) << to_string(fault) << ": " << ran.text;
    if (ran.code != 0) {
      EXPECT_NE(ran.text.find("No space left"), std::string::npos) << ran.text;
    }
  }
}

TEST_F(FileGroupFaults, KilledAnywhereItIsTheOldGroupTheNewOneOrNoneUntilTheNextWriter) {
  Fault fault{"disk", "9"};
  set_files("out", old_);
  std::size_t none = 0;
  for (const long number : numbers(count(fault, command()), 100)) {
    fault.at = number;
    set_files("out", old_);
    EXPECT_EQ(run_with(fault, command()).code, 128 + 9);
    if (seen().count("main") == 0) {
      ++none;
    } else {
      EXPECT_TRUE(seen() == old_ || seen() == new_) << to_string(fault);
    }
    EXPECT_EQ(seen().at("notes"), "mine");
    expect_recovery(fault);
  }
  EXPECT_GT(none, 0U);  // the moments between the renames were among them
}

}  // namespace
}  // namespace hybrid
