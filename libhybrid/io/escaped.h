// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Text of a file in a form for messages: control characters and bytes that are not UTF-8 as
/// `\xNN`, and at most its first 200 characters.
std::string escaped(std::string_view text);

/// The same between single quotes, and at most 40 characters.
std::string in_quotes(std::string_view word);

}  // namespace hybrid
