// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/judge/score.h"

#include "locate/judge/probability.h"
#include "support/stages.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 600, 35, 6};

ScoredPose scored(const sim::Scene& scene, const std::shared_ptr<const PartModel>& part,
                  const Eigen::Isometry3d& T_camera_part) {
  const Shot shot = shoot(scene);
  return scorePoses(shot.edges, shot.camera, {part}, {refinedAt(T_camera_part)}, {}, 1).at(0);
}

TEST(Score, ATruePoseScoresHigh) {
  const auto part = makePart("bracket", bracketPlate());
  for (const bool front : {true, false}) {
    sim::Lie lie = kLie;
    lie.front = front;
    const auto pose = scored(sceneOf(bracketPlate(), lie), part, sim::poseOf(lie));
    EXPECT_GT(pose.evidence.edges, 0.85);
    EXPECT_LE(pose.evidence.edges, 1.0);
    EXPECT_GT(pose.visible_fraction, 0.97);
    EXPECT_LE(pose.visible_fraction, 1.0);
  }
}

TEST(Score, TheScoreIsTheMeanOfItsPoints) {
  const auto part = makePart("bracket", bracketPlate());
  const auto pose = scored(sceneOf(bracketPlate(), kLie), part, sim::poseOf(kLie));
  double sum = 0.0, weights = 0.0;
  for (const OutlineEvidence& point : pose.outline) {
    sum += point.weight * point.inlier;
    weights += point.weight;
    EXPECT_NEAR(point.normal.norm(), 1.0f, 1e-5f);
  }
  EXPECT_NEAR(sum / weights, pose.evidence.edges,
              0.02);  // less what edges inside the outline take away
  // The first point lies where the lens puts it, its normal out of the material.
  const OutlineEvidence& first = pose.outline.front();
  const Camera camera = makeCamera(kPinhole);
  double nearest = 1e9;
  Eigen::Vector2d inside(0.0, 0.0);
  for (const OutlinePoint& p : part->outline()) {
    const Eigen::Vector3d q =
        sim::poseOf(kLie) * Eigen::Vector3d(p.position.x(), p.position.y(), 0);
    const Eigen::Vector3d in =
        sim::poseOf(kLie) * Eigen::Vector3d(p.position.x() - 1e-3 * p.normal.x(),
                                            p.position.y() - 1e-3 * p.normal.y(), 0);
    const Eigen::Vector2d pixel = camera.distort(q.hnormalized());
    const double off = (pixel - first.pixel.cast<double>()).norm();
    if (off >= nearest) continue;
    nearest = off;
    inside = camera.distort(in.hnormalized()) - pixel;
  }
  EXPECT_LT(nearest, 1.0);
  EXPECT_LT(inside.normalized().dot(first.normal.cast<double>()), -0.9);
}

/// Beyond it a lens model says anything, a million pixels and no number.
TEST(Score, TheOutlineEndsWhereTheImageEnds) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Lie lie = kLie;
  lie.x_mm += 180.0;
  const auto pose = scored(sceneOf(bracketPlate(), lie), part, sim::poseOf(lie));
  const auto whole = scored(sceneOf(bracketPlate(), kLie), part, sim::poseOf(kLie));
  EXPECT_GT(pose.outline.size(), 0u);
  EXPECT_LT(pose.outline.size(), whole.outline.size());
  for (const OutlineEvidence& point : pose.outline) {
    EXPECT_GE(point.pixel.minCoeff(), 0.0f);
    EXPECT_LT(point.pixel.x(), kPinhole.width);
    EXPECT_LT(point.pixel.y(), kPinhole.height);
  }
}

TEST(Score, ItFallsAsThePoseMovesAway) {
  const auto part = makePart("bracket", bracketPlate());
  const sim::Scene scene = sceneOf(bracketPlate(), kLie);
  double last = 1.0;
  for (const double off_mm : {0.0, 0.3, 0.6, 2.0}) {
    const auto T = candidateNear(sim::poseOf(kLie), off_mm).T_camera_part;
    const double score = scored(scene, part, T).evidence.edges;
    EXPECT_LT(score, last) << off_mm;
    last = score;
  }
  EXPECT_LT(last, 0.5);
}

