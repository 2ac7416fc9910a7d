// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "libhybrid/uncertainty/agreement.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

/// Clouds once around a hall and a quarter more, a second apart.
class RoundOfClouds {
 public:
  RoundOfClouds() : way_(testing::way_around_hall(0.5)) {
    std::mt19937 random(8);
    for (const SE3& pose : way_) {
      views_.emplace_back(testing::cloud_at(testing::cluttered_hall(), pose, random),
                          Eigen::Vector3f::Zero(), 0.2);
    }
  }
  /// Of a path whose last third is displaced, as by a closure that is false.
  Agreement judge(const SE3& displaced) const {
    std::vector<PlacedCloud> clouds;
    for (std::size_t i = 0; i < way_.size(); ++i) {
      const bool is_late = 3 * i > 2 * way_.size();
      clouds.push_back(
          {static_cast<double>(i), 0, is_late ? displaced * way_[i] : way_[i], &views_[i]});
    }
    return agreement_of_clouds(std::move(clouds), 6);
  }

 private:
  std::vector<SE3> way_;
  std::vector<CloudView> views_;
};

TEST(AgreementOfClouds, IsOneWhereThePathIsRight) {
  const RoundOfClouds round;
  const Agreement right = round.judge(SE3());
  EXPECT_GT(right.looks, 100U);
  EXPECT_NEAR(right.ratio, 1, 0.03);
  EXPECT_GT(right.soon, 0.8);
}

TEST(AgreementOfClouds, FallsWhereAPartOfThePathIsOff) {
  const RoundOfClouds round;
  EXPECT_LT(round.judge(SE3({0.4, 0.3, 0}, SO3())).ratio, 0.9);
  EXPECT_LT(round.judge(SE3({0, 0, 0.4}, SO3())).ratio, 0.97) << "floor and ceiling tell it";
  EXPECT_LT(round.judge(SE3({0, 0, 0}, SO3::exp(Eigen::Vector3d(0, 0, 0.1)))).ratio, 0.9);
}

TEST(AgreementOfClouds, NothingTellsNothing) {
  EXPECT_EQ(agreement_of_clouds({}, 5).looks, 0U);
  const CloudView empty({}, Eigen::Vector3f::Zero(), 0.2);
  EXPECT_EQ(agreement_of_clouds({{0, 0, SE3(), &empty}, {100, 0, SE3(), &empty}}, 5).looks, 0U);
  EXPECT_FALSE(empty.finds({1, 0, 0}, {-1, 0, 0}));
}

TEST(CloudView, KnowsWhatIsThereWhatIsNotAndWhatIsHidden) {
  std::mt19937 random(1);
  const testing::CloudWorld room{{{-4, -3, -1}, {4, 3, 2}}, {{{1.5, -0.5, -1}, {2, 0.5, 1}}}};
  const CloudView view(testing::cloud_at(room, SE3(), random), Eigen::Vector3f::Zero(), 0.2);
  EXPECT_EQ(view.finds({1.5F, 0, 0}, {-1, 0, 0}), true);
  EXPECT_EQ(view.finds({-2, 0.5F, 0}, {1, 0, 0}), false) << "rays go through";
  EXPECT_EQ(view.finds({3, 0, 0}, {-1, 0, 0}), std::nullopt) << "behind the box";
  EXPECT_EQ(view.finds({0, 0, 50}, {0, 0, -1}), std::nullopt) << "no ray goes up so far";
}

}  // namespace
}  // namespace hybrid
