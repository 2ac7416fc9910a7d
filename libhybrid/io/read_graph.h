// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <string_view>

#include "libhybrid/core/error.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

struct ReadGraphOptions {
  /// Replaces information that is not positive definite by the nearest matrix that is (Higham,
  /// 1988), instead of an error: directions of no or negative information get that of a standard
  /// deviation some 10^4 times the smallest. PoseGraph::repaired counts these matrices.
  bool repair_information = false;
};

/// Thrown for information that is not positive definite.
class InformationError : public Error {
 public:
  using Error::Error;
};

/// Reads a g2o or TORO file; the tag of a line tells which it is:
///   VERTEX_SE2, VERTEX2             id x y angle
///   VERTEX_SE3:QUAT                 id x y z qx qy qz qw
///   VERTEX3                         id x y z roll pitch yaw
///   VERTEX_XY, VERTEX_TRACKXYZ      id x y [z]
///   EDGE_SE2                        i j x y angle, information row by row, upper triangle
///   EDGE2                           i j x y angle, I11 I12 I22 I33 I13 I23
///   EDGE2                           i 1 j 0 n, x y angle n times: n hypotheses of one motion
///   EDGE_SE3:QUAT                   i j x y z qx qy qz qw, information row by row
///   EDGE3                           i j x y z roll pitch yaw, information row by row
///   EDGE3                           i 1 j 0 n, x y z roll pitch yaw n times: n hypotheses
///   EDGE_SE2_XY                     i j x y, information row by row
///   EDGE_SE3_TRACKXYZ               i j parameter x y z, information row by row
///   EDGE_PRIOR_SE2, EDGE_SE2_PRIOR  i x y angle, information row by row
///   EDGE_PRIOR_SE2_XY               i x y, information row by row (EDGE_SE2_XYPRIOR too)
///   EDGE_SE3_PRIOR                  i parameter x y z qx qy qz qw, information row by row
///   EDGE_SE3_XYZPRIOR               i parameter x y z, information row by row
///   PARAMS_SE3OFFSET                id x y z qx qy qz qw: the pose of a sensor on the robot, which
///                                   `parameter` names; PARAMS_SE2OFFSET is not used
///   FIX                             id ...
///   EQUIV                           i j: counted, and not applied
/// Poses and landmarks may be numbered apart. Ids have 64 bits, see vertex_index. Measurements by a
/// sensor with an offset become those of the robot. The information of EDGE2 is taken row by row,
/// as iSAM writes it, if that is positive definite in all lines and TORO's order is not
/// (PoseGraph::edge2_by_rows). Landmarks that nothing measures are left out (PoseGraph::unseen).
/// EQUIV marks an edge whose ends TORO merges into one vertex on request (loadEquivalences);
/// otherwise it has no effect, in TORO and in other programs. Information is taken as that of the
/// tangent (translation, rotation vector); for EDGE3, whose angles are roll, pitch, yaw, this holds
/// to first order about small rotations. If any EDGE2 line has 8 numbers, or any EDGE3 line 11, all
/// of the file are of the form with hypotheses; these have no information, and get standard
/// deviations of 1/30 m and 1/100 rad. `#` starts a comment. Throws Error "file:line: what" for
/// anything else: unknown tags, numbers that are too few, too many, malformed or not finite,
/// quaternions that cannot be normalised, information that is not positive definite
/// (InformationError), edges from a vertex to itself, duplicate vertices, plane and space in one
/// file; and for a file that cannot be read or holds no vertex and no edge.
PoseGraph read_graph(const std::string& path, const ReadGraphOptions& options = {});

/// The same from text; `name` is the name of the file in messages.
PoseGraph parse_graph(std::string_view text, const std::string& name,
                      const ReadGraphOptions& options = {});

}  // namespace hybrid
