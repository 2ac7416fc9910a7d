// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <sstream>

#include "libhybrid/core/variable.h"
#include "python/bindings.h"

namespace hybrid::python {
namespace {

using Storage = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Applies a group element to points, n x d, row by row.
template <class Group, int kDim>
Eigen::Matrix<double, Eigen::Dynamic, kDim, Eigen::RowMajor> move_all(
    const Group& group,
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, kDim, Eigen::RowMajor>>& points) {
  Eigen::Matrix<double, Eigen::Dynamic, kDim, Eigen::RowMajor> moved(points.rows(), kDim);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Matrix<double, kDim, 1> p = points.row(i);
    moved.row(i) = (group * p).transpose();
  }
  return moved;
}

template <class Group>
Group from_storage(const Storage& array) {
  if (array.size() != Group::kSize) {
    throw Error("the storage of this group has " + std::to_string(int{Group::kSize}) +
                " numbers, got " + std::to_string(array.size()));
  }
  Group group = Group::load(array.data());
  if (!group.is_unit()) group.normalize();
  return group;
}

template <class Group>
Storage to_storage(const Group& group) {
  Storage array(Group::kSize);
  group.store(array.mutable_data());
  return array;
}

/// Binds the members common to all groups; `kPoint` is the dimension of the points that they act
/// on.
template <class Group, int kPoint>
py::class_<Group> bind_group(py::module_& m, const char* name, const char* doc) {
  using Tangent = typename Group::Tangent;
  return py::class_<Group>(m, name, doc)
      .def("inverse", &Group::inverse, "The inverse.")
      .def("between", &Group::between, "other"_a, "inverse() * other.")
      .def(
          "__mul__", [](const Group& a, const Group& b) { return a * b; }, "other"_a,
          "Composition.")
      .def(
          "__matmul__", [](const Group& a, const Group& b) { return a * b; }, "other"_a)
      .def(
          "__mul__",
          [](const Group& a, const Eigen::Matrix<double, kPoint, 1>& p) {
            return Eigen::Matrix<double, kPoint, 1>(a * p);
          },
          "point"_a, "A point, moved.")
      .def("__mul__", &move_all<Group, kPoint>, "points"_a,
           "Applies the element to points, one per row.")
      .def_static(
          "exp", [](const Tangent& v) { return Group::exp(v); }, "tangent"_a,
          "The element of a tangent vector at the identity.")
      .def(
          "log", [](const Group& g) { return Tangent(g.log()); },
          "The tangent vector at the identity: exp(log()) is the element.")
      .def(
          "retract", [](const Group& g, const Tangent& v) { return g * Group::exp(v); },
          "tangent"_a, "self * exp(tangent): the update of a variable by solvers.")
      .def(
          "local",
          [](const Group& g, const Group& other) { return Tangent(g.between(other).log()); },
          "other"_a, "The tangent vector with retract(local(other)) equal to other.")
      .def(
          "adjoint", [](const Group& g) { return Eigen::MatrixXd(g.adjoint()); },
          "The matrix A with T exp(v) = exp(A v) T.")
      .def("matrix", &Group::matrix, "The matrix; homogeneous for rigid motions.")
      .def_static("from_storage", &from_storage<Group>, "storage"_a,
                  "From the numbers of `storage`; normalises rotations.")
      .def_property_readonly("storage", &to_storage<Group>,
                             "The numbers stored for a variable of this type.")
      .def_property_readonly_static("dim", [](const py::object&) { return int{Group::kDim}; })
      .def(py::pickle(&to_storage<Group>, &from_storage<Group>));
}

template <class Group>
std::string text(const char* name, const Group& group) {
  double x[Group::kSize];
  group.store(x);
  std::ostringstream out;
  out << name << ".from_storage([";
  for (int i = 0; i < Group::kSize; ++i) out << (i == 0 ? "" : ", ") << x[i];
  out << "])";
  return out.str();
}

void bind_plane(py::module_& m) {
  bind_group<SO2, 2>(m, "SO2",
                     "Rotation in the plane. Tangent (1,): the angle [rad]. Storage: cos, sin.")
      .def(py::init<>())
      .def(py::init<double>(), "angle"_a, "By an angle [rad].")
      .def_property_readonly("angle", &SO2::angle, "In (-pi, pi] [rad].")
      .def("__repr__", [](const SO2& r) {
        std::ostringstream out;
        out << "SO2(" << r.angle() << ")";
        return out.str();
      });
  bind_group<SE2, 2>(m, "SE2",
                     "Rigid motion in the plane. Tangent (3,): x, y [m], angle [rad], in the local "
                     "frame. Storage: x, y, cos, sin.")
      .def(py::init<>())
      .def(py::init<double, double, double>(), "x"_a, "y"_a, "angle"_a,
           "From a position [m] and an angle [rad].")
      .def(py::init<const Eigen::Vector2d&, const SO2&>(), "translation"_a, "rotation"_a)
      .def_property_readonly(
          "translation", [](const SE2& T) { return T.translation(); }, "(2,) [m].")
      .def_property_readonly("rotation", [](const SE2& T) { return T.rotation(); })
      .def_property_readonly("x", &SE2::x, "[m].")
      .def_property_readonly("y", &SE2::y, "[m].")
      .def_property_readonly("angle", &SE2::angle, "In (-pi, pi] [rad].")
      .def("__repr__", [](const SE2& T) {
        std::ostringstream out;
        out << "SE2(" << T.x() << ", " << T.y() << ", " << T.angle() << ")";
        return out.str();
      });
}

SO3 from_quaternion(const Eigen::Vector4d& q) {
  return SO3(Eigen::Quaterniond(q));
}
SO3 from_matrix(const Eigen::Matrix3d& R) {
  return SO3(Eigen::Quaterniond(R));
}

void bind_space(py::module_& m) {
  bind_group<SO3, 3>(m, "SO3",
                     "Rotation in space. Tangent (3,): rotation vector [rad], in the local frame. "
                     "Storage: the unit quaternion x, y, z, w.")
      .def(py::init<>())
      .def_static("from_quaternion", &from_quaternion, "q"_a, "From x, y, z, w of any norm but 0.")
      .def_static("from_matrix", &from_matrix, "R"_a, "From a rotation matrix (3, 3).")
      .def_property_readonly(
          "quaternion", [](const SO3& r) { return Eigen::Vector4d(r.quaternion().coeffs()); },
          "(4,): x, y, z, w.")
      .def("__repr__", [](const SO3& r) { return text("SO3", r); });
  bind_group<SE3, 3>(m, "SE3",
                     "Rigid motion in space. Tangent (6,): translation [m], rotation vector [rad], "
                     "in the local frame. Storage: x, y, z, qx, qy, qz, qw.")
      .def(py::init<>())
      .def(py::init<const Eigen::Vector3d&, const SO3&>(), "translation"_a, "rotation"_a)
      .def_static(
          "from_matrix",
          [](const Eigen::Matrix4d& T) {
            return SE3(Eigen::Vector3d(T.topRightCorner<3, 1>()),
                       from_matrix(T.topLeftCorner<3, 3>()));
          },
          "T"_a, "From a homogeneous matrix (4, 4).")
      .def_property_readonly(
          "translation", [](const SE3& T) { return T.translation(); }, "(3,) [m].")
      .def_property_readonly("rotation", [](const SE3& T) { return T.rotation(); })
      .def("__repr__", [](const SE3& T) { return text("SE3", T); });
}

}  // namespace

void bind_geometry(py::module_& m) {
  bind_plane(m);
  bind_space(m);
}

}  // namespace hybrid::python
