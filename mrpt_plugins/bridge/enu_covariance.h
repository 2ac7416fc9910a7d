// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/CMatrixFixed.h>

#include <optional>
#include <type_traits>
#include <utility>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Covariance of a satellite fix: east, north and up [m^2].
using EnuCovariance = std::optional<mrpt::math::CMatrixDouble33>;

/// Whether the CObservationGPS of this version of MRPT has a covariance; that of 2.5 has none.
template <class Fix, class = void>
struct HasEnuCovariance : std::false_type {};
template <class Fix>
struct HasEnuCovariance<Fix, std::void_t<decltype(std::declval<Fix>().covariance_enu)>>
    : std::true_type {};

/// The covariance of a CObservationGPS, where it has one.
template <class Fix>
EnuCovariance enu_covariance(const Fix& fix) {
  if constexpr (HasEnuCovariance<Fix>::value) {
    return fix.covariance_enu;
  } else {
    return std::nullopt;
  }
}

/// Sets it, where that is possible.
template <class Fix>
void set_enu_covariance([[maybe_unused]] Fix& fix, [[maybe_unused]] const EnuCovariance& value) {
  if constexpr (HasEnuCovariance<Fix>::value) fix.covariance_enu = value;
}

}  // namespace hybrid
