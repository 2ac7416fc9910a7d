// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/hybrid/graph.h"
#include "tests/libhybrid/factors/user_factor_example.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::expect_jacobians;
using testing::expect_robust_gradient;

TEST(UserFactor, Jacobians) {
  testing::Random random{51};
  for (int trial = 0; trial < 10; ++trial) {
    Values values;
    values.insert(Key('x', 0), random.value<SE2>());
    const Eigen::Vector2d normal = random.vector<2>().normalized();
    const Noise noise = Noise::isotropic(1, 0.1);
    expect_jacobians(WallDistance(Key('x', 0), normal, 5.0, 4.0, noise), values);
    expect_robust_gradient(WallDistance(Key('x', 0), normal, 5.0, 4.0, noise, Loss::huber()),
                           values);
  }
}

TEST(UserFactor, MeasuresTheDistance) {
  const WallDistance factor(Key('x', 0), {1.0, 0.0}, 5.0, 3.0, Noise::unit(1));
  EXPECT_NEAR(factor.evaluate({2.0, 7.0, 1.0}, nullptr)[0], 0.0, 1e-15);
}

TEST(UserFactor, GoesIntoAGraph) {
  HybridGraph graph;
  const Eigen::Vector2d normal(1.0, 0.0);
  graph.emplace<WallDistance>(Key('x', 3), normal, 5.0, 4.98, Noise::isotropic(1, 0.02));
  EXPECT_EQ(graph.continuous().size(), 1u);
}

TEST(UserFactor, MisuseNamesItsVariables) {
  const Key x('x', 3);
  try {
    WallDistance(x, {1.0, 0.0}, 5.0, 3.0, Noise::unit(2));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "a factor on x3: noise of dimension 2 for a residual of 1");
  }
  Values values;
  values.insert(x, SE3());
  try {
    WallDistance(x, {1.0, 0.0}, 5.0, 3.0, Noise::unit(1)).cost(values);
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "variable x3 is SE3, but a factor on x3 takes it as SE2");
  }
}

std::string read(const std::string& path) {
  std::ifstream in(std::string(HYBRID_SOURCE_DIR) + "/" + path);
  EXPECT_TRUE(in) << path;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

TEST(UserFactor, DocumentationQuotesTheExample) {
  const std::string mark = "// [example]\n";
  const std::string source = read("tests/libhybrid/factors/user_factor_example.h");
  const std::size_t begin = source.find(mark) + mark.size();
  const std::string example = source.substr(begin, source.rfind(mark) - begin);
  ASSERT_GT(example.size(), 500u);
  EXPECT_NE(read("docs/writing_a_factor.md").find("```cpp\n" + example + "```"), std::string::npos);
}

}  // namespace
}  // namespace hybrid