TEST(Score, NothingSpeaksForAnEmptyPlace) {
  const auto part = makePart("bracket", bracketPlate());
  const auto pose = scored(sim::Scene(), part, sim::poseOf(kLie));
  EXPECT_LT(pose.evidence.edges, 0.1);
  EXPECT_LT(pose.visible_fraction, 0.1);
}

TEST(Score, WhatIsCoveredIsNotVisible) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Scene scene = sceneOf(bracketPlate(), kLie);
  const double all = scored(scene, part, sim::poseOf(kLie)).visible_fraction;
  // A larger sheet over one end, darker.
  sim::Lie over = kLie;
  over.x_mm += 45;
  scene.plates.push_back({{rectangle(-30, -80, 30, 80), {}, {}, 0.0}, sim::poseOf(over), 100.0});
  const auto pose = scored(scene, part, sim::poseOf(kLie));
  EXPECT_LT(pose.visible_fraction, all - 0.15);
  EXPECT_GT(pose.visible_fraction, 0.3);
}

TEST(Score, AMissingHoleCostsMoreThanItsLength) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Plate solid = bracketPlate();
  solid.holes.clear();
  // Holes count as much as the outer contour, see score.h.
  EXPECT_LT(scored(sceneOf(solid, kLie), part, sim::poseOf(kLie)).evidence.edges, 0.6);
}

/// 600 mm off, 2.83 pixels to the millimetre.
TEST(Score, AHoleCountsByWhatThePictureResolvesOfIt) {
  const auto withoutHoles = [](double radius_mm) {
    sim::Plate plate = bracketPlate();
    plate.holes = {circle(-18, 6, radius_mm, true), circle(32, -19, radius_mm, true)};
    const auto part = makePart("bracket", plate);
    plate.holes.clear();
    return scored(sceneOf(plate, kLie), part, sim::poseOf(kLie)).evidence.edges;
  };
  EXPECT_GT(withoutHoles(0.5), 0.85);  // 2.8 pixels across: nothing can be seen of it
  EXPECT_GT(withoutHoles(1.0), 0.62);  // 5.7 pixels: 0.38 as much as one that is clearly seen
  EXPECT_LT(withoutHoles(1.0), 0.76);
  EXPECT_LT(withoutHoles(2.0), 0.53);  // 11.3 pixels
}

TEST(Score, AHoleThatIsElsewhereIsEvidenceAgainstAPose) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Plate other = bracketPlate();
  other.holes[0] = circle(-18, 6, 4.5, true);
  EXPECT_LT(scored(sceneOf(other, kLie), part, sim::poseOf(kLie)).evidence.edges, 0.4);
}

TEST(Score, AHoleOfWhatLiesOverThePartProvesNothing) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Scene scene = sceneOf(bracketPlate(), kLie);
  // Over the left half, with a smaller hole of its own within the drawn one.
  sim::Plate over{rectangle(-60, -60, -6, 60), {circle(-18, 6, 4.5, true)}, {}, 0.0};
  const double bare = [&] {
    sim::Scene plain = scene;
    sim::Plate without = over;
    without.holes.clear();
    plain.plates.push_back({without, sim::poseOf(kLie), 100.0});
    return scored(plain, part, sim::poseOf(kLie)).evidence.edges;
  }();
  scene.plates.push_back({over, sim::poseOf(kLie), 100.0});
  EXPECT_NEAR(scored(scene, part, sim::poseOf(kLie)).evidence.edges, bare, 0.05);
}

