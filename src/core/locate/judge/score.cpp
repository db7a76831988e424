// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/score.h"

#include "base/parallel.h"
#include "base/polygon.h"
#include "image/profile.h"
#include "locate/evidence/hole_evidence.h"
#include "locate/evidence/inlier_score.h"
#include "locate/evidence/print_evidence.h"
#include "locate/judge/flat_face.h"
#include "locate/judge/occlusion.h"
#include "part/outline_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

/// Pixels: twice the reach of an inlier (score/reach_px), so that an edge just beyond is not taken
/// for a nearer one; and the sigma of a sharp edge.
constexpr SearchProfile kReach{3, true, 0.8};
constexpr int kHolePoints = 48;  // along one hole: 3 pixels apart on one of 50 pixels across

/// One hole, by itself.
struct Hole {
  int loop;
  double width;  // metres: of a round one the diameter, of a slot up to twice its width
  std::vector<LocalPoint> points;
};

/// The outline's points by kind, in order along the loops.
struct Groups {
  std::array<std::vector<LocalPoint>, 3> points;  // by LoopKind
  std::array<double, 3> length{};                 // metres
  std::vector<Hole> holes;
  std::vector<Eigen::Vector2d> middles;  // of the holes
};

/// Metres.
double widthOf(const Loop& loop) {
  return 4.0 * std::abs(signedArea(loop.points)) / lengthOf(loop);
}

Groups groupsOf(const PartModel& part, int count) {
  Groups out;
  for (const auto kind : {LoopKind::kOuter, LoopKind::kHole, LoopKind::kPrint}) {
    out.points[static_cast<int>(kind)] =
        localPoints(part, count, [kind](const OutlinePoint& p) { return p.kind == kind; });
  }
  const auto& loops = part.file().drawing.loops;
  for (int i = 0; i < static_cast<int>(loops.size()); ++i) {
    out.length[static_cast<int>(loops[i].kind)] += lengthOf(loops[i]);
    if (loops[i].kind != LoopKind::kHole) continue;
    const auto of_it = [i](const OutlinePoint& p) { return p.loop == i; };
    Eigen::AlignedBox2d box;
    for (const auto& p : loops[i].points) box.extend(p);
    out.middles.push_back(box.center());
    out.holes.push_back({i, widthOf(loops[i]), localPoints(part, kHolePoints, of_it)});
  }
  return out;
}

/// The pieces of the outline that the points stand for.
void addPieces(const PartModel& part, const std::vector<LocalPoint>& points, double length,
               const std::vector<EdgeHit>& hits, double reach_px,
               std::vector<OutlinePiece>* pieces) {
  constexpr double kSeen = 0.4;  // texture, noise and foreign edges mostly give less
  for (std::size_t i = 0; i < points.size(); ++i) {
    const OutlinePoint& p = part.outline()[points[i].index];
    pieces->push_back({p.position, p.normal, length / static_cast<double>(points.size()),
                       inlierScore(hits[i], reach_px) > kSeen, p.loop});
  }
}

/// How much a point of outer contour or hole counts, 0..1. The two rims of a narrow hole lie within
/// one edge filter and hide each other, so that whether they are found tells little.
double weightOf(const Groups& group, int loop, double px_per_metre) {
  constexpr double kNone = 3.0, kAll = 10.0;  // pixels: below the filter's width, beyond its reach
  const auto hole = std::find_if(group.holes.begin(), group.holes.end(),
                                 [loop](const Hole& h) { return h.loop == loop; });
  if (hole == group.holes.end()) return 1.0;
  return std::clamp((px_per_metre * hole->width - kNone) / (kAll - kNone), 0.0, 1.0);
}

/// What is in view of the print; nothing where that is too little to judge by.
std::vector<LocalPoint> uncovered(const PartModel& part, Face face, const Groups& group,
                                  const std::vector<int>& covered) {
  constexpr double kLeast = 0.25;  // of the print: chance confirms as much (print_evidence.h)
  const auto& print = group.points[static_cast<int>(LoopKind::kPrint)];
  std::vector<LocalPoint> out;
  if (face == Face::kBack) return out;
  for (const LocalPoint& p : print) {
    const int cell = part.faceGrid().cellNear(part.outline()[p.index].position);
    if (!std::binary_search(covered.begin(), covered.end(), cell)) out.push_back(p);
  }
  if (static_cast<double>(out.size()) < kLeast * static_cast<double>(print.size())) out.clear();
  return out;
}

/// Whether something lies over the hole, as the rest of the outline tells.
bool isCovered(const PartModel& part, int loop, const EdgeMap& edges, const Camera& camera,
               const RefinedPose& pose, const std::vector<OutlinePiece>& pieces) {
  constexpr double kMost = 0.3;  // share of the cells around it: less is chance or an edge near it
  std::vector<OutlinePiece> others;
  std::vector<int> around;
  const FaceGrid& grid = part.faceGrid();
  for (const OutlinePiece& piece : pieces) {
    if (piece.loop != loop) {
      others.push_back(piece);
      continue;
    }
    const int cell = grid.cellNear(piece.position - grid.cellSize() * piece.normal);
    if (cell >= 0) around.push_back(cell);
  }
  const auto covered =
      findOcclusion(grid, edges, camera, pose.T_camera_part, part.faceZ(pose.face), others);
  const auto over = std::count_if(around.begin(), around.end(), [&](int cell) {
    return std::binary_search(covered.begin(), covered.end(), cell);
  });
  return static_cast<double>(over) > kMost * static_cast<double>(around.size());
}

