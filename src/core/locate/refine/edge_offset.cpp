// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "base/scatter.h"
#include "locate/refine/refiner.h"

#include <cmath>
#include <vector>

namespace planar_bin_picking {

namespace {

struct Inset {
  double value, variance;
};

/// Variance of the true insets: what the measured ones scatter beyond their errors.
double spreadOf(const std::vector<Inset>& measured) {
  constexpr double kUnknown = 0.05e-3, kLeast = 0.02e-3;
  constexpr std::size_t kFew = 4;
  if (measured.size() < kFew) return kUnknown * kUnknown;
  std::vector<double> values, squares, variances;
  for (const auto& m : measured) values.push_back(m.value);
  const double middle = median(values);
  for (const auto& m : measured) {
    squares.push_back((m.value - middle) * (m.value - middle));
    variances.push_back(m.variance);
  }
  return scatterBeyond(squares, kVarianceOfOne, variances, kLeast);
}

}  // namespace

void Refiner::estimateInset(const std::vector<Tracked>& poses, std::size_t part, Face face) {
  constexpr double kPrior = 0.15e-3, kWellSupported = 0.7;
  FaceOutline& outline = outlines_[part].faces[static_cast<int>(face)];
  const double radius = outlines_[part].part->radius();
  std::vector<Inset> measured;
  for (const auto& p : poses) {
    if (p.part != part || p.face != face || p.support < kWellSupported) continue;
    if (!std::isfinite(p.image.inset_sigma)) continue;
    measured.push_back(
        {outline.inset + radius * p.image.inset, std::pow(radius * p.image.inset_sigma, 2)});
  }
  const double spread = spreadOf(measured);
  double sum = 0.0, weight = 1.0 / (kPrior * kPrior);
  for (const auto& m : measured) {
    sum += m.value / (m.variance + spread);
    weight += 1.0 / (m.variance + spread);
  }
  const double inset = sum / weight;
  for (auto* points : {&outline.coarse, &outline.wide, &outline.fine}) {
    moveInward((inset - outline.inset) / radius, points);
  }
  outline.inset = inset;
  outline.inset_sigma = std::sqrt(1.0 / weight);
  outline.inset_spread = std::sqrt(spread);
}

void Refiner::estimateInsets(const std::vector<Tracked>& poses) {
  for (std::size_t part = 0; part < outlines_.size(); ++part) {
    for (const Face face : {Face::kFront, Face::kBack}) estimateInset(poses, part, face);
  }
}

}  // namespace planar_bin_picking
