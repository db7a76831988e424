// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Normal equations from Jacobians that lie by columns, several rows at a time.

#include "base/simd.h"
#include "locate/align/levenberg_marquardt.h"

#include <array>

namespace planar_bin_picking {

/// Columns of six unknowns, each as long as the others, a multiple of kDoublesOfVector.
using Columns = std::array<const double*, 6>;

/// Products of three columns with three others or themselves, at a time: as many sums as registers
/// hold, so that each number is read a third as often as column by column.
template <int kI, int kJ>
static PBP_INLINE void addProducts(const Columns& weighted, const Columns& J,
                                   const double* residual, int n, NormalEquations* out) {
  const double *const u0 = weighted[kI], *const u1 = weighted[kI + 1], *const u2 = weighted[kI + 2];
  const double *const v0 = J[kJ], *const v1 = J[kJ + 1], *const v2 = J[kJ + 2];
  DoubleVector s00 = {}, s10 = {}, s11 = {}, s20 = {}, s21 = {}, s22 = {};
  DoubleVector t0 = {}, t1 = {}, t2 = {};  // above the diagonal, or with the residuals
  for (int k = 0; k < n; k += kDoublesOfVector) {
    DoubleVector a0, a1, a2, b0, b1, b2;
    load(u0 + k, &a0);
    load(u1 + k, &a1);
    load(u2 + k, &a2);
    load(v0 + k, &b0);
    load(v1 + k, &b1);
    load(v2 + k, &b2);
    s00 += a0 * b0;
    s10 += a1 * b0;
    s11 += a1 * b1;
    s20 += a2 * b0;
    s21 += a2 * b1;
    s22 += a2 * b2;
    if (kI == kJ) {
      DoubleVector r;
      load(residual + k, &r);
      t0 += a0 * r;
      t1 += a1 * r;
      t2 += a2 * r;
    } else {
      t0 += a0 * b1;
      t1 += a0 * b2;
      t2 += a1 * b2;
    }
  }
  out->H(kI, kJ) += sumOf(s00);
  out->H(kI + 1, kJ) += sumOf(s10);
  out->H(kI + 1, kJ + 1) += sumOf(s11);
  out->H(kI + 2, kJ) += sumOf(s20);
  out->H(kI + 2, kJ + 1) += sumOf(s21);
  out->H(kI + 2, kJ + 2) += sumOf(s22);
  (kI == kJ ? out->b(kI) : out->H(kI, kJ + 1)) += sumOf(t0);
  (kI == kJ ? out->b(kI + 1) : out->H(kI, kJ + 2)) += sumOf(t1);
  (kI == kJ ? out->b(kI + 2) : out->H(kI + 1, kJ + 2)) += sumOf(t2);
}

/// Adds n rows to b and to the lower triangle of H.
static PBP_INLINE void addColumns(const Columns& weighted, const Columns& J, const double* residual,
                                  int n, NormalEquations* out) {
  addProducts<0, 0>(weighted, J, residual, n, out);
  addProducts<3, 0>(weighted, J, residual, n, out);
  addProducts<3, 3>(weighted, J, residual, n, out);
}

}  // namespace planar_bin_picking
