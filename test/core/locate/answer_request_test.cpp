// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/answer_request.h"

#include "part/outline_view.h"
#include "planar_bin_picking/base/se3.h"
#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

/// An isosceles triangle, turned so that its mirror axis is none of x and y: the middle of its
/// bounding box lies off the axis.
sim::Plate leaningTriangle(double thickness_mm) {
  sim::Plate plate;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(-20, -25), {20, -25}, {0, 50}})
    plate.outer.push_back(Eigen::Rotation2Dd(20.0 * kDegrees) * p + Eigen::Vector2d(7, -3));
  plate.thickness_mm = thickness_mm;
  return plate;
}

const Parts kParts = {makePart("bracket", bracketPlate()), makePart("printed", printedPlate()),
                      makePart("triangle", leaningTriangle(6.0))};
constexpr std::size_t kBracket = 0, kPrinted = 1, kTriangle = 2;
constexpr double kTiltLimit = 40.0;

/// A detection that lies there, known to a tenth of a millimetre and a tenth of a degree.
Detection detectionAt(const sim::Lie& lie, std::size_t part = kBracket) {
  Detection d;
  static_cast<RefinedPose&>(d) = refinedAt(sim::poseOf(lie), part);
  d.covariance.diagonal() << 1e-8, 1e-8, 1e-8, 3e-6, 3e-6, 3e-6;
  d.score = 0.9;
  return d;
}

LocateRequest requestOf(FaceFilter face, double distance_min = 0.5, double distance_max = 0.7) {
  LocateRequest request;
  request.parts = kParts;
  request.face = face;
  request.distance_min = distance_min;
  request.distance_max = distance_max;
  return request;
}

LocateResult answer(const std::vector<Detection>& ranked, const LocateRequest& request) {
  LocateResult out;
  answerRequest(ranked, request, makeCamera(kPinhole), kTiltLimit, &out);
  return out;
}

TEST(AnswerRequest, TheOtherFaceIsWithheldWithAReason) {
  const Detection front = detectionAt({0, 0, 600}), back = detectionAt({0, 0, 600, 0, 0, 0, false});
  const auto fronts = answer({back, front}, requestOf(FaceFilter::kFront));
  ASSERT_EQ(fronts.detections.size(), 1u);
  EXPECT_EQ(fronts.detections[0].face, Face::kFront);
  ASSERT_EQ(fronts.withheld.size(), 1u);
  EXPECT_EQ(fronts.withheld[0].reason, Withheld::kWrongFace);
  EXPECT_EQ(fronts.withheld[0].detection.face, Face::kBack);
  EXPECT_EQ(fronts.withheld[0].text, "its back is up");

  const auto backs = answer({back, front}, requestOf(FaceFilter::kBack));
  ASSERT_EQ(backs.detections.size(), 1u);
  EXPECT_EQ(backs.detections[0].face, Face::kBack);
  ASSERT_EQ(backs.withheld.size(), 1u);
  EXPECT_EQ(backs.withheld[0].text, "its front is up");

  const auto any = answer({back, front}, requestOf(FaceFilter::kAny));
  EXPECT_EQ(any.detections.size(), 2u);
  EXPECT_TRUE(any.withheld.empty());
}

TEST(AnswerRequest, TheNumberIsCutAfterTheFace) {
  LocateRequest request = requestOf(FaceFilter::kFront);
  request.max_parts = 1;
  const auto out = answer({detectionAt({0, 0, 600, 0, 0, 0, false}), detectionAt({10, 0, 600}),
                           detectionAt({20, 0, 600}), detectionAt({30, 0, 900})},
                          request);
  ASSERT_EQ(out.detections.size(), 1u);
  EXPECT_NEAR(out.detections[0].T_camera_part.translation().x(), 0.010, 1e-9);
  // What is withheld is told in full, and what is cut off is neither.
  ASSERT_EQ(out.withheld.size(), 2u);
  EXPECT_EQ(out.withheld[0].reason, Withheld::kWrongFace);
  EXPECT_EQ(out.withheld[1].reason, Withheld::kOutside);
}

TEST(AnswerRequest, APrintTellsTheFacesOfASymmetricPartApart) {
  const auto out = answer({detectionAt({0, 0, 600}, kPrinted)}, requestOf(FaceFilter::kBack));
  EXPECT_TRUE(out.detections.empty());
  EXPECT_EQ(out.withheld.size(), 1u);
}

