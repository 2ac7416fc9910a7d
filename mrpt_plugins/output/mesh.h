// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/style.h"
#include "mrpt_plugins/mrpt_version.h"
#include HYBRID_MRPT_SCENE(CSetOfTriangles)

namespace HYBRID_API hybrid {

/// Solids as triangles, since MRPT 2.5 draws lines one pixel wide and ellipsoids with wrong axes,
/// and MRPT 3.1 no sets of lines. They are drawn in the order in which they are added; meshes in
/// none that holds for both versions, so that what is seen through something belongs to its mesh.
class Mesh {
 public:
  Mesh();

  /// Of what is added from now on; opacity from 0 to 1.
  void set_color(Color color, double opacity = 1);
  /// A round tube along a path; segments without length are skipped.
  void tube(const std::vector<Eigen::Vector3d>& path, double radius);
  /// An upright block between two corners, without its bottom.
  void block(const Eigen::Vector3d& low, const Eigen::Vector3d& high);
  /// center + axes * u for all unit vectors u.
  void ellipsoid(const Eigen::Vector3d& center, const Eigen::Matrix3d& axes);
  /// The solid of a marker, `radius` metres: sphere, cube, cone, octahedron, thick pentagon or star
  /// facing `toward`, or cross of three bars.
  void marker(const Eigen::Vector3d& center, Marker shape, double radius,
              const Eigen::Vector3d& toward = Eigen::Vector3d::UnitZ());

  mrpt_scene::CSetOfTriangles::Ptr object() const { return triangles_; }

 private:
  struct Vertex {
    Eigen::Vector3d point, normal;
  };
  void triangle(const Vertex& a, const Vertex& b, const Vertex& c);
  void flat(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
            const Eigen::Vector3d& inside);
  /// A prism between an outline as base and the same scaled by `top_scale` as top, rotated by
  /// `frame`.
  void prism(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector3d& center,
             const Eigen::Matrix3d& frame, double half_height, double top_scale);

  mrpt_scene::CSetOfTriangles::Ptr triangles_;
  mrpt::img::TColor color_;
};

/// The dashes of a path: stretches of `on` metres, `off` metres apart.
std::vector<std::vector<Eigen::Vector3d>> dashes(const std::vector<Eigen::Vector3d>& path,
                                                 double on, double off);

}  // namespace hybrid
