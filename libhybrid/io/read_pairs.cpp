// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/read_pairs.h"

#include "libhybrid/io/detail/graph_row.h"
#include "libhybrid/io/text_reader.h"

namespace hybrid {

std::vector<VertexPair> read_pairs(const std::string& path, bool flags) {
  TextReader text(path);
  std::vector<VertexPair> pairs;
  TextRow row;
  while (text.next(row)) {
    row.expect(2, flags ? 3 : 2, flags ? "i j, or i j 0|1" : "i j");
    VertexPair& pair = pairs.emplace_back();
    pair.i = vertex_in(row, 0);
    pair.j = vertex_in(row, 1);
    pair.flag = row.size() < 3 || row.id(2, 1) == 1;
    pair.line = row.line();
  }
  return pairs;
}

}  // namespace hybrid
