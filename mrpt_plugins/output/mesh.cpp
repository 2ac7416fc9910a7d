// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mesh.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>

#include "mrpt_plugins/drawing/canvas.h"

namespace hybrid {
namespace {

using Eigen::Vector3d;

mrpt::math::TPoint3Df to_float(const Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Vector3d on_sphere(double longitude, double latitude) {
  return {std::cos(longitude) * std::cos(latitude), std::sin(longitude) * std::cos(latitude),
          std::sin(latitude)};
}

}  // namespace

Mesh::Mesh() : triangles_(mrpt_scene::CSetOfTriangles::Create()) {}

void Mesh::set_color(Color color, double opacity) {
  color_ = {color.red, color.green, color.blue,
            static_cast<std::uint8_t>(std::lround(255 * opacity))};
}

void Mesh::triangle(const Vertex& a, const Vertex& b, const Vertex& c) {
  mrpt_scene::TTriangle t(to_float(a.point), to_float(b.point), to_float(c.point),
                          to_float(a.normal), to_float(b.normal), to_float(c.normal));
  for (auto& vertex : t.vertices) vertex.setColor(color_);
  triangles_->insertTriangle(t);
}

void Mesh::flat(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& inside) {
  Vector3d normal = (b - a).cross(c - a).normalized();
  if (normal.dot(a - inside) < 0) normal = -normal;
  triangle({a, normal}, {b, normal}, {c, normal});
}

void Mesh::tube(const std::vector<Vector3d>& path, double radius) {
  constexpr int kSides = 10;
  std::vector<Vertex> previous;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector3d before = i > 0 ? path[i - 1] : path[i];
    const Vector3d after = i + 1 < path.size() ? path[i + 1] : path[i];
    const Vector3d direction = after - before;
    if (!direction.allFinite() || direction.norm() < 1e-9) continue;
    const Vector3d along = direction.normalized();
    const Vector3d reference = std::abs(along.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
    const Vector3d side = reference.cross(along).normalized();
    const Vector3d up = along.cross(side);
    std::vector<Vertex> ring;
    for (int k = 0; k <= kSides; ++k) {
      const double angle = 2 * M_PI * k / kSides;
      const Vector3d normal = std::cos(angle) * side + std::sin(angle) * up;
      ring.push_back({path[i] + radius * normal, normal});
    }
    for (int k = 0; k < kSides && !previous.empty(); ++k) {
      triangle(previous[k], previous[k + 1], ring[k + 1]);
      triangle(previous[k], ring[k + 1], ring[k]);
    }
    previous = std::move(ring);
  }
}

void Mesh::block(const Vector3d& low, const Vector3d& high) {
  const Vector3d inside = 0.5 * (low + high);
  const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(low.x(), low.y()),
                                                  {high.x(), low.y()},
                                                  {high.x(), high.y()},
                                                  {low.x(), high.y()}};
  const auto corner = [&](std::size_t i, double z) {
    const Eigen::Vector2d& p = corners[i % corners.size()];
    return Vector3d(p.x(), p.y(), z);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    flat(corner(i, low.z()), corner(i + 1, low.z()), corner(i + 1, high.z()), inside);
    flat(corner(i, low.z()), corner(i + 1, high.z()), corner(i, high.z()), inside);
  }
  flat(corner(0, high.z()), corner(1, high.z()), corner(2, high.z()), inside);
  flat(corner(0, high.z()), corner(2, high.z()), corner(3, high.z()), inside);
}

void Mesh::ellipsoid(const Vector3d& center, const Eigen::Matrix3d& axes) {
  constexpr int kSlices = 24;
  constexpr int kStacks = 12;
  const Eigen::Matrix3d cofactor = axes.fullPivLu().isInvertible()
                                       ? Eigen::Matrix3d(axes.inverse().transpose())
                                       : Eigen::Matrix3d::Identity();
  const auto vertex = [&](int slice, int stack) {
    const Vector3d u = on_sphere(2 * M_PI * slice / kSlices, M_PI * stack / kStacks - M_PI / 2);
    return Vertex{center + axes * u, (cofactor * u).normalized()};
  };
  for (int stack = 0; stack < kStacks; ++stack) {
    for (int slice = 0; slice < kSlices; ++slice) {
      const Vertex a = vertex(slice, stack);
      const Vertex c = vertex(slice + 1, stack + 1);
      if (stack > 0) triangle(a, vertex(slice + 1, stack), c);
      if (stack + 1 < kStacks) triangle(a, c, vertex(slice, stack + 1));
    }
  }
}

void Mesh::prism(const std::vector<Eigen::Vector2d>& outline, const Vector3d& center,
                 const Eigen::Matrix3d& frame, double half_height, double top_scale) {
  const auto corner = [&](std::size_t i, bool top) {
    const Eigen::Vector2d p = (top ? top_scale : 1.0) * outline[i % outline.size()];
    return Vector3d(center + frame * Vector3d(p.x(), p.y(), top ? half_height : -half_height));
  };
  const Vector3d bottom = center - half_height * frame.col(2);
  const Vector3d top = center + half_height * frame.col(2);
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vector3d a = corner(i, false);
    const Vector3d b = corner(i + 1, false);
    flat(bottom, b, a, center);
    flat(a, b, corner(i + 1, true), center);
    if (top_scale <= 0) continue;
    flat(a, corner(i + 1, true), corner(i, true), center);
    flat(top, corner(i, true), corner(i + 1, true), center);
  }
}

