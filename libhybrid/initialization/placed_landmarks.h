// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "libhybrid/initialization/pending_landmarks.h"
#include "libhybrid/landmarks/contribution.h"

namespace HYBRID_API hybrid {

/// Landmarks that were placed from measurements none of which places them alone, with these
/// measurements. Each measurement is a hybrid factor over a choice, whose value is 0 where it is
/// right. A landmark most of whose latest measurements are false, and
/// whose measurements another place explains, is misplaced: it is taken out of the map, to be
/// placed again from its measurements.
class PlacedLandmarks {
 public:
  using Measurement = GaussianSumInitializer::Measurement;

  /// A new contribution begins; the one before was applied or refused.
  void begin() { change_ = {}; }
  /// Priors of a landmark, by their place among the discrete and the continuous factors of a
  /// contribution.
  struct Priors {
    std::optional<std::size_t> of_class, of_position;
  };
  /// The contribution places a landmark.
  void place(PlacedLandmark landmark, const Priors& priors = {});
  /// The contribution has a measurement, `factor` among its hybrid factors.
  void measure(std::int64_t id, const Measurement& measurement, Key choice, std::size_t factor);

  /// Notes the handles of the contribution.
  void applied(const AddedHandles& handles);
  /// Restores the state before the contribution, but for landmarks that it placed: these start anew
  /// from their measurements.
  void refused();

  /// What takes the misplaced landmarks out of the map. `may_leave` tells whether the factors that
  /// others have added for a landmark can be removed, too; where they cannot, it stays.
  Contribution take_out(const MapView& map, const BankOptions& options,
                        const std::function<bool(std::int64_t)>& may_leave = {});

  /// The measurements of a landmark that is to be placed again, once.
  std::vector<Measurement> restart(std::int64_t id);

 private:
  struct Taken {
    Measurement measurement;
    Key choice;
    Handle factor;
  };
  struct Placed {
    std::vector<Taken> measurements;
    std::vector<Handle> priors;
    std::size_t asked = 0;  // how many measurements there were when other places were tried
  };
  /// What the last contribution changes, until it is applied or refused.
  struct Change {
    std::vector<std::pair<PlacedLandmark, Priors>> placed;
    struct Measured {
      std::int64_t id = 0;
      Taken taken;
      std::size_t factor = 0;
    };
    std::vector<Measured> measured;
    std::map<std::int64_t, Placed> taken_out;
  };

  static bool is_doubtful(const Placed& landmark, const Assignment& assignment,
                          const BankOptions& options);
  static bool is_elsewhere(const Eigen::VectorXd& point, const Placed& landmark, const MapView& map,
                           const BankOptions& options);
  static bool is_misplaced(std::int64_t id, Placed& landmark, const MapView& map,
                           const BankOptions& options);

  std::map<std::int64_t, Placed> placed_;
  std::map<std::int64_t, std::vector<Measurement>> restarts_;
  std::set<std::int64_t> touched_;  // measured since landmarks were last taken out
  Change change_;
};

}  // namespace hybrid
