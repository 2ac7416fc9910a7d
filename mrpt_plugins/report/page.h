// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// The page without data, web/report_template.html.
std::string_view report_template();

/// Bytes in base 64.
std::string base64(const std::string& bytes);

/// A page that shows `data` and needs no other file: the template with the data inside, compressed
/// by gzip and encoded in base 64. web/src/data.ts has the types. Throws Error where memory is
/// short.
std::string report_page(const nlohmann::ordered_json& data);

}  // namespace hybrid
