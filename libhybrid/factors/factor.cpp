// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/factor.h"

#include <utility>

namespace hybrid {

ContinuousFactor::ContinuousFactor(std::vector<Key> keys, std::vector<VariableType> types, int rows)
    : keys_(std::move(keys)), types_(std::move(types)), rows_(rows), cols_(0) {
  for (const VariableType& type : types_) cols_ += type.dim;
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (keys_[i] == keys_[j]) {
        throw Error("a factor names variable " + to_string(keys_[i]) + " twice");
      }
    }
  }
}

std::string describe(const std::string& name, const std::vector<Key>& keys) {
  std::string text = name + " factor on";
  for (Key key : keys) text += " " + to_string(key);
  return text;
}

double ContinuousFactor::cost(const Values& values) const {
  return cost(gather(keys_, types_, values).data());
}

std::vector<const double*> gather(const std::vector<Key>& keys,
                                  const std::vector<VariableType>& types, const Values& values) {
  std::vector<const double*> x(keys.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const int slot = values.slot(keys[i]);
    if (values.type(slot) != types[i]) {
      throw Error("variable " + to_string(keys[i]) + " is " + to_string(values.type(slot)) +
                  ", but " + describe("a", keys) + " takes it as " + to_string(types[i]));
    }
    x[i] = values.data(slot);
  }
  return x;
}

}  // namespace hybrid
