// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/pose_graph/pose_graph.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

#include "libhybrid/core/error.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_graph.h"
#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/smoother/incremental.h"
#include "python/calls.h"
#include "python/fields.h"

namespace hybrid::python {
namespace {

/// A feed of a graph of its own, so that it does not matter what becomes of the one given.
struct FeedOfCopy {
  FeedOfCopy(const PoseGraph& g, const Values& initial, const GraphFactorOptions& options)
      : graph(g), feed(graph, initial, options) {}
  FeedOfCopy(const FeedOfCopy&) = delete;
  FeedOfCopy& operator=(const FeedOfCopy&) = delete;

  PoseGraph graph;
  PoseFeed feed;
};

}  // namespace

template <class T>
struct Blank<GraphEdge<T>> {
  static GraphEdge<T> make() { return {{}, {}, T(), Noise::unit(1)}; }
};

namespace {

template <class T>
constexpr bool kIsPlanar = std::is_same_v<T, SE2> || std::is_same_v<T, Eigen::Vector2d>;

template <class T>
bool has_variable(const std::vector<GraphEdge<T>>& edges, Key key) {
  return std::any_of(edges.begin(), edges.end(),
                     [&](const auto& edge) { return edge.from == key || edge.to == key; });
}

/// What speaks against an edge between two variables of a graph; "" where nothing does.
template <class T>
std::string fault_of(const PoseGraph& g, const GraphEdge<T>& edge) {
  using Pose = std::conditional_t<kIsPlanar<T>, SE2, SE3>;
  if (edge.from == edge.to) return to_string(edge.from) + " is both its ends";
  for (const auto& [key, type] :
       {std::pair(edge.from, Variable<Pose>::type()), std::pair(edge.to, Variable<T>::type())}) {
    if (g.values.contains(key) && g.values.type(key) != type) {
      return to_string(key) + " is " + to_string(g.values.type(key)) + ", not " + to_string(type);
    }
  }
  if (edge.noise.dim() != Variable<T>::kDim) {
    return "its noise has " + std::to_string(edge.noise.dim()) +
           " dimensions, and its measurement " + std::to_string(Variable<T>::kDim);
  }
  const bool has_others = kIsPlanar<T> ? !g.poses3.empty() || !g.points3.empty()
                                       : !g.poses2.empty() || !g.points2.empty();
  if (!has_others) return "";
  const std::string others = kIsPlanar<T> ? "in space" : "in the plane";
  for (const Key key : {edge.from, edge.to}) {
    const bool is_other = kIsPlanar<T>
                              ? has_variable(g.poses3, key) || has_variable(g.points3, key)
                              : has_variable(g.poses2, key) || has_variable(g.points2, key);
    if (is_other) return to_string(key) + " is " + others + " by other edges";
  }
  return "the other edges are " + others;
}

template <class T>
void bind_edge(py::module_& m, py::class_<PoseGraph>& graph, const char* name,
               std::vector<GraphEdge<T>> PoseGraph::*edges, const char* doc) {
  using Edge = GraphEdge<T>;
  FieldsClass<Edge>(m, name, doc)
      .def_readonly("from_key", &Edge::from)
      .def_readonly("to_key", &Edge::to)
      .def_readonly("measured", &Edge::measured)
      .def_readonly("noise", &Edge::noise);
  graph.def(
      "add_edge",
      [edges](PoseGraph& g, Key from, Key to, const T& measured, const Noise& noise) {
        const Edge edge{from, to, measured, noise};
        const std::string fault = fault_of(g, edge);
        if (!fault.empty()) {
          throw Error("edge from " + to_string(from) + " to " + to_string(to) + ": " + fault);
        }
        (g.*edges).push_back(edge);
      },
      "from_key"_a, "to_key"_a, "measured"_a, "noise"_a,
      "Adds a measurement of the second vertex in the frame of the first. An Error names the "
      "vertex "
      "where it is of another kind, or both are one.");
}

/// The fields of each entry of a list, for pickle.
template <class T, class... Fields>
py::list packed(const std::vector<T>& all, Fields T::*... fields) {
  py::list out;
  for (const T& entry : all) out.append(py::make_tuple(entry.*fields...));
  return out;
}

template <class T>
py::list packed_edges(const std::vector<GraphEdge<T>>& edges) {
  using E = GraphEdge<T>;
  return packed(edges, &E::from, &E::to, &E::measured, &E::noise);
}

template <class T>
py::list packed_priors(const std::vector<GraphPrior<T>>& priors) {
  using P = GraphPrior<T>;
  return packed(priors, &P::pose, &P::measured, &P::noise);
}

template <class T>
py::list packed_positions(const std::vector<GraphPosition<T>>& positions) {
  using P = GraphPosition<T>;
  return packed(positions, &P::pose, &P::measured, &P::noise, &P::lever_arm);
}

template <class T>
py::list packed_alternatives(const std::vector<EdgeAlternatives<T>>& alternatives) {
  using A = EdgeAlternatives<T>;
  return packed(alternatives, &A::edge, &A::measured);
}

template <class T, class... Fields, std::size_t... I>
T entry_of(const py::tuple& fields, std::index_sequence<I...>) {
  return T{fields[I].cast<Fields>()...};
}

template <class T, class... Fields>
void unpack(const py::object& state, std::vector<T>& all) {
  for (const py::handle entry : state) {
    all.push_back(entry_of<T, Fields...>(py::reinterpret_borrow<py::tuple>(entry),
                                         std::index_sequence_for<Fields...>{}));
  }
}

py::tuple state_of(const PoseGraph& g) {
  return py::make_tuple(g.values, packed_edges(g.poses2), packed_edges(g.poses3),
                        packed_edges(g.points2), packed_edges(g.points3), packed_priors(g.priors2),
                        packed_priors(g.priors3), packed_positions(g.positions2),
                        packed_positions(g.positions3), packed_alternatives(g.alternatives2),
                        packed_alternatives(g.alternatives3), g.fixed, g.equivalences, g.repaired,
                        g.unseen, g.edge2_by_rows);
}

PoseGraph from_state(const py::tuple& state) {
  using V2 = Eigen::Vector2d;
  using V3 = Eigen::Vector3d;
  PoseGraph g;
  std::size_t i = 0;
  g.values = state[i++].cast<Values>();
  unpack<GraphEdge<SE2>, Key, Key, SE2, Noise>(state[i++], g.poses2);
  unpack<GraphEdge<SE3>, Key, Key, SE3, Noise>(state[i++], g.poses3);
  unpack<GraphEdge<V2>, Key, Key, V2, Noise>(state[i++], g.points2);
  unpack<GraphEdge<V3>, Key, Key, V3, Noise>(state[i++], g.points3);
  unpack<GraphPrior<SE2>, Key, SE2, Noise>(state[i++], g.priors2);
  unpack<GraphPrior<SE3>, Key, SE3, Noise>(state[i++], g.priors3);
  unpack<GraphPosition<V2>, Key, V2, Noise, V2>(state[i++], g.positions2);
  unpack<GraphPosition<V3>, Key, V3, Noise, V3>(state[i++], g.positions3);
  unpack<EdgeAlternatives<SE2>, std::size_t, std::vector<SE2>>(state[i++], g.alternatives2);
  unpack<EdgeAlternatives<SE3>, std::size_t, std::vector<SE3>>(state[i++], g.alternatives3);
  g.fixed = state[i++].cast<std::vector<Key>>();
  g.equivalences = state[i++].cast<std::size_t>();
  g.repaired = state[i++].cast<std::size_t>();
  g.unseen = state[i++].cast<std::size_t>();
  g.edge2_by_rows = state[i++].cast<bool>();
  return g;
}

py::list edges_of(const PoseGraph& g) {
  py::list all;
  for (const auto& edge : g.poses2) all.append(edge);
  for (const auto& edge : g.poses3) all.append(edge);
  for (const auto& edge : g.points2) all.append(edge);
  for (const auto& edge : g.points3) all.append(edge);
  return all;
}

void bind_graph(py::module_& m) {
  py::class_<PoseGraph> graph(
      m, "PoseGraph",
      "The data of a pose graph, in 2-D or 3-D. Poses are 'x<id>', landmarks 'l<id>'.");
  graph.def(py::init<>())
      .def_readwrite("values", &PoseGraph::values,
                     "Initial values of the VERTEX lines; may be empty.")
      .def_readwrite("fixed", &PoseGraph::fixed, "Vertices that are held fixed.")
      .def_property_readonly("edge_count", &PoseGraph::edge_count)
      .def("__len__", &PoseGraph::edge_count, "Number of edges of all kinds.")
      .def(
          "__iter__", [](const PoseGraph& g) { return py::iter(edges_of(g)); },
          "The edges: poses2, poses3, points2, points3.")
      .def("__repr__",
           [](const PoseGraph& g) {
             return "<PoseGraph of " + std::to_string(g.edge_count()) + " edges and " +
                    std::to_string(g.values.size()) + " initial values>";
           })
      .def("__copy__", [](const PoseGraph& g) { return PoseGraph(g); })
      .def(
          "__deepcopy__", [](const PoseGraph& g, const py::dict&) { return PoseGraph(g); },
          "memo"_a)
      .def(py::pickle(&state_of, &from_state));
  bind_edge<SE2>(m, graph, "EdgeSE2", &PoseGraph::poses2, "A relative pose in the plane.");
  bind_edge<SE3>(m, graph, "EdgeSE3", &PoseGraph::poses3, "A relative pose in space.");
  bind_edge<Eigen::Vector2d>(m, graph, "EdgePoint2", &PoseGraph::points2,
                             "The position (2,) [m] of a landmark.");
  bind_edge<Eigen::Vector3d>(m, graph, "EdgePoint3", &PoseGraph::points3,
                             "The position (3,) [m] of a landmark.");
  graph.def_property_readonly("poses2", [](const PoseGraph& g) { return g.poses2; })
      .def_property_readonly("poses3", [](const PoseGraph& g) { return g.poses3; })
      .def_property_readonly("points2", [](const PoseGraph& g) { return g.points2; })
      .def_property_readonly("points3", [](const PoseGraph& g) { return g.points3; });
}

}  // namespace

void bind_pose_graph(py::module_& m) {
  bind_graph(m);
  SettingsClass<GraphFactorOptions>(m, "GraphFactorOptions",
                                    "Settings of the conversion of edges to factors.")
      .field("planar_logarithm", &GraphFactorOptions::planar_logarithm,
             "Use Between instead of BetweenSE2.")
      .field("loss", &GraphFactorOptions::loss, "Robust loss of all edges.")
      .field("anchor_sigma", &GraphFactorOptions::anchor_sigma,
             "Standard deviation [m, rad] of the priors of fixed poses.");
  m.def(
      "read_graph",
      [](const std::string& path, bool repair_information) {
        return read_graph(path, {repair_information});
      },
      "path"_a, "repair_information"_a = false, Unlocked(),
      "Reads a g2o or TORO file. An Error names file and line. Information that is not positive "
      "definite is an Error unless repair_information is set.");
  m.def("write_g2o", on_copies(&write_g2o), "path"_a, "graph"_a, "Writes a graph as g2o.");
  m.def(
      "initialize_from_tree", on_copies(&initialize_from_tree), "graph"_a,
      "Values of all vertices from relative motions along the shortest paths from the first pose, "
      "where the length of an edge is the variance of its rotation.");
  m.def("initialize_from_odometry", on_copies(&initialize_from_odometry), "graph"_a,
        "Values of all vertices from relative motions alone.");
  m.def("to_factors", &to_factors, "graph"_a, "initial"_a, "options"_a = GraphFactorOptions(),
        "One factor per edge, then a prior per fixed vertex, or for the first pose if none is "
        "fixed.");
  m.def("to_pose_graph", on_copies(&to_pose_graph), "graph"_a, "estimate"_a,
        "The part of an estimated graph that a g2o file can hold.");
  m.def("add_false_closures", &add_false_closures, "graph"_a, "rate"_a, "seed"_a,
        "The graph with added false closures (section V-A); `rate` is their share in [0, 1) of all "
        "closures.");
  py::class_<FeedOfCopy>(m, "PoseFeed",
                         "Returns a graph pose by pose, in the order of a robot's measurements.")
      .def(py::init<const PoseGraph&, const Values&, const GraphFactorOptions&>(), "graph"_a,
           "initial"_a, "options"_a = GraphFactorOptions(), "Of a copy of the graph.")
      .def("__len__", [](const FeedOfCopy& f) { return f.feed.steps(); })
      .def_property_readonly("done", [](const FeedOfCopy& f) { return f.feed.done(); })
      .def_property_readonly(
          "pose", [](const FeedOfCopy& f) { return f.feed.pose(); },
          "The pose that the next step adds.")
      .def(
          "next",
          [](FeedOfCopy& f, const IncrementalSmoother& smoother) {
            const SmootherInUse use(smoother, SmootherInUse::Kind::kRead);
            return f.feed.next(smoother.values());
          },
          "smoother"_a,
          "The next pose with its factors, with initial values from the smoother's estimate.")
      .def(
          "next", [](FeedOfCopy& f, const Values& estimate) { return f.feed.next(estimate); },
          "estimate"_a);
}

}  // namespace hybrid::python
