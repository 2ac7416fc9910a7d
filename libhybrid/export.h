// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

/// Stands in the namespace of every header of the API: what is declared there is seen from outside
/// the shared libraries. All else is hidden.
#define HYBRID_API [[gnu::visibility("default")]]
