// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Pose graphs: what can be read can be written, and then reads as the same.

#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "tests/fuzz/targets/fuzz_input.h"

using namespace hybrid;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::allow_error([&] {
    const PoseGraph graph = parse_graph(text, "graph");
    const std::string written = to_g2o(graph);
    const PoseGraph again = parse_graph(written, "written");
    fuzz::expect(again.edge_count() == graph.edge_count());
    fuzz::expect(again.values.size() == graph.values.size());
    fuzz::allow_error([&] { to_factors(graph, initialize_from_odometry(graph)); });
  });
  return 0;
}
