// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "python/bindings.h"

namespace hybrid::python {

/// How factors of the classes that are bound are made again; after all of them.
void bind_pickle(py::module_& m);

}  // namespace hybrid::python
