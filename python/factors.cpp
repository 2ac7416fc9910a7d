// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/factors/bearing.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/factors/linear_factor.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/projection.h"
#include "libhybrid/factors/range.h"
#include "libhybrid/factors/steady_motion.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

ContinuousFactorPtr prior_of_vector(Key key, const Eigen::VectorXd& z, const Noise& noise,
                                    Loss loss) {
  switch (z.size()) {
    case 1:
      return std::make_shared<Prior<Vector<1>>>(key, z, noise, loss);
    case 2:
      return std::make_shared<Prior<Vector<2>>>(key, z, noise, loss);
    case 3:
      return std::make_shared<Prior<Vector<3>>>(key, z, noise, loss);
    case 4:
      return std::make_shared<Prior<Vector<4>>>(key, z, noise, loss);
    case 5:
      return std::make_shared<Prior<Vector<5>>>(key, z, noise, loss);
    case 6:
      return std::make_shared<Prior<Vector<6>>>(key, z, noise, loss);
    default:
      break;
  }
  if (loss.kind != Loss::Kind::kNone) {
    throw Error("a prior with a robust loss is for vectors of at most 6 numbers");
  }
  const auto n = z.size();
  return std::make_shared<LinearFactor>(
      std::vector<LinearFactor::Term>{{key, Eigen::MatrixXd::Identity(n, n)}}, z, noise);
}

ContinuousFactorPtr between_vectors(Key a, Key b, const Eigen::VectorXd& z, const Noise& noise,
                                    Loss loss) {
  switch (z.size()) {
    case 1:
      return std::make_shared<Between<Vector<1>>>(a, b, z, noise, loss);
    case 2:
      return std::make_shared<Between<Vector<2>>>(a, b, z, noise, loss);
    case 3:
      return std::make_shared<Between<Vector<3>>>(a, b, z, noise, loss);
    default:
      break;
  }
  if (loss.kind != Loss::Kind::kNone) {
    throw Error("a difference with a robust loss is for vectors of at most 3 numbers");
  }
  const auto I = Eigen::MatrixXd::Identity(z.size(), z.size());
  return std::make_shared<LinearFactor>(std::vector<LinearFactor::Term>{{a, -I}, {b, I}}, z, noise);
}

template <class T>
void bind_group_factors(py::module_& m) {
  m.def(
      "Prior",
      [](Key key, const T& measured, const Noise& noise, const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<Prior<T>>(key, measured, noise, loss);
      },
      "key"_a, "measured"_a, "noise"_a, "loss"_a = Loss::none(),
      "A direct measurement z of a variable: residual log(z^-1 x); noise over the tangent.");
  m.def(
      "Between",
      [](Key a, Key b, const T& measured, const Noise& noise,
         const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<Between<T>>(a, b, measured, noise, loss);
      },
      "a"_a, "b"_a, "measured"_a, "noise"_a, "loss"_a = Loss::none(),
      "A measured relative motion z of b seen from a: residual log(z^-1 a^-1 b), eq. 15; noise "
      "over "
      "the tangent.");
}

void bind_relative(py::module_& m) {
  bind_group_factors<SO2>(m);
  bind_group_factors<SE2>(m);
  bind_group_factors<SO3>(m);
  bind_group_factors<SE3>(m);
  m.def("Prior", &prior_of_vector, "key"_a, "measured"_a, "noise"_a, "loss"_a = Loss::none(),
        "A direct measurement z (n,) of a vector: residual x - z.");
  m.def("Between", &between_vectors, "a"_a, "b"_a, "measured"_a, "noise"_a, "loss"_a = Loss::none(),
        "A measured difference z (n,) of vectors: residual b - a - z.");
  m.def(
      "BetweenSE2",
      [](Key a, Key b, const SE2& measured, const Noise& noise,
         const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<BetweenSE2>(a, b, measured, noise, loss);
      },
      "a"_a, "b"_a, "measured"_a, "noise"_a, "loss"_a = Loss::none(),
      "A measured planar motion whose residual is the translation [m] in the measured frame and "
      "the "
      "difference of angles [rad]: it converges from far worse starts than Between. Readers of "
      "graph files make it.");
}