void Mesh::marker(const Vector3d& center, Marker shape, double radius, const Vector3d& toward) {
  const Eigen::Matrix3d upright = Eigen::Matrix3d::Identity();
  switch (shape) {
    case Marker::kNone:
      return;
    case Marker::kCircle:
      ellipsoid(center, 1.05 * radius * Eigen::Matrix3d::Identity());
      return;
    case Marker::kSquare:
      prism(marker_outline(Marker::kSquare, radius), center, upright, 0.85 * radius, 1);
      return;
    case Marker::kTriangle:
      prism(marker_outline(Marker::kCircle, 1.2 * radius), center, upright, 1.2 * radius, 0);
      return;
    case Marker::kDiamond:
      for (const double side : {1.0, -1.0}) {
        const Vector3d half(0, 0, 0.75 * side * radius);
        prism(marker_outline(Marker::kDiamond, radius), center + half, upright, half.z(), 0);
      }
      return;
    case Marker::kPentagon:
    case Marker::kStar: {
      const Vector3d side = (toward + Vector3d(0, 1e-9, 0)).cross(Vector3d::UnitZ()).normalized();
      Eigen::Matrix3d frame;
      frame << side, side.cross(toward), toward;
      prism(marker_outline(shape, 1.15 * radius), center, frame, 0.4 * radius, 1);
      return;
    }
    case Marker::kPlus:
    case Marker::kCross:
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d arm = radius * Vector3d::Unit(axis);
        tube({center - arm, center + arm}, 0.05 * radius);
      }
      return;
  }
}

std::vector<std::vector<Vector3d>> dashes(const std::vector<Vector3d>& path, double on,
                                          double off) {
  std::vector<std::vector<Vector3d>> out;
  bool drawing = true;
  double left = on;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    Vector3d at = path[i];
    double rest = (path[i + 1] - at).norm();
    if (!std::isfinite(rest) || rest <= 0) continue;
    const Vector3d direction = (path[i + 1] - at) / rest;
    if (drawing && (out.empty() || out.back().empty())) out.push_back({at});
    while (rest > left) {
      at += left * direction;
      rest -= left;
      if (drawing) out.back().push_back(at);
      drawing = !drawing;
      left = drawing ? on : off;
      if (drawing) out.push_back({at});
    }
    left -= rest;
    if (drawing) out.back().push_back(path[i + 1]);
  }
  return out;
}

}  // namespace hybrid
