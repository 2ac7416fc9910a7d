// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// A factor of the user that throws in an update of a window.
#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "libhybrid/smoother/window.h"
#include "tests/support/changing_world.h"
#include "tests/support/fragile_factor.h"

namespace hybrid {
namespace {

/// A window over a path whose factors are fragile.
class FragileWalk {
 public:
  FragileWalk() : window_(options()) {}
  WindowReport step() {
    Delta delta;
    if (next_ == 0) {
      delta.values.insert(testing::pose(0), SE2());
      delta.continuous.push_back(
          std::make_shared<Prior<SE2>>(testing::pose(0), SE2(), Noise::isotropic(3, 0.01)));
    } else {
      const SE2 z(1.0, 0.02 * (next_ % 3), 0.2);
      delta.values.insert(testing::pose(next_),
                          window_.smoother().values().at<SE2>(testing::pose(next_ - 1)) * z);
      for (double sigma : {0.1, 0.2}) {
        const auto factor = testing::between(next_ - 1, next_, z, sigma);
        delta.continuous.push_back(std::make_shared<testing::FragileFactor>(factor, fuse_));
      }
    }
    const WindowReport report = window_.update(delta);
    ++next_;
    return report;
  }
  std::vector<double> numbers() const {
    std::vector<double> all = testing::state(window_.smoother());
    for (Key key : window_.past().values.keys()) {
      const double* x = window_.past().values.data(key);
      all.insert(all.end(), x, x + window_.past().values.type(key).size);
    }
    return all;
  }
  testing::Fuse& fuse() { return *fuse_; }

 private:
  static WindowOptions options() {
    WindowOptions options;
    options.mode = WindowOptions::Mode::kFixedLag;
    options.lag = 2;
    return options;
  }
  WindowSmoother window_;
  std::shared_ptr<testing::Fuse> fuse_ = std::make_shared<testing::Fuse>();
  int next_ = 0;
};

TEST(WindowFailures, AnUpdateIsTakenOrRefusedAndDeparturesWait) {
  int refused = 0, waited = 0;
  FragileWalk walk;
  for (int k = 0; k < 8; ++k) {
    for (int n = 1;; ++n) {
      SCOPED_TRACE("step " + std::to_string(k) + ", use " + std::to_string(n));
      FragileWalk struck = walk;
      struck.fuse().arm(n);
      bool thrown = false;
      WindowReport report;
      try {
        report = struck.step();
      } catch (const std::domain_error&) {
        thrown = true;
      }
      struck.fuse().disarm();
      if (thrown) {
        ++refused;
        ASSERT_EQ(struck.numbers(), walk.numbers());
        FragileWalk spared = walk;
        for (int more = 0; more < 3; ++more) {
          spared.step();
          struck.step();
          ASSERT_EQ(struck.numbers(), spared.numbers());
        }
        continue;
      }
      if (report.kept.empty()) break;
      ++waited;
      EXPECT_NE(report.kept_because.find("a factor of the user threw"), std::string::npos);
      EXPECT_EQ(struck.step().left.size(), 2u);  // what waited and what is due
    }
    walk.step();
  }
  EXPECT_GT(refused, 10);
  EXPECT_GT(waited, 3);
}

}  // namespace
}  // namespace hybrid
