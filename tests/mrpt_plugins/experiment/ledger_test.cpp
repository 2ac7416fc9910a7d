// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/ledger.h"

#include <sys/resource.h>

#include <algorithm>
#include <csignal>

#include "libhybrid/core/error.h"
#include "tests/support/scratch_folder.h"

namespace hybrid {
namespace {

class LedgerTest : public ScratchFolder {
 protected:
  static Trial trial(std::uint64_t seed) { return {0, "g", "", "gnc", 0.5, seed}; }
  static TrialResult result(double a) {
    TrialResult r;
    r.metrics["a"] = a;
    r.message = "no, \"really\"\nnot";
    return r;
  }
  /// Two rows in results.csv.
  void fill() const {
    Ledger ledger(folder, {"a", "b"});
    ledger.append(trial(2), result(0.1));
    ledger.append(trial(1), result(1e-300));
  }
};

TEST_F(LedgerTest, RemembersRowsOverRuns) {
  fill();
  const Ledger again(folder, {"a", "b"});
  ASSERT_TRUE(again.contains(trial(1)) && again.contains(trial(2)));
  EXPECT_FALSE(again.contains(trial(3)));
  EXPECT_EQ(again.at(trial(2)).metrics.at("a"), 0.1);
  EXPECT_EQ(again.at(trial(1)).metrics.at("a"), 1e-300);
  EXPECT_EQ(again.at(trial(1)).metrics.count("b"), 0u);
  EXPECT_EQ(again.at(trial(1)).message, "no;  really  not");
  EXPECT_THROW(again.at(trial(3)), Error);
}

TEST_F(LedgerTest, PutsRowsInTheOrderOfThePlan) {
  fill();
  const Ledger ledger(folder, {"a", "b"});
  const std::string text = ledger.text({trial(1), trial(5)});
  EXPECT_LT(text.find("g//gnc/0.5/1,"), text.find("g//gnc/0.5/2,"));
  EXPECT_EQ(text.size(), read("results.csv").size());
}

TEST_F(LedgerTest, DropsALineThatWasCutOff) {
  fill();
  const std::string whole = read("results.csv");
  for (std::size_t cut = 1; cut < 40; ++cut) {
    write("results.csv", whole.substr(0, whole.size() - cut));
    {
      Ledger ledger(folder, {"a", "b"});
      EXPECT_TRUE(ledger.contains(trial(2))) << cut;
      ASSERT_FALSE(ledger.contains(trial(1))) << cut;
      ledger.append(trial(1), result(1e-300));
    }
    EXPECT_EQ(read("results.csv"), whole) << cut;
  }
}

TEST_F(LedgerTest, StartsAnewAfterACutInTheHeader) {
  write("results.csv", "trial,gra");
  Ledger ledger(folder, {"a"});
  ledger.append(trial(1), result(2));
  EXPECT_EQ(read("results.csv").rfind("trial,graph,variant,method,outlier_rate,seed,status,a,", 0),
            0u);
}

TEST_F(LedgerTest, ALaterRowReplacesAnEarlierOne) {
  fill();
  {
    Ledger ledger(folder, {"a", "b"});
    TrialResult again = result(0.25);
    again.status = "unfinished";
    ledger.append(trial(2), again);
  }
  const Ledger ledger(folder, {"a", "b"});
  EXPECT_EQ(ledger.at(trial(2)).metrics.at("a"), 0.25);
  EXPECT_FALSE(ledger.at(trial(2)).finished());
  const std::string text = ledger.text({trial(1), trial(2)});
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);  // a row for each
}

TEST_F(LedgerTest, ARowThatCannotBeWrittenLeavesTheFileAsItWas) {
  fill();
  const std::string whole = read("results.csv");
  Ledger ledger(folder, {"a", "b"});
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = whole.size() + 10;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  EXPECT_THROW(ledger.append(trial(3), result(1)), SystemError);
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(read("results.csv"), whole);
  EXPECT_FALSE(ledger.contains(trial(3)));
  ledger.append(trial(3), result(1));
  EXPECT_TRUE(Ledger(folder, {"a", "b"}).contains(trial(3)));
}

TEST_F(LedgerTest, RefusesOtherColumnsAndDamage) {
  fill();
  EXPECT_THROW(Ledger(folder, {"a"}), Error);
  const std::string whole = read("results.csv");
  write("results.csv", whole + "g//gnc/0.5/3,g\n");
  EXPECT_THROW(Ledger(folder, {"a", "b"}), Error);
  write("results.csv", whole + "g//gnc/0.5/3,g,,gnc,0.5,3,ok,many,,,\n");
  EXPECT_THROW(Ledger(folder, {"a", "b"}), Error);
  write("results.csv", whole + "g//gnc/0.5/3,g,,gnc,0.5,3,okk,1,,,\n");
  EXPECT_THROW(Ledger(folder, {"a", "b"}), Error);  // neither done nor to be run
  EXPECT_THROW(Ledger(folder / "absent", {"a"}), Error);
}

}  // namespace
}  // namespace hybrid
