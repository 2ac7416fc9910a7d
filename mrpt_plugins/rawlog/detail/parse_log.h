// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <functional>

#include "mrpt_plugins/rawlog/asked_classes.h"
#include "mrpt_plugins/rawlog/decoder.h"
#include "mrpt_plugins/rawlog/log_object.h"
#include "mrpt_plugins/rawlog/log_record.h"

namespace hybrid {

/// Decodes a file and parses it with MRPT, object by object, in this process, in which hostile
/// bytes may do anything. Each object is given once it is whole; before it the class that is
/// parsed, and before an entry of it the class of that. The last record is how the log ended;
/// std::bad_alloc is thrown where memory does not suffice.
void parse_log(const ByteSource& file, const LogRequest& request,
               const std::function<void(const LogRecord&)>& give);

}  // namespace hybrid
