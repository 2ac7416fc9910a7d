// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A labelled series, a log of ranges, or its true points, as hybrid-switching
// reads them.

#include "apps/hybrid-switching/labelled_table.h"
#include "apps/hybrid-switching/range_log.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Folder folder;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string path = folder.write("a.txt", text);
  fuzz::allow_error([&] {
    if (!is_range_log(path)) return void(read_table(path, Options()));
    const RangeLog log = read_range_log(path);
    fuzz::expect(!log.ranges.empty() && !log.odometry.empty());
  });
  fuzz::allow_error([&] { read_true_points(path); });
  return 0;
}
