// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/align/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace planar_bin_picking {
namespace {

/// Points on a line in six dimensions: residual x . a - y, by Tukey's biweight.
struct Problem {
  std::vector<Vector6d> a;
  std::vector<double> y;

  NormalEquations at(const Vector6d& x, double width) const {
    NormalEquations out;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double r = a[i].dot(x) - y[i], e = 1.0 - r * r / (width * width);
      out.cost += e <= 0.0 ? 1.0 : 1.0 - e * e * e;
      if (e > 0.0) out.add(a[i], r, e * e);
    }
    return out;
  }
};

const Vector6d kTruth = (Vector6d() << 1, -2, 0.5, 0.3, -0.7, 2).finished();

Problem problemWith(int outliers) {
  Problem p;
  for (int i = 0; i < 60; ++i) {
    Vector6d a;
    for (int k = 0; k < 6; ++k) a(k) = std::sin(1.7 * i + 2.3 * k * i + k);
    p.a.push_back(a);
    p.y.push_back(a.dot(kTruth) + (i < outliers ? 30.0 : 0.0));
  }
  return p;
}

Vector6d solve(const Problem& p, const LevenbergMarquardtParams& params, int* evaluations) {
  *evaluations = 0;
  return minimise(
             Vector6d(Vector6d::Zero()), params,
             [&](const Vector6d& x, int k, double width) {
               EXPECT_EQ(k, (*evaluations)++);
               return p.at(x, width);
             },
             [](const Vector6d& x, const Vector6d& xi) -> Vector6d { return x + xi; })
      .state;
}

TEST(LevenbergMarquardt, FindsTheTruthDespiteOutliers) {
  LevenbergMarquardtParams params;
  params.evaluations = 30;
  params.width = 20.0;
  params.width_end = 1.0;
  params.width_decay = 0.8;
  int evaluations = 0;
  EXPECT_LT((solve(problemWith(10), params, &evaluations) - kTruth).norm(), 1e-3);
  EXPECT_EQ(evaluations, 30);
}

TEST(LevenbergMarquardt, EndsWhereNothingIsGainedAnyMore) {
  LevenbergMarquardtParams params;
  params.evaluations = 30;
  params.width = params.width_end = 20.0;
  params.gain_least = 1e-6;
  int evaluations = 0;
  EXPECT_LT((solve(problemWith(0), params, &evaluations) - kTruth).norm(), 1e-2);
  EXPECT_LT(evaluations, 12);
}

/// Rosenbrock's valley, where a full step leads uphill: the best state is kept, the damping rises.
TEST(LevenbergMarquardt, NeverReturnsAWorseState) {
  const auto evaluate = [](const Vector6d& x, int, double) {
    NormalEquations out;
    Vector6d J = Vector6d::Zero();
    J(0) = -20.0 * x(0);
    J(1) = 10.0;
    const double r = 10.0 * (x(1) - x(0) * x(0));
    out.add(J, r, 1.0);
    J.setZero();
    J(0) = -1.0;
    out.add(J, 1.0 - x(0), 1.0);
    out.cost = r * r + (1.0 - x(0)) * (1.0 - x(0));
    return out;
  };
  Vector6d start = Vector6d::Zero();
  start(0) = -1.2;
  start(1) = 1.0;
  double last = evaluate(start, 0, 1.0).cost;
  for (const int evaluations : {1, 2, 4, 8, 16, 32, 64}) {
    LevenbergMarquardtParams params;
    params.evaluations = evaluations;
    const Minimum<Vector6d> x =
        minimise(start, params, evaluate,
                 [](const Vector6d& a, const Vector6d& xi) -> Vector6d { return a + xi; });
    const double cost = evaluate(x.state, 0, 1.0).cost;
    EXPECT_EQ(x.equations.cost, cost) << evaluations;
    EXPECT_LE(cost, last) << evaluations;
    last = cost;
  }
  EXPECT_LT(last, 1e-6);
}

/// No residual at all: the state stays.
TEST(LevenbergMarquardt, NothingSeenLeavesTheStart) {
  int evaluations = 0;
  EXPECT_TRUE(solve({}, {}, &evaluations).isZero(0.0));
}

}  // namespace
}  // namespace planar_bin_picking
