// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/association_truth.h"

#include "mrpt_plugins/input/text_table.h"

namespace hybrid {

AssociationTruth read_true_associations(const std::string& path) {
  AssociationTruth truth;
  TextTable table(path, TextTable::Columns::kCommas);
  auto row = table.next();
  if (!row || row->words.front() == "step") row = table.next();
  for (; row; row = table.next()) {
    row->expect_columns(3, 3, "step,measurement,true_id");
    const auto step = static_cast<std::size_t>(row->id(0));
    const auto measurement = static_cast<std::size_t>(row->id(1));
    if (!truth.emplace(std::pair(step, measurement), row->id(2)).second) {
      row->fail("this measurement has a true id already");
    }
  }
  return truth;
}

}  // namespace hybrid
