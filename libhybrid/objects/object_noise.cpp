// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/objects/object_noise.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "libhybrid/core/chi_square.h"
#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

constexpr int kShort = 32;             // frames over which the scatter of sightings is taken
constexpr std::size_t kFewPairs = 20;  // tell nothing
constexpr double kCertain = 3.0;       // standard deviations
constexpr double kLeastShare = 0.1;    // of the noise that is stated
constexpr double kSurelyRight = 0.2;   // share of the pairs that are right, at least
constexpr double kTrimmed = 0.99;      // quantile of the right pairs that are kept
constexpr int kTrimmings = 20;
/// Kinds of displacement, and the number of axes of each.
enum Kind { kAcross, kAlong, kAngle, kKinds };
constexpr std::array<int, kKinds> kAxes = {2, 1, 3};

using Variances = std::array<double, kKinds>;  // per axis

/// Where an object seen in frame i is seen again, moved back by odometry, less where it was seen.
struct Displacement {
  Eigen::Vector3d translation, rotation;  // in the camera of frame i
  Variances squares;                      // sums over the axes of a kind
};
using Displacements = std::vector<std::optional<Displacement>>;  // by frame i

/// What is known of the pairs of frames that are `lag` apart.
struct Scatter {
  int lag = 0;
  std::size_t pairs = 0;
  Variances variances{};  // of one sighting: half of what two differ by
};

Displacements displacements(const ObjectSequence& sequence, const ObjectTrack& track, int lag) {
  const std::vector<SE3>& path = sequence.odometry;
  Displacements all(path.size());
  for (std::size_t i = 0; i + lag < path.size(); ++i) {
    const std::optional<SE3>&first = track.sightings[i], &second = track.sightings[i + lag];
    if (!first || !second) continue;
    const double range = first->translation().norm();
    if (range < 1e-6) continue;
    const SE3 again = path[i].between(path[i + lag]) * *second;
    Displacement d;
    d.translation = again.translation() - first->translation();
    d.rotation = (again.rotation() * first->rotation().inverse()).log();
    const double along = d.translation.dot(first->translation()) / range;
    d.squares[kAlong] = along * along;
    d.squares[kAcross] = std::max(0.0, d.translation.squaredNorm() - d.squares[kAlong]);
    d.squares[kAngle] = d.rotation.squaredNorm();
    all[i] = d;
  }
  return all;
}

/// Leaves only the right pairs: scales are those of the nearest fifth, then those of what lies
/// within them, repeatedly. Returns the scatter of what is left.
Scatter trim(Displacements& pairs, int lag, const Variances& least) {
  Scatter scatter;
  scatter.lag = lag;
  std::array<std::vector<double>, kKinds> squares;
  for (const auto& d : pairs) {
    for (int k = 0; d && k < kKinds; ++k) squares[k].push_back(d->squares[k]);
  }
  scatter.pairs = squares[kAcross].size();
  if (scatter.pairs < kFewPairs) return scatter;
  Variances variances;
  for (int k = 0; k < kKinds; ++k) {
    const double near = quantile(std::move(squares[k]), kSurelyRight);
    variances[k] = std::max(2.0 * least[k], near / chi_square_quantile(kSurelyRight, kAxes[k]));
  }
  const double limit =
      chi_square_quantile(kTrimmed, std::accumulate(kAxes.begin(), kAxes.end(), 0));
  const auto is_right = [&](const Displacement& d) {
    double sum = 0.0;
    for (int k = 0; k < kKinds; ++k) sum += d.squares[k] / variances[k];
    return sum < limit;
  };
  for (int trimming = 0; trimming < kTrimmings; ++trimming) {
    Variances sums{};
    scatter.pairs = 0;
    for (const auto& d : pairs) {
      if (!d || !is_right(*d)) continue;
      ++scatter.pairs;
      for (int k = 0; k < kKinds; ++k) sums[k] += d->squares[k] / kAxes[k];
    }
    if (scatter.pairs < kFewPairs) return scatter;
    for (int k = 0; k < kKinds; ++k) {
      variances[k] = std::max(2.0 * least[k], sums[k] / static_cast<double>(scatter.pairs));
    }
  }
  for (auto& d : pairs) {
    if (d && !is_right(*d)) d.reset();
  }
  for (int k = 0; k < kKinds; ++k) scatter.variances[k] = 0.5 * variances[k];
  return scatter;
}

/// A mean, and the variance of its error.
struct Mean {
  double value = 0.0, variance = std::numeric_limits<double>::infinity();
};

