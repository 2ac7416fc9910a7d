// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The laws that every group obeys, in one suite.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/prior.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

template <class G>
double distance(const G& a, const G& b) {
  return (a.matrix() - b.matrix()).norm();
}

/// exp as a power series of the adjoint representation: an oracle free of closed forms.
template <class Matrix>
Matrix matrix_exp(const Matrix& m) {
  Matrix sum = Matrix::Identity();
  Matrix term = Matrix::Identity();
  for (int n = 1; n < 60; ++n) {
    term = (term * m / n).eval();
    sum += term;
  }
  return sum;
}

Eigen::Matrix<double, 1, 1> ad(const Eigen::Matrix<double, 1, 1>&) {
  return Eigen::Matrix<double, 1, 1>::Zero();
}
/// The adjoint of the algebra: SE2 and SO3 share their tangent type, so the group is named.
template <class G>
typename G::Jacobian algebra_adjoint(const typename G::Tangent& v) {
  if constexpr (std::is_same_v<G, SO2>) {
    return ad(v);
  } else if constexpr (std::is_same_v<G, SO3>) {
    return hat(v);
  } else if constexpr (std::is_same_v<G, SE2>) {
    typename G::Jacobian m;
    m << 0.0, -v[2], v[1], v[2], 0.0, -v[0], 0.0, 0.0, 0.0;
    return m;
  } else {
    typename G::Jacobian m;
    m << hat(v.template tail<3>()), hat(v.template head<3>()), Eigen::Matrix3d::Zero(),
        hat(v.template tail<3>());
    return m;
  }
}

template <class G>
class GroupTest : public ::testing::Test {
 protected:
  using Tangent = typename G::Tangent;
  static constexpr int kRotations = G::kDim == 6 || std::is_same_v<G, SO3> ? 3 : 1;

  /// A tangent whose rotation part has the given norm.
  Tangent tangent(double angle) {
    Tangent v = random.vector<G::kDim>();
    v.template tail<kRotations>() *= angle / v.template tail<kRotations>().norm();
    return v;
  }
  /// Zero, tiny, around the switches between series and closed forms, large, almost pi.
  std::vector<double> angles() const {
    return {0.0,     1e-300, 1e-12,  1e-8, 0.99e-4,     1.01e-4,    0.99e-2,
            1.01e-2, 0.0499, 0.0501, 0.1,  0.2,         0.4999,     0.5001,
            1.0,     2.0,    3.0,    3.14, M_PI - 1e-6, M_PI - 1e-9};
  }

  Random random{17};
};

using Groups = ::testing::Types<SO2, SE2, SO3, SE3>;
TYPED_TEST_SUITE(GroupTest, Groups);

TYPED_TEST(GroupTest, Axioms) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto a = this->random.template value<TypeParam>();
    const auto b = this->random.template value<TypeParam>();
    const auto c = this->random.template value<TypeParam>();
    EXPECT_LT(distance((a * b) * c, a * (b * c)), 1e-13);
    EXPECT_LT(distance(a * a.inverse(), TypeParam()), 1e-14);
    EXPECT_LT(distance(a.inverse() * a, TypeParam()), 1e-14);
    EXPECT_LT(distance(a * TypeParam(), a), 1e-14);
    EXPECT_LT(distance(a.between(b), a.inverse() * b), 1e-13);
    EXPECT_LT(((a * b).matrix() - a.matrix() * b.matrix()).norm(), 1e-13);
  }
}

TYPED_TEST(GroupTest, ActsOnPointsAsItsMatrix) {
  const auto a = this->random.template value<TypeParam>();
  const auto m = a.matrix();
  constexpr int kPoint = TestFixture::kRotations == 3 ? 3 : 2;
  const Eigen::Matrix<double, kPoint, 1> p = this->random.template vector<kPoint>();
  Eigen::VectorXd h = Eigen::VectorXd::Ones(m.rows());
  h.template head<kPoint>() = p;
  EXPECT_LT((a * p - (m * h).template head<kPoint>()).norm(), 1e-14);
}

