// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/plugin_tag.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "libhybrid/io/regular_file.h"

namespace hybrid {
namespace {

/// The library of this project, which has the tag of this version.
std::string own_library() {
  Dl_info place{};
  EXPECT_NE(::dladdr(reinterpret_cast<const void*>(&find_plugin_tag), &place), 0);
  return read_file(place.dli_fname);
}

TEST(PluginTag, IsReadFromTheFile) {
  const auto tag = find_plugin_tag(own_library());
  ASSERT_TRUE(tag);
  EXPECT_EQ(std::memcmp(&*tag, &hybrid_plugin_abi, sizeof(PluginAbi)), 0);
}

TEST(PluginTag, IsNotInOtherFiles) {
  for (const char* text : {"", "#!/bin/sh", "\x7f\x45LF", "hybrid_plugin_abi"}) {
    EXPECT_FALSE(find_plugin_tag(text)) << text;
  }
  Dl_info place{};
  ASSERT_NE(::dladdr(reinterpret_cast<const void*>(&std::memmove), &place), 0);
  EXPECT_FALSE(find_plugin_tag(read_file(place.dli_fname)));  // the C library
}

// With the address sanitizer: nothing beyond the end is read.
TEST(PluginTag, DamagedLibrariesAreRead) {
  const std::string whole = own_library();
  for (int eighths = 0; eighths < 8; ++eighths) {
    const std::string cut = whole.substr(0, whole.size() * eighths / 8);
    EXPECT_FALSE(find_plugin_tag(cut)) << eighths;  // the table of sections is at the end
  }
  std::mt19937 random(1);
  std::string damaged = whole;
  for (int i = 0; i < 200; ++i) {
    const std::size_t header = 64;
    const std::size_t table = damaged.size() - 40 * 64;  // of sections
    const std::size_t at = i % 2 == 0 ? 16 + random() % (header - 16) : table + random() % 2560;
    const char before = damaged[at];
    damaged[at] = static_cast<char>(random());
    find_plugin_tag(damaged);
    damaged[at] = before;
  }
}

}  // namespace
}  // namespace hybrid