/// Half the covariance of what pairs of objects are displaced by between the same two frames, per
/// axis: what odometry adds. Pairs of frames that overlap count as one.
template <class Part>
Mean common(const std::vector<Displacements>& objects, int lag, const Part& part) {
  std::vector<double> products;
  for (std::size_t a = 0; a < objects.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      for (std::size_t i = 0; i < objects[a].size(); ++i) {
        if (!objects[a][i] || !objects[b][i]) continue;
        products.push_back(part(*objects[a][i]).dot(part(*objects[b][i])) / 6.0);
      }
    }
  }
  if (products.size() < kFewPairs) return {};
  const double n = static_cast<double>(products.size());
  Mean estimate;
  estimate.value = std::accumulate(products.begin(), products.end(), 0.0) / n;
  double squares = 0.0;
  for (double p : products) squares += (p - estimate.value) * (p - estimate.value);
  estimate.variance = squares / n * lag / n;
  return estimate;
}

/// Growth of a variance per frame, through zero, weighted by how well each lag is known.
class Growth {
 public:
  void add(int lag, const Mean& of) {
    if (!(of.variance > 0.0) || std::isinf(of.variance)) return;
    xy_ += lag * of.value / of.variance;
    xx_ += lag * lag / of.variance;
  }
  bool is_certain() const { return xy_ > kCertain * std::sqrt(xx_); }
  /// At most.
  double limit() const {
    if (xx_ == 0.0) return 0.0;
    return std::max(0.0, xy_ / xx_) + kCertain / std::sqrt(xx_);
  }

 private:
  double xy_ = 0.0, xx_ = 0.0;
};

/// Growth per frame of a scatter that begins at any value, by least squares over short lags.
double growth(const std::vector<Scatter>& scatters, Kind kind) {
  double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (const Scatter& s : scatters) {
    if (s.lag > kShort) continue;
    const double weight = static_cast<double>(s.pairs) / (s.variances[kind] * s.variances[kind]);
    w += weight;
    x += weight * s.lag;
    y += weight * s.variances[kind];
    xx += weight * s.lag * s.lag;
    xy += weight * s.lag * s.variances[kind];
  }
  const double determinant = w * xx - x * x;
  return determinant > 0.0 ? std::max(0.0, (w * xy - x * y) / determinant)
                           : std::numeric_limits<double>::infinity();
}

/// All that the pairs tell, by lag.
struct Pairs {
  std::vector<std::vector<Scatter>> scatters;  // by object
  std::vector<int> lags;
  std::vector<Mean> translation, rotation;  // what objects have in common, by lag
};

Pairs pairs_of(const ObjectSequence& sequence, const std::vector<Variances>& least) {
  Pairs pairs;
  const std::size_t count = sequence.objects.size();
  pairs.scatters.resize(count);
  for (int lag = 1; lag < static_cast<int>(sequence.odometry.size()); lag *= 2) {
    std::vector<Displacements> objects;
    for (std::size_t k = 0; k < count; ++k) {
      objects.push_back(displacements(sequence, sequence.objects[k], lag));
      const Scatter scatter = trim(objects[k], lag, least[k]);
      if (scatter.pairs < kFewPairs) {
        objects[k].assign(objects[k].size(), std::nullopt);
      } else {
        pairs.scatters[k].push_back(scatter);
      }
    }
    pairs.lags.push_back(lag);
    pairs.translation.push_back(
        common(objects, lag, [](const Displacement& d) { return d.translation; }));
    pairs.rotation.push_back(
        common(objects, lag, [](const Displacement& d) { return d.rotation; }));
  }
  return pairs;
}

double median_range(const ObjectTrack& track) {
  std::vector<double> ranges;
  for (const auto& sighting : track.sightings) {
    if (sighting) ranges.push_back(sighting->translation().norm());
  }
  return median(std::move(ranges));
}

void measure_odometry(const ObjectSequence& sequence, const Pairs& pairs, ObjectNoise& noise) {
  Growth translation, rotation;
  for (std::size_t l = 0; l < pairs.lags.size() && pairs.lags[l] <= kShort; ++l) {
    translation.add(pairs.lags[l], pairs.translation[l]);
    rotation.add(pairs.lags[l], pairs.rotation[l]);
  }
  noise.odometry_measured = translation.is_certain() || rotation.is_certain();
  if (!noise.odometry_measured) return;
  std::vector<double> steps, turns;
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    if (pairs.scatters[k].size() < 2) continue;
    const double across = growth(pairs.scatters[k], kAcross);
    const double range = std::max(1e-6, median_range(sequence.objects[k]));
    steps.push_back(std::min(across, growth(pairs.scatters[k], kAlong)));
    turns.push_back(std::min(across / (range * range), growth(pairs.scatters[k], kAngle)));
  }
  const double step = std::min(translation.limit(), median(std::move(steps)));
  const double turn = std::min(rotation.limit(), median(std::move(turns)));
  // A scatter is half of what two sightings differ by.
  noise.step_m = std::max(kLeastShare * noise.step_m, std::sqrt(2.0 * step));
  noise.step_rad = std::max(kLeastShare * noise.step_rad, std::sqrt(2.0 * turn));
}