/// How sure it is that a hole is elsewhere or of another size. Then another part lies there,
/// however well the rest fits.
double provenWrong(const PartModel& part, const std::vector<Hole>& holes, const EdgeMap& edges,
                   const Camera& camera, const RefinedPose& pose,
                   const std::vector<OutlinePiece>& pieces) {
  // Lead of a hole elsewhere over the drawn one: half of its rim. In the benchmark's scenes plates
  // that differ by one hole in view have 0.58 and more, right poses at most 0.46.
  constexpr double kProof = 0.5;
  const Eigen::Isometry3d T = pose.T_camera_part * centreOf(part, pose.face);
  const double px_per_metre = camera.model().fx / T.translation().z();
  double proof = 0.0;
  for (const Hole& hole : holes) {
    auto points = hole.points;
    moveInward(pose.edge_offset / part.radius(), &points);
    const double width_px = px_per_metre * hole.width * std::abs(T.linear()(2, 2));
    const double lead =
        holeEvidence(edges, camera, points, solidOf(part, pose.face), T, width_px).lead;
    if (lead > std::max(kProof, proof) &&
        !isCovered(part, hole.loop, edges, camera, pose, pieces)) {
      proof = lead;
    }
  }
  return proof;
}

/// Factor of the score by which edges inside the outline that the drawing does not have lower it.
double extraHoleFactor(const PartModel& part, const Groups& group, const EdgeMap& edges,
                       const Camera& camera, const RefinedPose& pose,
                       const std::vector<int>& covered) {
  // Share of the score; no more, since in a stack the holes of the parts below may look like one
  // too many.
  constexpr double kExtraHole = 0.1;
  // Of their share of the face; no more, since a part may be dirty, textured or labelled.
  constexpr double kForeignEdges = 0.5;
  const FaceGrid& grid = part.faceGrid();
  const cv::Mat flat =
      flatten(grid, edges.image, camera, pose.T_camera_part, part.faceZ(pose.face));
  const double hole = hasExtraHole(grid, flat, covered, group.middles) ? kExtraHole : 0.0;
  return (1.0 - hole) * (1.0 - kForeignEdges * foreignEdges(grid, flat, covered));
}

}  // namespace

std::vector<ScoredPose> scorePoses(const EdgeMap& edges, const Camera& camera,
                                   const std::vector<std::shared_ptr<const PartModel>>& parts,
                                   const std::vector<RefinedPose>& refined,
                                   const ScoreParams& params, int threads) {
  std::vector<Groups> groups;
  for (const auto& part : parts) groups.push_back(groupsOf(*part, params.points));
  std::vector<ScoredPose> out(refined.size());
  parallelFor(static_cast<int>(refined.size()), threads, [&](int i) {
    const RefinedPose& r = refined[i];
    const auto& part = *parts[r.part];
    static_cast<RefinedPose&>(out[i]) = r;
    const Eigen::Isometry3d T = r.T_camera_part * centreOf(part, r.face);
    const Groups& group = groups[r.part];
    const double px_per_metre =
        camera.model().fx / T.translation().z() * std::abs(T.linear()(2, 2));
    double sum = 0.0, weights = 0.0;
    std::vector<OutlinePiece> pieces;
    for (const auto kind : {LoopKind::kOuter, LoopKind::kHole}) {
      auto points = group.points[static_cast<int>(kind)];
      if (points.empty()) continue;
      moveInward(r.edge_offset / part.radius(), &points);
      std::vector<EdgeHit> hits;
      findHits(edges, camera, points, solidOf(part, r.face), T, kReach, &hits);
      for (std::size_t k = 0; k < points.size(); ++k) {
        const double weight = weightOf(group, part.outline()[points[k].index].loop, px_per_metre) /
                              static_cast<double>(points.size());
        const double inlier = inlierScore(hits[k], params.reach_px);
        sum += weight * inlier;
        weights += weight;
        PosedPoint at;
        if (posePoint(camera, points[k], part.radius(), T, &at) &&
            fitsInside(edges.image, at.pixel, 0.0))
          out[i].outline.push_back({at.pixel.cast<float>(), at.normal.cast<float>(),
                                    static_cast<float>(inlier), static_cast<float>(weight)});
      }
      addPieces(part, points, group.length[static_cast<int>(kind)], hits, params.visible_reach_px,
                &pieces);
    }
    const FaceGrid& grid = part.faceGrid();
    out[i].covered =
        findOcclusion(grid, edges, camera, r.T_camera_part, part.faceZ(r.face), pieces);
    out[i].visible_fraction =
        1.0 - static_cast<double>(out[i].covered.size()) / static_cast<double>(grid.cells().size());
    const auto print = uncovered(part, r.face, group, out[i].covered);
    if (!print.empty()) {
      out[i].print = printScore(edges, camera, print, part.radius(), T);
      sum += out[i].print;
      weights += 1.0;
    }
    out[i].score = sum / weights;
    // Time: below the threshold a pose is not returned anyway.
    if (out[i].score < params.threshold) return;
    out[i].score *= 1.0 - provenWrong(part, group.holes, edges, camera, r, pieces);
    out[i].score *= extraHoleFactor(part, group, edges, camera, r, out[i].covered);
  });
  return out;
}

}  // namespace planar_bin_picking