TEST(AnswerRequest, FacesThatNobodyCanTellApartAreAnsweredAsAsked) {
  for (const bool front : {true, false}) {
    const Detection found = detectionAt({10, -20, 600, 35, 15, 70, front}, kTriangle);
    const Face other = front ? Face::kBack : Face::kFront;
    EXPECT_EQ(answer({found}, requestOf(front ? FaceFilter::kFront : FaceFilter::kBack))
                  .detections.at(0)
                  .face,
              found.face);
    const auto out = answer({found}, requestOf(front ? FaceFilter::kBack : FaceFilter::kFront));
    ASSERT_EQ(out.detections.size(), 1u);
    EXPECT_TRUE(out.withheld.empty());
    const Detection& turned = out.detections[0];
    EXPECT_EQ(turned.face, other);
    EXPECT_EQ(faceOf(turned.T_camera_part), other);
    EXPECT_EQ(turned.score, found.score);
    // The visible outline lies where it lay.
    const PartModel& part = *kParts[kTriangle];
    for (const Eigen::Vector2d& p : part.file().drawing.loops.front().points) {
      const Eigen::Vector3d seen =
          turned.T_camera_part * Eigen::Vector3d(p.x(), p.y(), part.faceZ(other));
      double nearest = 1.0;
      for (const Eigen::Vector2d& q : part.file().drawing.loops.front().points) {
        const Eigen::Vector3d before =
            found.T_camera_part * Eigen::Vector3d(q.x(), q.y(), part.faceZ(found.face));
        nearest = std::min(nearest, (seen - before).norm());
      }
      EXPECT_LT(nearest, 1e-9);
    }
  }
}

TEST(AnswerRequest, ATurnedPoseHasTheCovarianceOfItsNewCentre) {
  Detection found = detectionAt({10, -20, 600, 35, 15, 70}, kTriangle);
  Matrix6d root = Matrix6d::Identity();
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) root(i, j) += 0.1 * std::sin(1.0 + 3.0 * i + j);
  }
  found.covariance = 1e-6 * root * root.transpose();
  const PartModel& part = *kParts[kTriangle];
  const Detection turned = turnedOver(found, part);
  const Eigen::Isometry3d T_found = found.T_camera_part * centreOf(part, found.face);
  const Eigen::Isometry3d T_turned = turned.T_camera_part * centreOf(part, turned.face);
  const Eigen::Isometry3d T_found_turned = T_found.inverse() * T_turned;
  const auto inTurned = [&](const Vector6d& xi) -> Vector6d {
    return log(T_turned.inverse() * (T_found * exp(xi) * T_found_turned));
  };
  const Matrix6d J = numericJacobian(inTurned, Vector6d(Vector6d::Zero()), 1e-5);
  const Matrix6d expected = J * found.covariance * J.transpose();
  EXPECT_LT((turned.covariance - expected).norm(), 1e-6 * expected.norm());
}

TEST(AnswerRequest, ATurnedPoseIsCoveredWhereItWas) {
  Detection found = detectionAt({0, 0, 600}, kTriangle);
  const PartModel& part = *kParts[kTriangle];
  const auto& cells = part.faceGrid().cells();
  // All that the camera sees in the image's left half is covered.
  const auto isLeft = [&](const Detection& d, const Eigen::Vector2d& p) {
    return (d.T_camera_part * Eigen::Vector3d(p.x(), p.y(), part.faceZ(d.face))).x() < 0.0;
  };
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (isLeft(found, cells[i])) found.covered.push_back(static_cast<int>(i));
  const Detection turned = turnedOver(found, part);
  std::size_t right = 0;
  for (const int i : turned.covered) right += isLeft(turned, cells[i]) ? 0 : 1;
  EXPECT_GT(found.covered.size(), 50u);
  EXPECT_LT(found.covered.size(), cells.size() - 50u);
  // Cells are squares of the part's frame: those along the border may differ.
  EXPECT_NEAR(static_cast<double>(turned.covered.size()), found.covered.size(), 50.0);
  EXPECT_LT(right, 40u);
}

TEST(AnswerRequest, PartsOutsideOfTheDistancesAreWithheld) {
  // The origin of the bracket lies off its middle; the middle of the visible face counts.
  const auto out = answer({detectionAt({0, 0, 498.5}), detectionAt({0, 0, 701.5}),
                           detectionAt({0, 0, 497.5}), detectionAt({0, 0, 702.5})},
                          requestOf(FaceFilter::kAny));
  EXPECT_EQ(out.detections.size(), 2u);
  ASSERT_EQ(out.withheld.size(), 2u);
  EXPECT_EQ(out.withheld[0].reason, Withheld::kOutside);
  EXPECT_NEAR(out.withheld[0].detection.T_camera_part.translation().z(), 0.4975, 1e-9);
  for (const std::string word : {"0.4975 m", "0.5 .. 0.7 m", "2 mm"})
    EXPECT_NE(out.withheld[0].text.find(word), std::string::npos) << out.withheld[0].text;
}