/// The part of a scatter that is not odometry's, at least as much as chance leaves undecided;
/// nothing where most of it is odometry's.
std::vector<Scatter> without_odometry(const std::vector<Scatter>& scatters, const Pairs& pairs) {
  std::vector<Scatter> own;
  for (Scatter s : scatters) {
    const auto l = static_cast<std::size_t>(std::find(pairs.lags.begin(), pairs.lags.end(), s.lag) -
                                            pairs.lags.begin());
    const double position = (2.0 * s.variances[kAcross] + s.variances[kAlong]) / 3.0;
    const double undecided = 2.0 / std::sqrt(static_cast<double>(s.pairs));
    double most = 0.0;
    for (int k = 0; k < kKinds; ++k) {
      const bool turns = k == kAngle;
      const Mean& of = turns ? pairs.rotation[l] : pairs.translation[l];
      const double share = std::max(0.0, of.value) / (turns ? s.variances[kAngle] : position);
      s.variances[k] *= std::max(undecided, 1.0 - share);
      most = std::max(most, share);
    }
    if (own.empty() || most < 0.5) own.push_back(s);
  }
  return own;
}

/// How many sightings tell as much as one, where their scatter grows from that of neighbours to
/// that of sightings far apart: one and twice the sum of the correlations.
double repetitions(const std::vector<Scatter>& scatters, Kind kind) {
  double most = 0.0;
  for (const Scatter& s : scatters) most = std::max(most, s.variances[kind]);
  double sum = 1.0, before = 1.0;
  int last = 0;
  for (const Scatter& s : scatters) {
    const double correlation = 1.0 - s.variances[kind] / most;
    sum += (s.lag - last) * (last == 0 ? 2.0 * correlation : before + correlation);
    if (correlation <= 0.0) break;
    before = correlation;
    last = s.lag;
  }
  return sum;
}

SightingNoise sighting_noise(const std::vector<Scatter>& scatters, const Variances& least) {
  Variances typical;
  for (int k = 0; k < kKinds; ++k) {
    std::vector<double> variances;
    for (const Scatter& s : scatters) {
      if (s.lag <= kShort) variances.push_back(s.variances[k]);
    }
    typical[k] = std::max(least[k], median(std::move(variances)));
  }
  SightingNoise noise;
  noise.across_m = std::sqrt(typical[kAcross]);
  noise.along_m = std::sqrt(typical[kAlong]);
  noise.angle_rad = std::sqrt(typical[kAngle]);
  return noise;
}

}  // namespace

Noise SightingNoise::of(const SE3& sighting) const {
  const double range = sighting.translation().norm();
  const Eigen::Vector3d ray = range > 0.0 ? Eigen::Vector3d(sighting.translation() / range)
                                          : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d u = sighting.rotation().matrix().transpose() * ray;
  const Eigen::Matrix3d along = u * u.transpose();
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  covariance.topLeftCorner<3, 3>() =
      across_m * across_m * (Eigen::Matrix3d::Identity() - along) + along_m * along_m * along;
  covariance.bottomRightCorner<3, 3>() = angle_rad * angle_rad * Eigen::Matrix3d::Identity();
  return Noise::covariance(covariance);
}

ObjectNoise measure_noise(const ObjectSequence& sequence, const ObjectNoise& stated) {
  ObjectNoise noise = stated;
  std::vector<Variances> least;
  for (const SightingNoise& s : stated.sightings) {
    least.push_back({s.across_m * s.across_m, s.along_m * s.along_m, s.angle_rad * s.angle_rad});
    for (double& variance : least.back()) variance *= kLeastShare * kLeastShare;
  }
  Pairs pairs = pairs_of(sequence, least);
  measure_odometry(sequence, pairs, noise);
  for (std::size_t k = 0; k < sequence.objects.size(); ++k) {
    const std::vector<Scatter>& scatters = pairs.scatters[k];
    if (scatters.empty() || scatters.front().lag > kShort) continue;
    noise.sightings_measured[k] = true;
    if (noise.odometry_measured) {
      // Errors that last are not told from those of odometry.
      noise.sightings[k] = sighting_noise(without_odometry(scatters, pairs), least[k]);
    } else {
      noise.sightings[k] = sighting_noise(scatters, least[k]);
      const double along = repetitions(scatters, kAlong), angle = repetitions(scatters, kAngle);
      noise.sightings[k].repetitions = std::max(1.0, 0.5 * (along + angle));
    }
  }
  return noise;
}

}  // namespace hybrid
