// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"

namespace HYBRID_API hybrid {

/// The result of `work`. An Error that `work` throws names a file: if its message begins with none
/// of `files`, files.front() is put in front of it.
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
