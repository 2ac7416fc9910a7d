// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace HYBRID_API hybrid {

/// What `work` returns. An Error that it throws names a file: where its message begins with none of
/// these, the first is put in front.
template <class Work>
auto about(const std::vector<std::string>& files, const Work& work) {
  try {
    return work();
  } catch (const Interrupted&) {
    throw;
  } catch (const Error& e) {
    const std::string message = e.what();
    for (const std::string& file : files) {
      if (!file.empty() && message.rfind(file, 0) == 0) throw;
    }
    throw Error(files.front() + ": " + message);
  }
}

}  // namespace hybrid