/// Binds the sensors of one pose type.
template <class Pose>
void bind_sensors(py::module_& m, const char* polar, const char* angles) {
  using Point = typename Pose::Point;
  using Angles = typename Bearing<Pose>::Angles;
  m.def(
      "BearingRange",
      [](Key pose, Key point, const Point& measured, const Noise& noise, const Pose& T_robot_sensor,
         const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<BearingRange<Pose>>(pose, point, measured, noise, T_robot_sensor,
                                                    loss);
      },
      "pose"_a, "point"_a, "measured"_a, "noise"_a, "T_robot_sensor"_a = Pose(),
      "loss"_a = Loss::none(), polar);
  m.def(
      "Bearing",
      [](Key pose, Key point, const Angles& measured, const Noise& noise,
         const Pose& T_robot_sensor, const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<Bearing<Pose>>(pose, point, measured, noise, T_robot_sensor, loss);
      },
      "pose"_a, "point"_a, "measured"_a, "noise"_a, "T_robot_sensor"_a = Pose(),
      "loss"_a = Loss::none(), angles);
  m.def(
      "Position",
      [](Key pose, const Point& measured, const Noise& noise, const Point& lever_arm,
         const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<Position<Pose>>(pose, measured, noise, lever_arm, loss);
      },
      "pose"_a, "measured"_a, "noise"_a, "lever_arm"_a = Point(Point::Zero()),
      "loss"_a = Loss::none(),
      "A measured position [m] in the map, (2,) or (3,), of a point fixed on a robot at "
      "lever_arm.");
}

template <class A, class B>
ContinuousFactorPtr make_range(Key a, Key b, double z, const Noise& noise, const Loss& loss) {
  using Point = typename Range<A, B>::Point;
  return std::make_shared<Range<A, B>>(a, b, z, noise, Point::Zero(), Point::Zero(), loss);
}

ContinuousFactorPtr range(Key a, Key b, double measured, const Noise& noise,
                          const std::pair<py::object, py::object>& types, const Loss& loss) {
  const VariableType A = type_of(types.first), B = type_of(types.second);
  const auto is = [&](VariableType x, VariableType y) { return A == x && B == y; };
  const VariableType se2 = Variable<SE2>::type(), se3 = Variable<SE3>::type();
  const VariableType v2 = vector_type(2), v3 = vector_type(3);
  if (is(se2, v2)) return make_range<SE2, Vector<2>>(a, b, measured, noise, loss);
  if (is(se2, se2)) return make_range<SE2, SE2>(a, b, measured, noise, loss);
  if (is(v2, v2)) return make_range<Vector<2>, Vector<2>>(a, b, measured, noise, loss);
  if (is(se3, v3)) return make_range<SE3, Vector<3>>(a, b, measured, noise, loss);
  if (is(se3, se3)) return make_range<SE3, SE3>(a, b, measured, noise, loss);
  if (is(v3, v3)) return make_range<Vector<3>, Vector<3>>(a, b, measured, noise, loss);
  throw Error(
      "a range is between (SE2, 2), (SE2, SE2), (2, 2), (SE3, 3), (SE3, SE3) or (3, 3), not " +
      to_string(A) + " and " + to_string(B));
}

ContinuousFactorPtr linear(const std::vector<std::pair<Key, Eigen::MatrixXd>>& terms,
                           const Eigen::VectorXd& b, const Noise& noise) {
  std::vector<LinearFactor::Term> all;
  for (const auto& [key, A] : terms) all.push_back({key, A});
  return std::make_shared<LinearFactor>(all, b, noise);
}

