// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Name of a variable: a letter and an index below 2^56, e.g. Key{'x', 3} prints as "x3".
class Key {
 public:
  constexpr Key() = default;
  constexpr Key(char letter, std::uint64_t index)
      : packed_((std::uint64_t(static_cast<unsigned char>(letter)) << 56) |
                (index & 0x00ffffffffffffffULL)) {}

  constexpr char letter() const { return static_cast<char>(packed_ >> 56); }
  constexpr std::uint64_t index() const { return packed_ & 0x00ffffffffffffffULL; }
  constexpr std::uint64_t packed() const { return packed_; }

  friend constexpr bool operator==(Key a, Key b) { return a.packed_ == b.packed_; }
  friend constexpr bool operator!=(Key a, Key b) { return a.packed_ != b.packed_; }
  friend constexpr bool operator<(Key a, Key b) { return a.packed_ < b.packed_; }

 private:
  std::uint64_t packed_ = 0;
};

inline std::string to_string(Key key) {
  return key.letter() + std::to_string(key.index());
}

inline std::ostream& operator<<(std::ostream& out, Key key) {
  return out << to_string(key);
}

/// A discrete variable: its name and the number of values it can take, 0 .. cardinality - 1.
struct DiscreteKey {
  Key key;
  int cardinality = 0;

  friend bool operator==(DiscreteKey a, DiscreteKey b) {
    return a.key == b.key && a.cardinality == b.cardinality;
  }
  friend bool operator!=(DiscreteKey a, DiscreteKey b) { return !(a == b); }
};

}  // namespace hybrid

template <>
struct std::hash<hybrid::Key> {
  std::size_t operator()(hybrid::Key key) const noexcept {
    std::uint64_t h = key.packed();
    h = (h ^ (h >> 32)) * 0x9e3779b97f4a7c15ULL;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};
