// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string_view>

namespace hybrid {

/// What the first bytes of a file say that it is, if it is not text, and what to do with it, as the
/// end of the sentence "this file is ..."; empty for text and for what is not known.
std::string_view binary_kind(std::string_view head);

}  // namespace hybrid