TEST(Score, AHoleTooManyCosts) {
  const auto part = makePart("bracket", bracketPlate());
  const double plain =
      scored(sceneOf(bracketPlate(), kLie), part, sim::poseOf(kLie)).evidence.edges;
  sim::Plate drilled = bracketPlate();
  drilled.holes.push_back(circle(-18, -18, 5, true));
  EXPECT_NEAR(scored(sceneOf(drilled, kLie), part, sim::poseOf(kLie)).evidence.edges, 0.9 * plain,
              0.02);
  // A label there is none: what it shows is not what is seen through the holes.
  sim::Scene labelled = sceneOf(bracketPlate(), kLie);
  labelled.plates.push_back({{circle(-18, -18, 5), {}, {}, 0.0}, sim::poseOf(kLie), 240.0});
  EXPECT_NEAR(scored(labelled, part, sim::poseOf(kLie)).evidence.edges, plain, 0.02);
}

TEST(Score, EdgesThatTheDrawingDoesNotHaveCost) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Scene scene = sceneOf(bracketPlate(), kLie);
  const double plain = scored(scene, part, sim::poseOf(kLie)).evidence.edges;
  // Specks all over the face, too small to count as something that covers it.
  sim::Scene speckled = scene;
  for (int x = -28; x < 44; x += 5)
    for (int y = -26; y < -10; y += 5)
      speckled.plates.push_back(
          {{rectangle(x, y, x + 1, y + 1), {}, {}, 0.0}, sim::poseOf(kLie), 80.0});
  const double cost = 1.0 - scored(speckled, part, sim::poseOf(kLie)).evidence.edges / plain;
  EXPECT_GT(cost, 0.04);
  EXPECT_LT(cost, 0.3);
}

TEST(Score, AsMuchOfThePrintAsIsInViewIsJudged) {
  const auto part = makePart("printed", printedPlate());
  sim::Scene scene = sceneOf(printedPlate(), kLie);
  const double all = scored(scene, part, sim::poseOf(kLie)).print;
  EXPECT_GT(all, 0.8);
  // Something lies over half of the print, which spans -10 to 20.
  scene.plates.push_back({{rectangle(5, -60, 60, 60), {}, {}, 0.0}, sim::poseOf(kLie), 100.0});
  EXPECT_GT(scored(scene, part, sim::poseOf(kLie)).print, all - 0.2);
  // Over nearly all of it.
  scene.plates.push_back({{rectangle(-9, -60, 60, 60), {}, {}, 0.0}, sim::poseOf(kLie), 100.0});
  EXPECT_EQ(scored(scene, part, sim::poseOf(kLie)).print, 0.0);
}

TEST(Score, TheEdgeOffsetIsFollowed) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Plate smaller = bracketPlate();  // as if its edges were bevelled by 0.4 mm
  smaller.outer = {{-32.6, -28.6}, {46.6, -28.6}, {46.6, -9.4},
                   {-3.4, -9.4},   {-3.4, 20.6},  {-32.6, 20.6}};
  smaller.holes = {circle(-18, 6, 6.4, true), circle(32, -19, 4.4, true)};
  const Shot shot = shoot(sceneOf(smaller, kLie));
  RefinedPose pose = refinedAt(sim::poseOf(kLie));
  const auto score = [&] {
    return scorePoses(shot.edges, shot.camera, {part}, {pose}, {}, 1).at(0).evidence.edges;
  };
  const double without = score();
  pose.edge_offset = 0.4e-3;
  EXPECT_GT(score(), without + 0.2);
}

/// Both rims of a narrow hole lie in one profile: what looks like it elsewhere proves nothing.
TEST(Score, ANarrowHoleElsewhereProvesNothing) {
  const auto with = [](double radius, double moved) {
    sim::Plate plate = bracketPlate();
    plate.holes[0] = circle(-18, 6 + moved, radius, true);
    return plate;
  };
  const auto score = [&](double radius, double moved) {
    return scored(sceneOf(with(radius, moved), kLie), makePart("drilled", with(radius, 0.0)),
                  sim::poseOf(kLie))
        .evidence.edges;
  };
  // 34 and 9 pixels across, 6 pixels off.
  EXPECT_LT(score(6.0, 2.0), 0.4 * score(6.0, 0.0));
  EXPECT_GT(score(1.6, 2.0), 0.5 * score(1.6, 0.0));
}

