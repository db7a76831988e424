// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/score.h"

#include "outline_view.h"
#include "parallel.h"
#include "refine_image.h"

#include <cmath>

namespace planar_bin_picking {

std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads) {
  std::vector<std::vector<LocalPoint>> points;
  for (const auto& part : parts) {
    points.push_back(localPoints(*part, params.points,
                                 [](const OutlinePoint& p) { return p.kind != LoopKind::kPrint; }));
  }
  std::vector<ScoredPose> out(refined.size());
  parallelFor(static_cast<int>(refined.size()), threads, [&](int i) {
    const RefinedPose& r = refined[i];
    ScoredPose& s = out[i];
    static_cast<RefinedPose&>(s) = r;
    const auto& part = *parts[r.part];
    std::vector<EdgeHit> hits;
    findHits(edges, camera, points[r.part], part.radius(), r.T_camera_part * centreOf(part, r.face),
             {3, 3, 1.0}, &hits);
    double sum = 0.0;
    for (const auto& h : hits) {
      if (!h.found) continue;
      const double e = 1.0 - std::pow(h.offset_px / 3.0, 2);
      sum += std::max(0.0, e) * h.cosine;
    }
    s.score = sum / hits.size();
    s.visible_fraction = s.score;
  });
  return out;
}

}  // namespace planar_bin_picking