void bind_others(py::module_& m) {
  m.def("Range", &range, "a"_a, "b"_a, "measured"_a, "noise"_a, "types"_a, "loss"_a = Loss::none(),
        "A measured distance [m] between two variables; their types are SE2, SE3 or the length of "
        "a point, such as (SE2, 2).");
  m.def("LinearFactor", &linear, "terms"_a, "b"_a, "noise"_a,
        "A linear factor: residual sum A_i x_i - b (m,), from pairs of key and A_i (m, n_i).");
  m.def(
      "Projection",
      [](Key pose, Key point, Key intrinsics, const Eigen::Vector2d& pixel, const Noise& noise,
         const Loss& loss) -> ContinuousFactorPtr {
        return std::make_shared<Projection>(pose, point, intrinsics, pixel, noise, loss);
      },
      "pose"_a, "point"_a, "intrinsics"_a, "pixel"_a, "noise"_a, "loss"_a = Loss::none(),
      "A pixel (2,) where a camera at T_map_camera (SE3) saw a point (3,); intrinsics (5,): f, cx, "
      "cy [pixels], k1, k2.");
  m.def(
      "Inflated",
      [](const FactorArgument& factor, double variance_factor) -> ContinuousFactorPtr {
        return std::make_shared<Inflated>(factor.pointer, variance_factor);
      },
      "factor"_a, "variance_factor"_a,
      "A factor with the covariance of its noise multiplied by a number.");
  const auto steady = [](Key a, Key b, Key c, const Noise& noise,
                         const Loss& loss) -> ContinuousFactorPtr {
    if (noise.dim() == 2) return std::make_shared<SteadyMotion<SE2>>(a, b, c, noise, loss);
    return std::make_shared<SteadyMotion<SE3>>(a, b, c, noise, loss);
  };
  m.def("SteadyMotion", steady, "a"_a, "b"_a, "c"_a, "noise"_a, "loss"_a = Loss::none(),
        "Constant velocity over three successive poses: the residual is the change of the step in "
        "the axes of the robot [m]; noise of dimension 2 for SE2, 3 for SE3.");
}

std::pair<Eigen::VectorXd, Eigen::MatrixXd> linearize(const ContinuousFactor& factor,
                                                      const Values& values) {
  const std::vector<const double*> x = gather(factor.keys(), factor.types(), values);
  std::pair<Eigen::VectorXd, Eigen::MatrixXd> out(Eigen::VectorXd(factor.rows()),
                                                  Eigen::MatrixXd(factor.rows(), factor.cols()));
  factor.linearize(x.data(), out.first.data(), out.second.data());
  return out;
}

}  // namespace

void bind_factors(py::module_& m) {
  py::class_<ContinuousFactor, std::shared_ptr<ContinuousFactor>>(
      m, "ContinuousFactor", "A factor over continuous variables (eq. 2); see Factor to write one.")
      .def_property_readonly("keys", &ContinuousFactor::keys)
      .def_property_readonly(
          "types",
          [](const ContinuousFactor& factor) {
            py::list types;
            for (const VariableType type : factor.types()) {
              types.append(to_python(type));
            }
            return types;
          },
          "Types of the variables: a class, or the length of a vector.")
      .def_property_readonly("rows", &ContinuousFactor::rows, "Length of the residual.")
      .def_property_readonly("cols", &ContinuousFactor::cols,
                             "Sum of the tangent dimensions of the variables.")
      .def_property_readonly("name", &ContinuousFactor::name)
      .def_property_readonly("log_normalizer", &ContinuousFactor::log_normalizer,
                             "-log of the Gaussian density at zero residual.")
      .def("cost", py::overload_cast<const Values&>(&ContinuousFactor::cost, py::const_),
           "values"_a, "Half the squared whitened residual, with the robust loss if there is one.")
      .def("linearize", &linearize, "values"_a,
           "Whitened residual (rows,) and its Jacobian (rows, cols) with respect to the tangents, "
           "both scaled by the root of the robust weight.")
      .def("__repr__", [](const ContinuousFactor& factor) {
        return "<" + describe(factor.name(), factor.keys()) + ">";
      });
  bind_python_factor(m);
  bind_relative(m);
  bind_sensors<SE2>(m,
                    "A point (2,) of the map seen by a robot (SE2): measured (2,) range [m] and "
                    "bearing [rad] in the frame of the sensor.",
                    "The bearing (1,) [rad] of a point (2,) seen by a robot (SE2).");
  bind_sensors<SE3>(
      m,
      "A point (3,) of the map seen by a robot (SE3): measured (3,) range [m], yaw and "
      "pitch [rad] in the frame of the sensor; positive pitch points down.",
      "Yaw and pitch (2,) [rad] of a point (3,) seen by a robot (SE3).");
  bind_others(m);
}

}  // namespace hybrid::python
