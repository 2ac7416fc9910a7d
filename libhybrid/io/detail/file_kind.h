// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string_view>

namespace hybrid {

/// The kind of a binary file by its first bytes, and what to do with it, as the end of the sentence
/// "this file is ..."; empty for text and unknown kinds.
std::string_view binary_kind(std::string_view head);

}  // namespace hybrid
