// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/paced_task.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>

#include "libhybrid/core/infinity.h"

namespace hybrid {
namespace {

TEST(PacedTask, PausesOnceItsWorkIsNoted) {
  int steps = 0;
  PacedTask task([&] {
    for (; steps < 10; ++steps) note_work(10.0);
  });
  EXPECT_EQ(steps, 0);
  EXPECT_FALSE(task.advance(25.0));
  EXPECT_EQ(steps, 2);  // in the third, which brings its work to 30
  EXPECT_FALSE(task.advance(3.0));
  EXPECT_EQ(steps, 2);  // 28 allowed so far
  EXPECT_FALSE(task.advance(3.0));
  EXPECT_EQ(steps, 3);
  EXPECT_TRUE(task.advance(kInfinity));
  EXPECT_EQ(steps, 10);
  EXPECT_TRUE(task.advance(1.0));
}

TEST(PacedTask, NotesWorkByThread) {
  const double before = noted_work();
  note_work(5.0);
  PacedTask task([] { note_work(100.0); });
  EXPECT_TRUE(task.advance(kInfinity));
  EXPECT_EQ(noted_work(), before + 5.0);
}

TEST(PacedTask, ThrowsWhatItsFunctionThrows) {
  PacedTask task([] {
    note_work(1.0);
    throw std::runtime_error("no map");
  });
  EXPECT_FALSE(task.advance(0.5));
  EXPECT_THROW(task.advance(10.0), std::runtime_error);
  EXPECT_TRUE(task.advance(10.0));
}

TEST(PacedTask, EndsWhereItHasPaused) {
  bool went_on = false, ended = false;
  {
    PacedTask task([&] {
      const std::shared_ptr<void> guard(nullptr, [&](void*) { ended = true; });
      try {
        note_work(2.0);
      } catch (const std::exception&) {
        went_on = true;
      }
      note_work(2.0);
      went_on = true;
    });
    EXPECT_FALSE(task.advance(1.0));
    EXPECT_FALSE(ended);
  }
  EXPECT_TRUE(ended);
  EXPECT_FALSE(went_on);
  PacedTask never([&] { went_on = true; });
}

TEST(PacedTask, EndsThoughItsFunctionGoesOn) {
  int caught = 0;
  {
    PacedTask task([&] {
      for (int i = 0; i < 3; ++i) {
        try {
          note_work(1.0);
        } catch (...) {
          ++caught;
        }
      }
    });
    EXPECT_FALSE(task.advance(0.5));
  }
  EXPECT_EQ(caught, 3);
}

}  // namespace
}  // namespace hybrid
