// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/association_truth.h"

#include "libhybrid/io/text_reader.h"

namespace hybrid {

AssociationTruth read_true_associations(const std::string& path) {
  AssociationTruth truth;
  TextReader table(path);
  for (auto row = table.first_below("step"); row; row = table.next()) {
    row->expect(3, "step,measurement,true_id");
    const auto step = static_cast<std::size_t>(row->id(0));
    const auto measurement = static_cast<std::size_t>(row->id(1));
    if (!truth.emplace(std::pair(step, measurement), row->id(2)).second) {
      row->fail("this measurement has a true id already");
    }
  }
  return truth;
}

}  // namespace hybrid
