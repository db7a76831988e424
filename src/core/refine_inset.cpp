// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "refiner.h"

#include <cmath>

namespace planar_bin_picking {

void Refiner::estimateInset(const std::vector<Tracked>& poses, std::size_t part, Face face) {
  constexpr double kPrior = 0.15e-3, kSpread = 0.05e-3;
  FaceOutline& outline = outlines_[part].faces[static_cast<int>(face)];
  const double radius = outlines_[part].part->radius();
  double sum = 0.0, weight = 1.0 / (kPrior * kPrior);
  for (const auto& p : poses) {
    if (p.part != part || p.face != face || p.support < 0.7) continue;
    if (p.image.inset_information <= 0.0) continue;
    const double noise = radius * std::max(0.1, p.image.residual_px);
    const double variance = noise * noise / p.image.inset_information + kSpread * kSpread;
    sum += (outline.inset + radius * p.image.inset) / variance;
    weight += 1.0 / variance;
  }
  const double inset = sum / weight;
  for (auto* points : {&outline.coarse, &outline.wide, &outline.fine}) {
    moveInward((inset - outline.inset) / radius, points);
  }
  outline.inset = inset;
  outline.inset_sigma = std::sqrt(1.0 / weight);
}

void Refiner::estimateInsets(const std::vector<Tracked>& poses) {
  for (std::size_t part = 0; part < outlines_.size(); ++part) {
    for (const Face face : {Face::kFront, Face::kBack}) estimateInset(poses, part, face);
  }
}

}  // namespace planar_bin_picking
