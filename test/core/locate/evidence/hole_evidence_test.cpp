// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/evidence/hole_evidence.h"

#include "support/stages.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace planar_bin_picking {
namespace {

const sim::Lie kLie{20, -10, 600, 35, 6};
constexpr double kWidthPx = 30.0;
const Eigen::Vector2d kMiddle(-18, 6);  // of the drawn hole, mm
constexpr double kRadius = 6.0;

sim::Plate withHole(const Eigen::Vector2d& middle, double radius = kRadius) {
  return {bracketPlate().outer,
          {circle(middle.x(), middle.y(), radius, true), bracketPlate().holes[1]},
          {},
          0.0};
}

cv::Mat pictureOf(const sim::Plate& plate, const sim::Lie& lie = kLie) {
  return sim::takeImage(kPinhole, sceneOf(plate, lie));
}

/// The drawing has the bracket's hole; the picture may show another one.
HoleEvidence seen(const cv::Mat& image, double width_px = kWidthPx, double thickness_mm = 0.0,
                  const sim::Lie& lie = kLie) {
  auto plate = bracketPlate();
  plate.thickness_mm = thickness_mm;
  const auto part = makePart("bracket", plate);
  const Camera camera = makeCamera(kPinhole);
  const EdgeMap edges = findEdges(image, camera, {}, 1);
  const auto points = localPoints(*part, 48, [](const OutlinePoint& p) { return p.loop == 1; });
  return holeEvidence(edges, camera, points, solidOf(*part, Face::kFront),
                      sim::poseOf(lie) * centreOf(*part, Face::kFront), width_px);
}

TEST(HoleEvidence, AHoleInItsPlaceIsSeenThere) {
  const auto evidence = seen(pictureOf(bracketPlate()));
  EXPECT_GT(evidence.here, 0.9);
  EXPECT_EQ(evidence.lead, 0.0);
}

TEST(HoleEvidence, AHoleOfAnotherSizeIsSeenAsThat) {
  for (const double radius_mm : {4.5, 7.5}) {
    const auto evidence = seen(pictureOf(withHole(kMiddle, radius_mm)));
    EXPECT_LT(evidence.here, 0.3) << radius_mm;
    EXPECT_GT(evidence.lead, 0.8) << radius_mm;
  }
}

TEST(HoleEvidence, AMovedHoleIsFoundInAnyDirection) {
  for (int k = 0; k < 6; ++k) {
    const double angle = 60.0 * kDegrees * k;
    const auto evidence = seen(
        pictureOf(withHole(kMiddle + 3.5 * Eigen::Vector2d(std::cos(angle), std::sin(angle)))));
    EXPECT_LT(evidence.here, 0.4) << k;
    EXPECT_GT(evidence.lead, 0.6) << k;
  }
}

/// A hole that is wider than the drawn one, and in it, along two thirds of that, what lies below.
cv::Mat pictureWithADisc(int brighter) {
  constexpr int kFractionBits = 6;
  cv::Mat image = pictureOf(withHole(kMiddle, 9.0));
  const Camera camera = makeCamera(kPinhole);
  const auto seenAt = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    const Eigen::Vector3d q = sim::poseOf(kLie) * Eigen::Vector3d(1e-3 * p.x(), 1e-3 * p.y(), 0.0);
    return camera.distort(q.hnormalized());
  };
  std::vector<cv::Point> rim;
  for (const auto& p : circle(kMiddle.x(), kMiddle.y(), kRadius)) {
    const Eigen::Vector2d pixel = (1 << kFractionBits) * seenAt(p);
    rim.emplace_back(cvRound(pixel.x()), cvRound(pixel.y()));
  }
  rim.resize(rim.size() * 2 / 3);
  const Eigen::Vector2d middle = seenAt(kMiddle);
  const int level = image.at<std::uint8_t>(cvRound(middle.y()), cvRound(middle.x()));
  cv::fillPoly(image, std::vector<std::vector<cv::Point>>{rim}, cv::Scalar(level + brighter),
               cv::LINE_AA, kFractionBits);
  return image;
}

// Seen in a bin: a shadow in a hole of 14 mm lay where one of 11 mm is drawn.
TEST(HoleEvidence, AFaintEdgeInAWiderHoleIsNotItsRim) {
  const auto evidence = seen(pictureWithADisc(25));
  EXPECT_GT(evidence.here, 0.5);
  EXPECT_GT(evidence.lead, 0.5);
}

TEST(HoleEvidence, AnEdgeAsHighAsTheOtherLeavesItOpen) {
  EXPECT_LT(seen(pictureWithADisc(100)).lead, 0.4);
}

TEST(HoleEvidence, WithoutAHoleNothingIsSeenElsewhere) {
  sim::Plate plate = bracketPlate();
  plate.holes.erase(plate.holes.begin());
  const auto evidence = seen(pictureOf(plate));
  EXPECT_LT(evidence.here, 0.1);
  EXPECT_LT(evidence.lead, 0.3);
}

TEST(HoleEvidence, OfAHoleTooSmallNothingElseIsSought) {
  EXPECT_EQ(seen(pictureOf(withHole(kMiddle, 4.5)), 8.0).lead, 0.0);
}

/// Where the upper rim cannot be told from the wall, the lower one is what is seen.
TEST(HoleEvidence, TheLowerRimOfAThickPartIsNoOtherHole) {
  const sim::Lie lie{20, -10, 600, 35, 30};
  constexpr double kThickness = 8.0;
  const Eigen::Vector3d camera = 1e3 * sim::poseOf(lie).inverse().translation();
  // From the camera through the lower rim's middle to the plane of the upper one.
  const Eigen::Vector3d lower(kMiddle.x(), kMiddle.y(), -kThickness);
  const Eigen::Vector3d at = camera + camera.z() / (camera.z() + kThickness) * (lower - camera);
  ASSERT_GT((at.head<2>() - kMiddle).norm(), 3.0);
  const cv::Mat image = pictureOf(withHole(at.head<2>()), lie);
  EXPECT_GT(seen(image, kWidthPx, 0.0, lie).lead, 0.5);
  EXPECT_LT(seen(image, kWidthPx, kThickness, lie).lead, 0.3);
  // As far to the other side it is another hole.
  const cv::Mat other = pictureOf(withHole(2.0 * kMiddle - at.head<2>()), lie);
  EXPECT_GT(seen(other, kWidthPx, kThickness, lie).lead, 0.5);
}

}  // namespace
}  // namespace planar_bin_picking
