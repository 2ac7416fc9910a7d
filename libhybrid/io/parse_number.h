// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <charconv>
#include <string_view>
#include <system_error>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Whether the whole of `text` is one number, whatever the locale: decimal, with a point, `+` or
/// `-` before it; of floating types also nan, inf, and exponents. A number out of the range of T is
/// not accepted.
template <class T>
bool parse_number(std::string_view text, T& out) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace hybrid