TYPED_TEST(GroupTest, LogInvertsExp) {
  for (double angle : this->angles()) {
    const auto v = this->tangent(angle > 0 ? angle : 1e-30);
    EXPECT_LT((TypeParam::exp(v).log() - v).norm(), 1e-9 * (1.0 + v.norm())) << "angle " << angle;
    const auto g = TypeParam::exp(v);
    EXPECT_LT(distance(TypeParam::exp(g.log()), g), 1e-12) << "angle " << angle;
  }
  const typename TypeParam::Tangent zero = TypeParam::Tangent::Zero();
  EXPECT_EQ(TypeParam::exp(zero).log().norm(), 0.0);
}

TYPED_TEST(GroupTest, LogOfAnAngleBeyondPiIsTheShorterWay) {
  const auto v = this->tangent(M_PI + 0.5);
  const auto log = TypeParam::exp(v).log();
  EXPECT_NEAR(log.template tail<TestFixture::kRotations>().norm(), M_PI - 0.5, 1e-12);
  EXPECT_LT(distance(TypeParam::exp(log), TypeParam::exp(v)), 1e-12);
}

TYPED_TEST(GroupTest, AdjointMovesATangentAcross) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto a = this->random.template value<TypeParam>();
    const auto v = this->random.template vector<TypeParam::kDim>();
    const typename TypeParam::Tangent moved = a.adjoint() * v;
    EXPECT_LT(distance(a * TypeParam::exp(v), TypeParam::exp(moved) * a), 1e-12);
    const typename TypeParam::Jacobian j = TypeParam::right_jacobian(v);
    EXPECT_LT((a.times_inverse_adjoint(j) - j * a.inverse().adjoint()).norm(), 1e-13);
  }
}

TYPED_TEST(GroupTest, AdjointOfExpIsExpOfTheAlgebra) {
  for (double angle : this->angles()) {
    const auto v = this->tangent(angle > 0 ? angle : 1e-30);
    const auto oracle = matrix_exp<typename TypeParam::Jacobian>(algebra_adjoint<TypeParam>(v));
    EXPECT_LT((TypeParam::exp(v).adjoint() - oracle).norm(), 1e-11) << "angle " << angle;
  }
}

TYPED_TEST(GroupTest, RightJacobianIsItsPowerSeries) {
  // Jr(v) = sum over n of (-ad v)^n / (n + 1)!.
  using Matrix = typename TypeParam::Jacobian;
  for (double angle : this->angles()) {
    const auto v = this->tangent(angle > 0 ? angle : 1e-30);
    const Matrix step = -algebra_adjoint<TypeParam>(v);
    Matrix sum = Matrix::Identity();
    Matrix term = Matrix::Identity();
    for (int n = 1; n < 60; ++n) {
      term = (term * step / (n + 1)).eval();
      sum += term;
    }
    EXPECT_LT((TypeParam::right_jacobian(v) - sum).norm(), 1e-11) << "angle " << angle;
  }
}

TYPED_TEST(GroupTest, RightJacobianAgreesWithNumericOne) {
  for (double angle : {0.0, 1e-3, 0.3, 1.0, 3.0}) {
    const auto v = this->tangent(angle > 0 ? angle : 1e-30);
    const auto J = TypeParam::right_jacobian(v);
    const double h = 1e-5;
    for (int d = 0; d < TypeParam::kDim; ++d) {
      const typename TypeParam::Tangent e = h * TypeParam::Tangent::Unit(d);
      const auto g = TypeParam::exp(v);
      const typename TypeParam::Tangent forth = v + e;
      const typename TypeParam::Tangent back = v - e;
      const typename TypeParam::Tangent numeric = ((g.inverse() * TypeParam::exp(forth)).log() -
                                                   (g.inverse() * TypeParam::exp(back)).log()) /
                                                  (2 * h);
      EXPECT_LT((J.col(d) - numeric).norm(), 1e-8) << "angle " << angle << " column " << d;
    }
  }
}

