// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/vertex_id.h"

#include <gtest/gtest.h>

#include "libhybrid/core/key.h"

namespace hybrid {
namespace {

TEST(VertexName, IsThatOfGtsamOrTheNumber) {
  const std::int64_t b79 = (std::int64_t{'b'} << 56) + 79;
  const std::int64_t aB6 = (std::int64_t{'a'} << 56) + (std::int64_t{'B'} << 48) + 6;
  const std::int64_t plain = kLargestPlainId;
  const std::int64_t odd = (std::int64_t{1} << 56) + 6;  // its character cannot be printed
  EXPECT_EQ(vertex_name(*vertex_index(b79)), "b79");
  EXPECT_EQ(vertex_name(*vertex_index(aB6)), "aB6");
  EXPECT_EQ(vertex_name(*vertex_index(plain)), std::to_string(plain));
  EXPECT_EQ(vertex_name(*vertex_index(odd)), std::to_string(odd));
  EXPECT_EQ(vertex_name(5), "5");
}

TEST(VertexName, ReplacesKeysInMessages) {
  const Key key('x', *vertex_index((std::int64_t{'b'} << 56) + 6));
  const Key landmark('l', *vertex_index((std::int64_t{'l'} << 56) + 3));
  EXPECT_EQ(with_vertex_names("leave " + to_string(key) + ", " + to_string(landmark) + ", x7"),
            "leave b6, l3, x7");
  for (const std::string text : {"", "x", "max36028797018963968x", "0x36028797018963969",
                                 "x99999999999999999999999999", "limit 3e4"}) {
    EXPECT_EQ(with_vertex_names(text), text);
  }
}

}  // namespace
}  // namespace hybrid
