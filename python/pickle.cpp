// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "python/pickle.h"

#include <cmath>
#include <optional>
#include <typeinfo>

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
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/hybrid/soft_mixture.h"
#include "libhybrid/hybrid/weighted.h"

namespace hybrid::python {
namespace {

template <int N>
using Vector = Eigen::Matrix<double, N, 1>;

/// How a factor is made again: a function of the module, and its arguments.
class Recipe {
 public:
  explicit Recipe(const ContinuousFactor& factor) : factor_(&factor) {}

  /// The recipe of factors of class F, unless there is one already.
  template <class F, class Arguments>
  void offer(const char* function, const Arguments& arguments) {
    if (found_ || typeid(*factor_) != typeid(F)) return;
    const py::object made = arguments(static_cast<const F&>(*factor_));
    if (!made.is_none()) found_ = py::make_tuple(function, made);
  }
  py::object found() const { return found_ ? *found_ : py::none(); }

 private:
  const ContinuousFactor* factor_;
  std::optional<py::object> found_;
};

template <class T>
void offer_direct(Recipe& recipe) {
  recipe.offer<Prior<T>>("Prior", [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.measured(), noise_of(f), f.loss());
  });
}

template <class T>
void offer_relative(Recipe& recipe, const char* function = "Between") {
  recipe.offer<T>(function, [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.keys()[1], f.measured(), noise_of(f), f.loss());
  });
}

template <class Pose>
void offer_sensors(Recipe& recipe) {
  const auto view = [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.keys()[1], f.measured(), noise_of(f), f.T_robot_sensor(),
                          f.loss());
  };
  recipe.offer<BearingRange<Pose>>("BearingRange", view);
  recipe.offer<Bearing<Pose>>("Bearing", view);
  recipe.offer<Position<Pose>>("Position", [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.measured(), noise_of(f), f.lever_arm(), f.loss());
  });
  recipe.offer<SteadyMotion<Pose>>("SteadyMotion", [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.keys()[1], f.keys()[2], noise_of(f), f.loss());
  });
}

/// None of a range between points beside the origins of poses, which `Range` of Python has not.
template <class A, class B>
void offer_range(Recipe& recipe) {
  recipe.offer<Range<A, B>>("Range", [](const auto& f) -> py::object {
    if (!f.offset_a().isZero(0.0) || !f.offset_b().isZero(0.0)) return py::none();
    const auto types = py::make_tuple(to_python(f.types()[0]), to_python(f.types()[1]));
    return py::make_tuple(f.keys()[0], f.keys()[1], f.measured(), noise_of(f), types, f.loss());
  });
}

/// A factor that holds whitened matrices, as one with noise of one standard deviation.
py::tuple linear_arguments(const LinearFactor& factor) {
  const int m = factor.rows();
  const double per_row = factor.log_normalizer() / m;
  const double sigma = std::exp(per_row - 0.5 * std::log(2.0 * M_PI));
  Values zero;
  for (std::size_t i = 0; i < factor.keys().size(); ++i) {
    zero.insert(factor.keys()[i], Eigen::VectorXd(Eigen::VectorXd::Zero(factor.types()[i].size)));
  }
  Eigen::VectorXd r(m);
  Eigen::MatrixXd J(m, factor.cols());
  factor.linearize(gather(factor.keys(), factor.types(), zero).data(), r.data(), J.data());
  py::list terms;
  int column = 0;
  for (std::size_t i = 0; i < factor.keys().size(); ++i) {
    const int n = factor.types()[i].dim;
    terms.append(
        py::make_tuple(factor.keys()[i], Eigen::MatrixXd(sigma * J.middleCols(column, n))));
    column += n;
  }
  return py::make_tuple(terms, Eigen::VectorXd(-sigma * r), Noise::isotropic(m, sigma));
}

void offer_others(Recipe& recipe) {
  recipe.offer<LinearFactor>("LinearFactor", &linear_arguments);
  recipe.offer<Projection>("Projection", [](const auto& f) {
    return py::make_tuple(f.keys()[0], f.keys()[1], f.keys()[2], f.pixel(), noise_of(f), f.loss());
  });
}

py::list state_of(const std::vector<MixtureComponent>& components) {
  py::list all;
  for (const MixtureComponent& c : components) {
    all.append(py::make_tuple(c.factor, c.constant, c.weak));
  }
  return all;
}

std::vector<MixtureComponent> to_components(const py::list& state) {
  std::vector<MixtureComponent> components;
  for (const py::handle item : state) {
    const auto part = py::reinterpret_borrow<py::tuple>(item);
    components.push_back({part[0].is_none() ? nullptr : part[0].cast<FactorArgument>().pointer,
                          part[1].cast<double>(), part[2].cast<bool>()});
  }
  return components;
}

py::object recipe_of(const ContinuousFactor& factor) {
  Recipe recipe(factor);
  offer_direct<SO2>(recipe);
  offer_direct<SE2>(recipe);
  offer_direct<SO3>(recipe);
  offer_direct<SE3>(recipe);
  offer_direct<Vector<1>>(recipe);
  offer_direct<Vector<2>>(recipe);
  offer_direct<Vector<3>>(recipe);
  offer_direct<Vector<4>>(recipe);
  offer_direct<Vector<5>>(recipe);
  offer_direct<Vector<6>>(recipe);
  offer_relative<Between<SO2>>(recipe);
  offer_relative<Between<SE2>>(recipe);
  offer_relative<Between<SO3>>(recipe);
  offer_relative<Between<SE3>>(recipe);
  offer_relative<Between<Vector<1>>>(recipe);
  offer_relative<Between<Vector<2>>>(recipe);
  offer_relative<Between<Vector<3>>>(recipe);
  offer_relative<BetweenSE2>(recipe, "BetweenSE2");
  offer_sensors<SE2>(recipe);
  offer_sensors<SE3>(recipe);
  offer_range<SE2, Vector<2>>(recipe);
  offer_range<SE2, SE2>(recipe);
  offer_range<Vector<2>, Vector<2>>(recipe);
  offer_range<SE3, Vector<3>>(recipe);
  offer_range<SE3, SE3>(recipe);
  offer_range<Vector<3>, Vector<3>>(recipe);
  offer_others(recipe);
  recipe.offer<Inflated>(
      "Inflated", [](const auto& f) { return py::make_tuple(f.factor(), f.variance_factor()); });
  recipe.offer<SoftMixture>("_SoftMixture", [](const auto& f) {
    return py::make_tuple(state_of(f.components()), f.temperature());
  });
  return recipe.found();
}

py::object hybrid_recipe_of(const HybridFactor& factor) {
  if (const auto* mixture = dynamic_cast<const Mixture*>(&factor)) {
    return py::make_tuple(
        "_Mixture", py::make_tuple(mixture->discrete_keys(), state_of(mixture->components())));
  }
  if (const auto* weighted = dynamic_cast<const WeightedFactor*>(&factor)) {
    return py::make_tuple("WeightedFactor", py::make_tuple(weighted->factor(), weighted->table()));
  }
  return py::none();
}

}  // namespace

void bind_pickle(py::module_& m) {
  m.def("_recipe", &recipe_of);
  m.def("_recipe", &hybrid_recipe_of);
  m.def("_Mixture", [](std::vector<DiscreteKey> keys, const py::list& components) {
    return std::shared_ptr<HybridFactor>(
        std::make_shared<Mixture>(std::move(keys), to_components(components)));
  });
  m.def("_SoftMixture", [](const py::list& components, double temperature) {
    return ContinuousFactorPtr(
        std::make_shared<SoftMixture>(to_components(components), temperature));
  });
}

}  // namespace hybrid::python