TYPED_TEST(GroupTest, InverseOfRightJacobian) {
  using Matrix = typename TypeParam::Jacobian;
  for (double angle : this->angles()) {
    const auto v = this->tangent(angle > 0 ? angle : 1e-30);
    const Matrix inverse = TypeParam::right_jacobian_inverse(v);
    EXPECT_LT((inverse * TypeParam::right_jacobian(v) - Matrix::Identity()).norm(), 1e-10)
        << "angle " << angle;
    Matrix with_log;
    const auto log = TypeParam::exp(v).log(&with_log);
    EXPECT_EQ(log, TypeParam::exp(v).log());
    EXPECT_LT((with_log - TypeParam::right_jacobian_inverse(log)).norm(), 1e-10)
        << "angle " << angle;
  }
}

/// Storage of a value whose rotation is scaled off unit norm.
template <class G>
std::vector<double> scaled_rotation(const G& g, int rotations, double scale) {
  std::vector<double> x(G::kSize);
  g.store(x.data());
  for (int i = G::kSize - rotations - 1; i < G::kSize; ++i) x[i] *= scale;
  return x;
}

TYPED_TEST(GroupTest, NormalizeRemovesAnyScale) {
  const auto g = this->random.template value<TypeParam>();
  EXPECT_TRUE(g.is_unit());
  for (double scale : {1.0 + 1e-9, 1.0 - 1e-6, 0.5, 2.236, 1e-200, 1e200}) {
    auto scaled = TypeParam::load(scaled_rotation(g, this->kRotations, scale).data());
    EXPECT_FALSE(scaled.is_unit()) << scale;
    scaled.normalize();
    EXPECT_LT(distance(scaled, g), 1e-14) << scale;
  }
}

TYPED_TEST(GroupTest, NormalizeRemovesDrift) {
  auto g = this->random.template value<TypeParam>();
  const auto step = TypeParam::exp(this->random.template vector<TypeParam::kDim>(0.01));
  for (int i = 0; i < 1000; ++i) {
    g = g * step;
    g.normalize();
  }
  EXPECT_LT(distance(g * g.inverse(), TypeParam()), 1e-12);
}

TYPED_TEST(GroupTest, ValuesTakeARotationOfAnyScaleButZero) {
  const auto g = this->random.template value<TypeParam>();
  const VariableType type = Variable<TypeParam>::type();
  Values values;
  values.insert(Key('x', 0), type, scaled_rotation(g, this->kRotations, 2.236).data());
  EXPECT_LT(distance(values.at<TypeParam>(Key('x', 0)), g), 1e-14);
  values.insert(Key('x', 1), g);
  EXPECT_EQ(distance(values.at<TypeParam>(Key('x', 1)), g), 0.0);  // not a bit changed
  EXPECT_THROW(values.insert(Key('x', 2), type, scaled_rotation(g, this->kRotations, 0.0).data()),
               Error);
  EXPECT_EQ(values.size(), 2u);
}

TYPED_TEST(GroupTest, StoreAndLoad) {
  const auto g = this->random.template value<TypeParam>();
  double x[TypeParam::kSize + 1];
  x[TypeParam::kSize] = 42.0;
  g.store(x);
  EXPECT_EQ(x[TypeParam::kSize], 42.0);
  EXPECT_EQ(distance(TypeParam::load(x), g), 0.0);
}

TYPED_TEST(GroupTest, LocalInvertsRetract) {
  const VariableType type = Variable<TypeParam>::type();
  EXPECT_EQ(type.dim, TypeParam::kDim);
  EXPECT_EQ(type.size, TypeParam::kSize);
  double x[8], y[8], delta[8];
  this->random.template value<TypeParam>().store(x);
  const auto v = this->tangent(1.0);
  retract(type, x, v.data(), y);
  local(type, x, y, delta);
  for (int i = 0; i < type.dim; ++i) EXPECT_NEAR(delta[i], v[i], 1e-12);
  EXPECT_LT(distance(TypeParam::load(y), TypeParam::load(x) * TypeParam::exp(v)), 1e-14);
  retract(type, x, v.data(), x);  // in place
  EXPECT_EQ(distance(TypeParam::load(x), TypeParam::load(y)), 0.0);
}