TEST(AnswerRequest, TheMiddleOfTheVisibleFaceCountsForTheDistance) {
  const PartModel& part = *kParts[kBracket];
  Detection d = detectionAt({0, 0, 600, 0, 30, 90});
  const double depth = (d.T_camera_part * centreOf(part, d.face)).translation().z();
  ASSERT_GT(std::abs(depth - 0.6), 0.003);
  const double near = depth - 0.0005, far = depth + 0.0005;
  EXPECT_EQ(answer({d}, requestOf(FaceFilter::kAny, near, far)).detections.size(), 1u);
  EXPECT_EQ(answer({d}, requestOf(FaceFilter::kAny, 0.5995, 0.6005)).detections.size(), 0u);
}

TEST(AnswerRequest, TheMarginFollowsTheDepthsDeviation) {
  // The part's x leans toward the camera, so that its deviation is partly one of depth.
  Detection d = detectionAt({0, 0, 600, 0, 30, 90});
  d.covariance.setZero();
  EXPECT_NEAR(distanceMargin(d, 0.6), 0.002, 1e-12);  // at least
  d.covariance(2, 2) = 1e-6;
  EXPECT_NEAR(distanceMargin(d, 0.6), 3e-3 * std::cos(30.0 * kDegrees), 1e-9);
  d.covariance(2, 2) = 0.0;
  d.covariance(0, 0) = d.covariance(1, 1) = 4e-6;
  EXPECT_NEAR(distanceMargin(d, 0.6), 6e-3 * std::sin(30.0 * kDegrees), 1e-9);
  d.covariance(2, 2) = 1.0;
  EXPECT_NEAR(distanceMargin(d, 0.6), 0.012, 1e-12);  // at most 2 %
  EXPECT_NEAR(distanceMargin(d, 0.05), 0.002, 1e-12);
}

TEST(AnswerRequest, TooSteepPosesAreInNeitherList) {
  const auto tilted = [](double deg, double sigma_deg) {
    Detection d = detectionAt({0, 0, 600, 25, deg, 70});
    d.covariance(3, 3) = d.covariance(4, 4) = std::pow(sigma_deg * kDegrees, 2);
    return d;
  };
  const auto answered = [&](const Detection& d) {
    const auto out = answer({d}, requestOf(FaceFilter::kAny));
    EXPECT_TRUE(out.withheld.empty());
    return out.detections.size() == 1;
  };
  EXPECT_TRUE(answered(tilted(39.9, 0.0)));
  EXPECT_FALSE(answered(tilted(40.1, 0.0)));
  EXPECT_TRUE(answered(tilted(40.8, 0.3)));
  EXPECT_FALSE(answered(tilted(41.0, 0.3)));
  EXPECT_TRUE(answered(tilted(41.9, 10.0)));
  EXPECT_FALSE(answered(tilted(42.1, 10.0)));
  // A turn about the part's normal tells nothing of its tilt.
  Detection turning = tilted(40.1, 0.0);
  turning.covariance(5, 5) = 1.0;
  EXPECT_FALSE(answered(turning));
}

TEST(AnswerRequest, OnlyTheDeviationTowardTheLimitCounts) {
  // Tilted about the part's x: turns about its y leave the tilt alone.
  Detection d = detectionAt({0, 0, 600, 0, 41.0, 0});
  d.covariance.setZero();
  d.covariance(4, 4) = 1.0;
  EXPECT_TRUE(answer({d}, requestOf(FaceFilter::kAny)).detections.empty());
  d.covariance(3, 3) = 1.0;
  EXPECT_EQ(answer({d}, requestOf(FaceFilter::kAny)).detections.size(), 1u);
}

TEST(AnswerRequest, PosesOfTooFewPixelsAreWithheld) {
  // The printed plate is 60 mm square: 56 pixels of 1697 per metre at 1.82 m.
  const auto out =
      answer({detectionAt({0, 0, 1810}, kPrinted), detectionAt({0, 0, 1830}, kPrinted)},
             requestOf(FaceFilter::kAny, 0.5, 2.0));
  ASSERT_EQ(out.detections.size(), 1u);
  EXPECT_NEAR(out.detections[0].T_camera_part.translation().z(), 1.81, 1e-9);
  ASSERT_EQ(out.withheld.size(), 1u);
  EXPECT_EQ(out.withheld[0].reason, Withheld::kOutside);
  EXPECT_NE(out.withheld[0].text.find("pixels"), std::string::npos);
}

}  // namespace
}  // namespace planar_bin_picking
