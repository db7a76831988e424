// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/score.h"

#include "base/parallel.h"
#include "base/polygon.h"
#include "image/profile.h"
#include "locate/evidence/corner_evidence.h"
#include "locate/evidence/hole_evidence.h"
#include "locate/evidence/inlier_score.h"
#include "locate/evidence/print_evidence.h"
#include "locate/judge/flat_face.h"
#include "locate/judge/occlusion.h"
#include "locate/judge/probability.h"
#include "part/outline_view.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace planar_bin_picking {
namespace {

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
  std::vector<SideEnd> ends;
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
  out.ends = sideEndsOf(part);
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
bool isCovered(const FaceGrid& grid, int loop, const FlatFace& flat,
               const std::vector<OutlinePiece>& pieces) {
  constexpr double kMost = 0.3;  // share of the cells around it: less is chance or an edge near it
  std::vector<OutlinePiece> others;
  std::vector<int> around;
  for (const OutlinePiece& piece : pieces) {
    if (piece.loop != loop) {
      others.push_back(piece);
      continue;
    }
    const int cell = grid.cellNear(piece.position - grid.cellSize() * piece.normal);
    if (cell >= 0) around.push_back(cell);
  }
  const auto covered = findOcclusion(grid, flat, others);
  const auto over = std::count_if(around.begin(), around.end(), [&](int cell) {
    return std::binary_search(covered.begin(), covered.end(), cell);
  });
  return static_cast<double>(over) > kMost * static_cast<double>(around.size());
}

/// How sure it is that a hole is elsewhere or of another size. Then another part lies there,
/// however well the rest fits.
double provenWrong(const PartModel& part, const std::vector<Hole>& holes, const EdgeMap& edges,
                   const Camera& camera, const RefinedPose& pose, const FlatFace& flat,
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
    if (lead > std::max(kProof, proof) && !isCovered(part.faceGrid(), hole.loop, flat, pieces)) {
      proof = lead;
    }
  }
  return proof;
}

/// Factor of the score by which edges inside the outline that the drawing does not have lower it.
double extraHoleFactor(const FaceGrid& grid, const FlatFace& flat, const Groups& group,
                       const std::vector<int>& covered) {
  // Share of the score; no more, since in a stack the holes of the parts below may look like one
  // too many.
  constexpr double kExtraHole = 0.1;
  // Of their share of the face; no more, since a part may be dirty, textured or labelled.
  constexpr double kForeignEdges = 0.5;
  const double hole = hasExtraHole(grid, flat, covered, group.middles) ? kExtraHole : 0.0;
  return (1.0 - hole) * (1.0 - kForeignEdges * foreignEdges(grid, flat, covered));
}

/// What outer contour and holes say.
struct ContourEvidence {
  double sum = 0.0, weights = 0.0;            // of inlier scores
  double hole_sum = 0.0, hole_weights = 0.0;  // of those on holes
  std::vector<OutlinePiece> pieces;
  std::vector<OutlineEvidence> outline;  // in the image
};

ContourEvidence contourEvidence(const EdgeMap& edges, const Camera& camera, const PartModel& part,
                                const Groups& group, const PosedPart& posed,
                                const ScoreParams& params) {
  ContourEvidence out;
  for (const auto kind : {LoopKind::kOuter, LoopKind::kHole}) {
    auto points = group.points[static_cast<int>(kind)];
    if (points.empty()) continue;
    moveInward(posed.edge_offset, &points);
    std::vector<EdgeHit> hits;
    findHits(edges, camera, points, posed.solid, posed.T_camera_centre, kInlierProfile, &hits);
    const auto seen = posePoints(camera, points, part.radius(), posed.T_camera_centre);
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double weight = weightOf(group, part.outline()[points[k].index].loop,
                                     posed.px_per_radius / part.radius()) /
                            static_cast<double>(points.size());
      const double inlier = inlierScore(hits[k], params.reach_px);
      out.sum += weight * inlier;
      out.weights += weight;
      if (kind == LoopKind::kHole) {
        out.hole_sum += weight * inlier;
        out.hole_weights += weight;
      }
      PosedPoint at;
      if (pointAt(seen, k, &at) && fitsInside(edges.image, at.pixel, 0.0))
        out.outline.push_back({at.pixel.cast<float>(), at.normal.cast<float>(),
                               static_cast<float>(inlier), static_cast<float>(weight)});
    }
    addPieces(part, points, group.length[static_cast<int>(kind)], hits, params.visible_reach_px,
              &out.pieces);
  }
  return out;
}

ScoredPose scorePose(const EdgeMap& edges, const Camera& camera, const PartModel& part,
                     const Groups& group, const RefinedPose& pose, const ScoreParams& params) {
  constexpr double kResolved = 0.02;  // weight of the holes, 1 if the picture resolves all
  ScoredPose out;
  static_cast<RefinedPose&>(out) = pose;
  const Eigen::Isometry3d T = pose.T_camera_part * centreOf(part, pose.face);
  const double px_per_radius =
      part.radius() * camera.model().fx / T.translation().z() * std::abs(T.linear()(2, 2));
  const PosedPart posed{solidOf(part, pose.face), T, pose.edge_offset / part.radius(),
                        px_per_radius};
  ContourEvidence contour = contourEvidence(edges, camera, part, group, posed, params);
  out.outline = std::move(contour.outline);
  PoseEvidence& evidence = out.evidence;
  const bool may_show_print =
      pose.face == Face::kFront && !group.points[static_cast<int>(LoopKind::kPrint)].empty();
  if (contour.hole_weights > kResolved) evidence.holes = contour.hole_sum / contour.hole_weights;
  evidence.slide_radii = sigmaInPlane(pose) / part.radius();
  evidence.slide_px = px_per_radius * evidence.slide_radii;
  out.covariance += pose.other_tilt * pose.other_tilt.transpose();
  // Time: the cheapest first, and below the threshold a pose is not returned anyway. What follows
  // only lowers its probability; until the print is looked at, all of it may be seen.
  evidence.edges = may_show_print ? (contour.sum + 1.0) / (contour.weights + 1.0)
                                  : contour.sum / contour.weights;
  out.score = probabilityRight(evidence);
  if (out.score < params.threshold) return out;
  evidence.beyond_corners = edgesBeyondCorners(edges, camera, group.ends, posed, params.reach_px);
  out.score = probabilityRight(evidence);
  if (out.score < params.threshold) return out;
  const FaceGrid& grid = part.faceGrid();
  const FlatFace flat =
      flatten(grid, edges.image, camera, pose.T_camera_part, part.faceZ(pose.face));
  out.covered = findOcclusion(grid, flat, contour.pieces);
  out.visible_fraction =
      1.0 - static_cast<double>(out.covered.size()) / static_cast<double>(grid.cells().size());
  const auto print = uncovered(part, pose.face, group, out.covered);
  if (!print.empty()) {
    out.print = printScore(edges, camera, print, part.radius(), T);
    contour.sum += out.print;
    contour.weights += 1.0;
  }
  evidence.edges = contour.sum / contour.weights;
  out.score = probabilityRight(evidence);
  if (out.score < params.threshold) return out;
  evidence.edges *= 1.0 - provenWrong(part, group.holes, edges, camera, pose, flat, contour.pieces);
  evidence.edges *= extraHoleFactor(grid, flat, group, out.covered);
  out.score = probabilityRight(evidence);
  return out;
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
    const std::size_t k = refined[i].part;
    out[i] = scorePose(edges, camera, *parts[k], groups[k], refined[i], params);
  });
  return out;
}

}  // namespace planar_bin_picking