TEST(Vectors, LocalInvertsRetract) {
  const VariableType type = Variable<Eigen::Vector2d>::type();
  const double x[] = {1.0, 2.0};
  const double v[] = {0.5, -1.0};
  double y[2], delta[2];
  retract(type, x, v, y);
  EXPECT_EQ(y[0], 1.5);
  EXPECT_EQ(y[1], 1.0);
  local(type, x, y, delta);
  EXPECT_EQ(delta[0], 0.5);
  EXPECT_EQ(delta[1], -1.0);
}

TEST(Hat, IsTheCrossProduct) {
  Random random{2};
  const Eigen::Vector3d a = random.vector<3>();
  const Eigen::Vector3d b = random.vector<3>();
  EXPECT_LT((hat(a) * b - a.cross(b)).norm(), 1e-15);
}

TEST(SO3, MatchesEigenAngleAxis) {
  Random random{4};
  const Eigen::Vector3d v = random.vector<3>();
  const Eigen::AngleAxisd oracle(v.norm(), v.normalized());
  EXPECT_LT((SO3::exp(v).matrix() - oracle.toRotationMatrix()).norm(), 1e-14);
}

TEST(SO3, IsTheRotationOfAQuaternionOfAnyNorm) {
  Random random{5};
  const SO3 r = random.value<SO3>();
  for (double scale : {1.0 + 1e-7, 2.236, 1e-3, 1e200}) {
    const SO3 scaled(Eigen::Quaterniond(scale * r.quaternion().coeffs()));
    EXPECT_LT(distance(scaled, r), 1e-14) << scale;
    EXPECT_NEAR(scaled.quaternion().norm(), 1.0, 1e-15);
    EXPECT_LT(distance(SE3({1.0, 2.0, 3.0}, scaled.quaternion()), SE3({1.0, 2.0, 3.0}, r)), 1e-14);
  }
  EXPECT_EQ(SO3(r.quaternion()).quaternion().coeffs(), r.quaternion().coeffs());
  const SO3 none(Eigen::Quaterniond(0.0, 0.0, 0.0, 0.0));
  EXPECT_FALSE(none.quaternion().coeffs().allFinite());
  EXPECT_THROW(Prior<SO3>(Key('x', 0), none, Noise::unit(3)), Error);
}

TEST(SO2, IsTheDirectionOfCosineAndSine) {
  const SO2 r = SO2::from_cos_sin(3.0, 4.0);
  EXPECT_NEAR(r.cos(), 0.6, 1e-15);
  EXPECT_NEAR(r.sin(), 0.8, 1e-15);
  EXPECT_THROW(Prior<SO2>(Key('x', 0), SO2::from_cos_sin(0.0, 0.0), Noise::unit(1)), Error);
}

TEST(SO3, LogOfBothQuaternionsOfARotationIsOne) {
  Random random{6};
  const Eigen::Quaterniond q = random.value<SO3>().quaternion();
  const Eigen::Quaterniond opposite(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_LT((SO3(q).log() - SO3(opposite).log()).norm(), 1e-15);
}

TEST(WrapAngle, StaysWithinPi) {
  for (double angle : {0.0, 3.0, -3.0, 4.0, -4.0, 100.0, -1e6}) {
    const double wrapped = wrap_angle(angle);
    EXPECT_LE(std::abs(wrapped), M_PI);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-9);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-9);
  }
}

TEST(SmallAngles, LogarithmsAreExactToRounding) {
  for (int i = 0; i < 880; ++i) {
    const double angle = 1e-12 * std::pow(1.03, i);  // to 0.2
    for (const double a : {angle, -angle}) {
      EXPECT_NEAR(SO2(a).angle(), a, 4e-16 * angle);
      EXPECT_NEAR(SO3::exp({0.0, a, 0.0}).log().y(), a, 8e-16 * angle);
    }
  }
  EXPECT_TRUE(std::signbit(SO2(-0.0).angle()));
}

}  // namespace
}  // namespace hybrid
