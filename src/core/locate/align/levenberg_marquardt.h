// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The one robust Levenberg-Marquardt of the refinement: in the distance field with a width that
/// shrinks (graduated non-convexity), in the image with a fixed one.

#include "planar_bin_picking/base/types.h"

#include <Eigen/Cholesky>

#include <algorithm>

namespace planar_bin_picking {

/// Normal equations of weighted scalar residuals in six unknowns: H xi = -b.
struct NormalEquations {
  Matrix6d H = Matrix6d::Zero();
  Vector6d b = Vector6d::Zero();
  double cost = 0.0;
  int used = 0;  ///< residuals with a weight

  void add(const Vector6d& J, double r, double weight) {
    const Vector6d wJ = weight * J;
    H.noalias() += wJ * J.transpose();
    b.noalias() += r * wJ;
    ++used;
  }
};

struct LevenbergMarquardtParams {
  int evaluations = 6;
  double width = 1.0, width_end = 1.0;  ///< of the robust kernel: it falls by ...
  double width_decay = 1.0;             ///< ... this factor per step, down to its end
  double gain_least = 0.0;              ///< ends where a step lowers the cost by less
};

/// The best state, and the equations at it.
template <class State>
struct Minimum {
  State state;
  NormalEquations equations;
};

/// @param evaluate  (state, index of the evaluation, width) -> NormalEquations there
/// @param advance   (state, xi) -> State
template <class State, class Evaluate, class Advance>
Minimum<State> minimise(const State& start, const LevenbergMarquardtParams& params,
                        Evaluate&& evaluate, Advance&& advance) {
  // The usual damping: little at first, less after a step that lowers the cost, ten times as much
  // after one that does not.
  constexpr double kLambda = 1e-3, kLambdaLeast = 1e-4, kLambdaMost = 1e3;
  constexpr double kBetter = 0.3, kWorse = 10.0;
  // Share of the damping that all directions get, of the mean curvature: a turn about a slender
  // part's axis is so weakly determined that undamped steps leap. The last one is for what nothing
  // determines.
  constexpr double kIsotropic = 0.02, kNothing = 1e-9;
  Minimum<State> best{start, {}};
  State next = start;
  double lambda = kLambda, width = params.width, last_width = 0.0;
  for (int k = 0; k < params.evaluations; ++k) {
    const NormalEquations here = evaluate(next, k, width);
    // Costs compare only at one width, so a new width starts a new comparison.
    const bool comparable = width == last_width;
    if (!comparable || here.cost <= best.equations.cost) {
      const double gain = best.equations.cost - here.cost;
      best = {next, here};
      lambda = std::max(kLambdaLeast, kBetter * lambda);
      if (comparable && gain < params.gain_least) break;
    } else {
      lambda = std::min(kLambdaMost, kWorse * lambda);
    }
    if (k + 1 == params.evaluations) break;
    const NormalEquations& at = best.equations;
    Matrix6d H = at.H;
    H.diagonal().array() +=
        lambda * at.H.diagonal().array() + lambda * kIsotropic * at.H.trace() / 6.0 + kNothing;
    next = advance(best.state, Vector6d(-H.ldlt().solve(at.b)));
    last_width = width;
    width = std::max(params.width_end, params.width_decay * width);
  }
  return best;
}

}  // namespace planar_bin_picking