TEST(Score, ABevelledHoleIsNoOtherHole) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Plate smaller = bracketPlate();
  const double offset_mm = 0.9;  // 2.5 pixels: where the drawing has the rims nothing is seen
  smaller.outer = {{-33 + offset_mm, -29 + offset_mm}, {47 - offset_mm, -29 + offset_mm},
                   {47 - offset_mm, -9 - offset_mm},   {-3 - offset_mm, -9 - offset_mm},
                   {-3 - offset_mm, 21 - offset_mm},   {-33 + offset_mm, 21 - offset_mm}};
  smaller.holes = {circle(-18, 6, 6 + offset_mm, true), circle(32, -19, 4 + offset_mm, true)};
  const Shot shot = shoot(sceneOf(smaller, kLie));
  RefinedPose pose = refinedAt(sim::poseOf(kLie));
  pose.edge_offset = 1e-3 * offset_mm;
  EXPECT_GT(scorePoses(shot.edges, shot.camera, {part}, {pose}, {}, 1).at(0).evidence.edges, 0.8);
}

/// The part is there all the same.
TEST(Score, TheCovarianceSaysThatAPartMayLieTheOtherWay) {
  const auto part = makePart("bracket", bracketPlate());
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  RefinedPose sure = refinedAt(sim::poseOf(kLie)), open = sure;
  open.other_tilt << 0.0, 0.0, 0.002, 6.0 * M_PI / 180.0, 0.0, 0.0;
  const auto scored = scorePoses(shot.edges, shot.camera, {part, part}, {sure, open}, {}, 1);
  EXPECT_EQ(scored[1].score, scored[0].score);
  EXPECT_EQ(scored[1].evidence.edges, scored[0].evidence.edges);
  const Matrix6d more = open.other_tilt * open.other_tilt.transpose();
  EXPECT_TRUE((scored[1].covariance - scored[0].covariance).isApprox(more, 1e-9));
}

/// A printed plate of which one end is covered: its print is better confirmed than its contour.
TEST(Score, WhatAPrintMayAddIsLookedAtBeforeAPoseIsGivenUp) {
  const auto part = makePart("printed", printedPlate());
  sim::Scene scene = sceneOf(printedPlate(), kLie);
  sim::Lie over = kLie;
  over.x_mm -= 40;
  scene.plates.push_back({{rectangle(-25, -80, 25, 80), {}, {}, 0.0}, sim::poseOf(over), 100.0});
  const Shot shot = shoot(scene);
  const auto scoredFrom = [&](double threshold) {
    ScoreParams params;
    params.threshold = threshold;
    const std::vector<RefinedPose> poses{refinedAt(sim::poseOf(kLie))};
    return scorePoses(shot.edges, shot.camera, {part}, poses, params, 1).at(0);
  };
  const ScoredPose whole = scoredFrom(0.0);
  PoseEvidence contour = whole.evidence;
  double sum = 0.0, weights = 0.0;
  for (const OutlineEvidence& point : whole.outline) {
    sum += point.weight * point.inlier;
    weights += point.weight;
  }
  contour.edges = sum / weights;
  ASSERT_LT(probabilityRight(contour), whole.score - 0.01);
  const ScoredPose same = scoredFrom(whole.score - 0.001);
  EXPECT_EQ(same.score, whole.score);
  EXPECT_EQ(same.print, whole.print);
  EXPECT_EQ(same.covered, whole.covered);
}

/// ... and what cannot reach the threshold is not looked at any further.
TEST(Score, WhatLiesOverAHopelessPoseIsNotAsked) {
  const auto part = makePart("bracket", bracketPlate());
  const Shot shot = shoot(sceneOf(bracketPlate(), kLie));
  const auto visibleFrom = [&](double threshold) {
    ScoreParams params;
    params.threshold = threshold;
    const std::vector<RefinedPose> poses{refinedAt(sim::poseOf(kLie))};
    return scorePoses(shot.edges, shot.camera, {part}, poses, params, 1).at(0).visible_fraction;
  };
  EXPECT_GT(visibleFrom(0.9), 0.97);
  EXPECT_EQ(visibleFrom(1.0), 0.0);
}

}  // namespace
}  // namespace planar_bin_picking
