// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/loss.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/fixes/fix.h"
#include "libhybrid/fixes/fix_model.h"
#include "libhybrid/landmarks/contribution.h"

namespace HYBRID_API hybrid {

/// Makes factors of fixes. They wait until the path is long enough to tell how the map lies in the
/// axes of the datum; that is settled then, once for all, and from then on the map, whose first
/// pose must be free, turns and moves as the fixes tell.
class FixMapper {
 public:
  explicit FixMapper(const FixModel& model = {}) : model_(model) {}

  /// The fixes of a keyframe of a robot, in order of time. Nothing before there is a datum.
  Contribution observe(const KeyframeView& frame, const std::vector<Fix>& fixes, const MapView& map,
                       std::size_t robot = 0);
  /// After the keyframe of `observe`: fixes that have waited, once the datum is found; and on
  /// trial, the map at another place, where fixes are biased for longer than they are good. That is
  /// looked at whenever there are twice as many fixes, and once more where the log ends.
  Contribution revise(const MapView& map, bool is_last = false);
  /// Looks for the datum; true if it is found now: then the first pose of the map is to be set
  /// free.
  /// `stands`: the log has ended and had no odometry. Then the axes of the map are those of the
  /// datum, and the path begins as the fixes have it.
  bool find_datum(const MapView& map, bool stands = false);
  /// The datum of a known map, before the first fix.
  void set_datum(const Eigen::Isometry3d& T_datum_map) { T_datum_map_ = T_datum_map; }
  void refused();
  /// The datum was a false one: what has waited so far is not used.
  void forget_waiting();

  const FixModel& model() const { return model_; }
  /// All fixes so far.
  const std::vector<FixEntry>& fixes() const { return fixes_; }
  /// Error of a single fix [m], as measured so far: the median of the receivers.
  double own_sigma() const;
  /// T_datum_map, once it is known.
  const std::optional<Eigen::Isometry3d>& datum() const { return T_datum_map_; }

 private:
  /// An error that lasts.
  struct Error {
    Key key;
    DiscreteKey mode;
    double time = 0;       // at which it began
    double last_time = 0;  // of the last fix that has it
    bool is_new = false;   // since the last update
    ErrorMode chosen = ErrorMode::kNewGood;
    Eigen::VectorXd value;  // as begun
  };
  /// What a refused contribution is taken back to.
  struct State {
    std::size_t answered = 0;            // fixes before wait no longer
    std::uint64_t errors = 0;            // so far
    std::map<ReceiverId, Error> newest;  // a chain for each receiver
  };
  /// What a receiver's fixes that were taken for right have told.
  struct Receiver {
    struct Last {
      double time;
      Eigen::VectorXd residual;
      Eigen::Vector3d antenna;  // by the map
      double way;               // since the first [m]
    };
    std::optional<Last> last;
    std::vector<double> differences;  // of fixes that follow each other [m], one axis each
  };
  struct Place;
  struct Decision {
    ErrorMode mode = ErrorMode::kNewGood;
    bool is_false = true;
    double since_begin = 0;  // of the error of the fix before [s]
  };

  void add(FixEntry& entry, const KeyframeView* frame, const MapView& map, Contribution& out);
  Place place_of(const FixEntry& entry, const KeyframeView* frame, const MapView& map);
  ContinuousFactorPtr position_factor(const FixEntry& entry, const std::optional<Key>& error,
                                      double sigma, bool is_3d, Loss loss = {}) const;
  void add_plain(FixEntry& entry, const Place& place, bool is_3d, Contribution& out);
  Decision decide(const FixEntry& entry, const Place& place, const MapView& map) const;
  void begin_error(FixEntry& entry, const Decision& decision, const Place& place,
                   Contribution& out);
  void foresee_by_way(const FixEntry& entry, Place& place) const;
  void measure_own(const Place& place, const FixEntry& entry);
  double own_sigma(const ReceiverId& id) const;
  FixModel model_of(const FixEntry& entry) const;

  Contribution contribute(const KeyframeView* frame, const MapView& map);
  Contribution contribute_path(const MapView& map);
  bool take_axes_of_datum();

  FixModel model_;
  std::optional<Eigen::Isometry3d> T_datum_map_;
  std::uint64_t falsities_ = 0;  // variables so far, of refused contributions too
  std::size_t looked_ = 0;       // fixes there were when a datum was looked for last
  std::size_t shifted_ = 0;      // the same for another place of the map
  bool stands_ = false;          // the path is to be placed by the fixes
  std::vector<FixEntry> fixes_;
  State state_, before_;
  std::map<ReceiverId, Receiver> receivers_;
  bool has_estimates_ = true;  // on the way, with their covariances
};

}  // namespace hybrid
