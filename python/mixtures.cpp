// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/hybrid/soft_mixture.h"
#include "libhybrid/hybrid/weighted.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

/// A mixture component passed from Python: a factor or None, and a constant.
using ComponentArgument = std::pair<std::optional<FactorArgument>, double>;

std::vector<MixtureComponent> to_components(const std::vector<ComponentArgument>& arguments) {
  std::vector<MixtureComponent> components;
  for (const auto& [factor, constant] : arguments) {
    components.push_back({factor ? factor->pointer : nullptr, constant});
  }
  return components;
}

std::shared_ptr<HybridFactor> mutable_pointer(const HybridFactorPtr& factor) {
  return std::const_pointer_cast<HybridFactor>(factor);
}

template <class Pose>
void bind_semantic(py::module_& m, const char* doc) {
  using Point = typename Pose::Point;
  m.def(
      "SemanticBearingRange",
      [](Key pose, Key point, DiscreteKey class_key, const Point& measured, const Noise& noise,
         const std::vector<double>& likelihood, const Pose& T_robot_sensor, const Loss& loss) {
        return mutable_pointer(make_semantic_bearing_range<Pose>(
            pose, point, class_key, measured, noise, likelihood, T_robot_sensor, loss));
      },
      "pose"_a, "point"_a, "class_key"_a, "measured"_a, "noise"_a, "likelihood"_a,
      "T_robot_sensor"_a = Pose(), "loss"_a = Loss::none(), doc);
}

}  // namespace

void bind_mixtures(py::module_& m) {
  py::class_<HybridFactor, std::shared_ptr<HybridFactor>>(
      m, "HybridFactor", "A factor over continuous and discrete variables (eq. 3).")
      .def_property_readonly("keys", &HybridFactor::keys, "Continuous variables.")
      .def_property_readonly("discrete_keys", &HybridFactor::discrete_keys)
      .def_property_readonly("name", &HybridFactor::name)
      .def("cost", &HybridFactor::cost, "values"_a, "assignment"_a,
           "-log f at continuous and discrete values.")
      .def("__repr__", [](const HybridFactor& factor) {
        return "<" + describe(factor.name(), factor.keys()) + ">";
      });
  m.def(
      "Mixture",
      [](std::vector<DiscreteKey> keys, const std::vector<ComponentArgument>& components) {
        return mutable_pointer(
            std::make_shared<Mixture>(std::move(keys), to_components(components)));
      },
      "discrete_keys"_a, "components"_a,
      "One component for each joint value of the discrete variables, the first varying slowest: "
      "pairs of a factor and -log of its weight. For a component without a factor (None), the "
      "number is its whole -log density.");
  m.def(
      "OutlierMixture",
      [](DiscreteKey switch_key, const FactorArgument& inlier, const FactorArgument& outlier,
         double inlier_weight, double outlier_weight) {
        return mutable_pointer(make_outlier_mixture(switch_key, inlier.pointer, outlier.pointer,
                                                    inlier_weight, outlier_weight));
      },
      "switch_key"_a, "inlier"_a, "outlier"_a, "inlier_weight"_a = 0.5, "outlier_weight"_a = 0.5,
      "A measurement that may be false (eq. 17): value 0 of the switch is the inlier, 1 the "
      "outlier model, such as Inflated. Weights are prior probabilities.");
  m.def(
      "SoftMixture",
      [](const std::vector<ComponentArgument>& components, double temperature) {
        return ContinuousFactorPtr(
            std::make_shared<SoftMixture>(to_components(components), temperature));
      },
      "components"_a, "temperature"_a = 1.0,
      "A mixture with its discrete variable summed out: pairs of a factor and -log of its weight.");
  m.def(
      "WeightedFactor",
      [](const FactorArgument& factor, const Table& table) {
        return mutable_pointer(std::make_shared<WeightedFactor>(factor.pointer, table));
      },
      "factor"_a, "table"_a, "The product of a continuous factor and a table.");
  bind_semantic<SE2>(m,
                     "Range [m] and bearing [rad] (2,) of a landmark with a class (eq. 19): "
                     "BearingRange times the likelihood (classes,) of the detector's output.");
  bind_semantic<SE3>(m, "The same in 3-D: range [m], yaw and pitch [rad] (3,).");
}

}  // namespace hybrid::python
