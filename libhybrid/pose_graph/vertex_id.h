// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Vertices below are numbered in their keys as in their file.
inline constexpr std::int64_t kLargestPlainId = (std::int64_t{1} << 55) - 1;

/// The index, of 56 bits, in the key of the vertex of an id of a file, of 64 bits. Larger ids are
/// those of GTSAM's Symbol (a character of 8 bits, a number of 56) or LabeledSymbol (a character
/// and a label of 8 bits, a number of 48): their characters move next to their number, so that
/// successive ids have successive indices. Empty for a number of more than 40 bits, or a character
/// that is not ASCII.
inline std::optional<std::uint64_t> vertex_index(std::int64_t id) {
  const auto word = static_cast<std::uint64_t>(id);
  if (id <= kLargestPlainId) return word;
  const std::uint64_t characters = word >> 48;
  const std::uint64_t number = word & ((std::uint64_t{1} << 48) - 1);
  if (characters >> 15 != 0 || number >> 40 != 0) return std::nullopt;
  return std::uint64_t{1} << 55 | characters << 40 | number;
}

/// The id in a file of a vertex of that index.
inline std::uint64_t vertex_id(std::uint64_t index) {
  if (index <= static_cast<std::uint64_t>(kLargestPlainId)) return index;
  const std::uint64_t characters = (index >> 40) & 0x7fff;
  return characters << 48 | (index & ((std::uint64_t{1} << 40) - 1));
}

/// The id of a vertex for a reader: b79 for GTSAM's Symbol, aB6 for a LabeledSymbol, or the number.
std::string vertex_name(std::uint64_t index);

/// A message with the names of vertices in place of keys x<index> and l<index> that no file has.
std::string with_vertex_names(const std::string& message);

}  // namespace hybrid
