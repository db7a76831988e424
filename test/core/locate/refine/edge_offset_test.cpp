// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/refine/edge_offset.h"

#include "support/matchers.h"
#include "support/plates.h"

#include <gtest/gtest.h>

namespace planar_bin_picking {
namespace {

/// What edge_offset.cpp knows beforehand, metres: of the mean, of the copies while they are few,
/// and what the spread of many is at least.
constexpr double kMean = 0.05e-3, kMeanSigma = 0.1e-3, kSpreadUnknown = 0.05e-3,
                 kSpreadLeast = 0.02e-3;
constexpr double kFocal = 1000.0, kExact = 1e-9;

class EdgeOffset : public testing::Test {
 protected:
  EdgeOffset() {
    outlines_.resize(2);
    for (auto& outline : outlines_) {
      outline.part = part_.get();
      for (auto& face : outline.faces) {
        face.coarse = {{1.0, 0.0, 0.0, 1.0, 0}};  // its outward normal is +x
        face.wide = {{0.0, 1.0, -1.0, 0.0, 1}};   // +y
        face.fine = {{-1.0, 0.0, 0.0, -1.0, 2}};  // -x
      }
    }
  }
  double radius() const { return part_->radius(); }
  /// Aligned, its edges `offset_mm` inside where the outline is taken to be.
  PoseHypothesis seenWith(double offset_mm, double sigma_mm) const {
    PoseHypothesis pose;
    pose.T_camera_part = sim::poseOf({10, 20, 600, 30, 5});
    pose.inlier_score = 0.9;
    pose.image.status = AlignmentStatus::kAligned;
    pose.image.T_camera_centre = pose.T_camera_part * centreOf(*part_, pose.face);
    pose.image.offset = 1e-3 * offset_mm / radius();
    pose.image.offset_sigma = 1e-3 * sigma_mm / radius();
    pose.image.covariance = 1e-8 * Matrix6d::Identity();
    return pose;
  }
  void estimate(const std::vector<PoseHypothesis>& poses) {
    estimateEdgeOffsets(poses, &outlines_);
  }
  const FaceOutline& front() const { return outlines_[0].of(Face::kFront); }

  std::shared_ptr<const PartModel> part_ = makePart("bracket", bracketPlate());
  std::vector<PartOutline> outlines_;
};

TEST_F(EdgeOffset, WithoutCopiesThePriorIsLeft) {
  estimate({});
  EXPECT_NEAR(front().offset, kMean, kExact);
  EXPECT_NEAR(front().offset_sigma, kMeanSigma, kExact);
  EXPECT_NEAR(front().offset_spread, kSpreadUnknown, kExact);
  EXPECT_NEAR(front().fine[0].x, -1.0 + kMean / radius(), kExact);
}

TEST_F(EdgeOffset, OneCopyCountsByItsErrorAndTheSpreadAgainstThePrior) {
  estimate({seenWith(0.2, 0.05)});
  const double own = 0.05 * 0.05 + 0.05 * 0.05, prior = 0.1 * 0.1;
  EXPECT_NEAR(1e3 * front().offset, (0.2 * prior + 0.05 * own) / (prior + own), 1e-9);
  EXPECT_NEAR(1e3 * front().offset_sigma, std::sqrt(prior * own / (prior + own)), 1e-9);
  EXPECT_NEAR(front().offset_spread, kSpreadUnknown, kExact);
}

TEST_F(EdgeOffset, ThreeAreTooFewToTellTheSpreadAndFourAreNot) {
  estimate(std::vector<PoseHypothesis>(3, seenWith(0.2, 1e-4)));
  EXPECT_NEAR(front().offset_spread, kSpreadUnknown, kExact);
  estimate(std::vector<PoseHypothesis>(4, seenWith(0.0, 1e-4)));
  EXPECT_NEAR(front().offset_spread, kSpreadLeast, kExact);
}

TEST_F(EdgeOffset, TheMeanOfManyCopiesAndTheirSpreadBeyondTheErrors) {
  std::vector<PoseHypothesis> poses;
  for (const double offset_mm : {0.3, 0.1, 0.5, 0.2, 0.4})
    poses.push_back(seenWith(offset_mm, 0.05));
  estimate(poses);
  const double variance =
      2.198 * 0.1 * 0.1 - 0.05 * 0.05;  // the median square off 0.3 is 0.1 squared
  EXPECT_NEAR(1e3 * front().offset_spread, std::sqrt(variance), 1e-9);
  const double weight = 5.0 / (variance + 0.05 * 0.05), prior = 1.0 / (0.1 * 0.1);
  EXPECT_NEAR(1e3 * front().offset, (0.3 * weight + 0.05 * prior) / (weight + prior), 1e-9);
  EXPECT_NEAR(1e3 * front().offset_sigma, 1.0 / std::sqrt(weight + prior), 1e-9);
}

TEST_F(EdgeOffset, SureCopiesCountMore) {
  estimate({seenWith(0.0, 0.01), seenWith(0.3, 0.3)});
  EXPECT_LT(1e3 * front().offset, 0.03);
  EXPECT_GT(1e3 * front().offset, 0.0);
}

TEST_F(EdgeOffset, EachPartAndFaceHasItsOwn) {
  std::vector<PoseHypothesis> poses(3, seenWith(0.2, 0.01));
  poses[1].face = Face::kBack;
  poses[1].image.offset *= -1.0;
  poses[2].part = 1;
  poses[2].image.offset *= 2.0;
  estimate(poses);
  EXPECT_GT(front().offset, 0.1e-3);
  // Off the prior's mean they lie as the poses do.
  const double off = front().offset - kMean;
  EXPECT_NEAR(outlines_[0].of(Face::kBack).offset - kMean, -5.0 / 3.0 * off, kExact);
  EXPECT_NEAR(outlines_[1].of(Face::kFront).offset - kMean, 7.0 / 3.0 * off, kExact);
  EXPECT_NEAR(outlines_[1].of(Face::kBack).offset, kMean, kExact);
}

TEST_F(EdgeOffset, PosesThatAreNotWellAlignedOrCannotTellSayNothing) {
  PoseHypothesis rough = seenWith(0.2, 0.01), blind = rough;
  rough.inlier_score = 0.69;
  blind.image.offset_sigma = std::numeric_limits<double>::infinity();
  estimate({rough, blind});
  EXPECT_NEAR(front().offset, kMean, kExact);
  EXPECT_NEAR(front().offset_sigma, kMeanSigma, kExact);
  rough.inlier_score = 0.7;
  estimate({rough});
  EXPECT_GT(front().offset, 0.1e-3);
}

TEST_F(EdgeOffset, AllPointsMoveIntoTheMaterialByTheMean) {
  estimate({seenWith(0.2, 0.01)});
  const double moved = front().offset / radius();
  ASSERT_GT(moved, 0.0);
  EXPECT_NEAR(front().coarse[0].x, 1.0 - moved, kExact);
  EXPECT_NEAR(front().wide[0].y, 1.0 - moved, kExact);
  EXPECT_NEAR(front().fine[0].x, -1.0 + moved, kExact);
  EXPECT_NEAR(outlines_[0].of(Face::kBack).fine[0].x, -1.0 + kMean / radius(), kExact);
}

TEST_F(EdgeOffset, ASecondEstimateStartsAtTheFirst) {
  estimate(std::vector<PoseHypothesis>(8, seenWith(0.2, 0.01)));
  const FaceOutline first = front();
  // Now seen from the outline as it was moved: the offsets are what is left.
  const double left_mm = 0.2 - 1e3 * first.offset;
  estimate(std::vector<PoseHypothesis>(8, seenWith(left_mm, 0.01)));
  EXPECT_NEAR(front().offset, first.offset, kExact);
  EXPECT_NEAR(front().fine[0].x, first.fine[0].x, kExact);
  // With no copies left the outline goes back to where cut edges mostly lie.
  estimate({});
  EXPECT_NEAR(front().fine[0].x, -1.0 + kMean / radius(), kExact);
}

class OwnOffset : public EdgeOffset {
 protected:
  OwnOffset() {
    FaceOutline& face = outlines_[0].of(Face::kFront);
    face.offset = 0.1e-3;
    face.offset_spread = 0.05e-3;
    face.offset_sigma = 0.0;
  }
  RefinedPose refined(const PoseHypothesis& pose) const {
    return withOwnOffset(pose, outlines_[0], kFocal);
  }
  FaceOutline& face() { return outlines_[0].of(Face::kFront); }
  double floorVariance() const { return std::pow(0.02 * 0.6 / (kFocal * radius()), 2); }
  /// As deep as the floor is said for.
  PoseHypothesis atDepth(PoseHypothesis pose) const {
    pose.image.T_camera_centre.translation().z() = 0.6;
    pose.T_camera_part = pose.image.T_camera_centre * centreOf(*part_, pose.face).inverse();
    return pose;
  }
};

TEST_F(OwnOffset, LiesBetweenOwnAndMeanByTheTwoVariances) {
  for (const auto& [sigma_mm, share] :
       {std::pair{1e-5, 1.0}, {0.05, 0.5}, {0.1, 0.2}, {10.0, 0.0}}) {
    EXPECT_NEAR(1e3 * refined(seenWith(0.3, sigma_mm)).edge_offset, 0.1 + share * 0.3, 1e-4)
        << sigma_mm;
  }
}

TEST_F(OwnOffset, OneThatCannotTellGetsTheMeanAndAWideCovariance) {
  PoseHypothesis sure = seenWith(0.0, 0.001), blind = sure;
  sure.image.per_offset(2) = blind.image.per_offset(2) = 20.0;
  blind.image.offset = 0.3e-3 / radius();
  blind.image.offset_sigma = std::numeric_limits<double>::infinity();
  const RefinedPose pose = refined(blind);
  EXPECT_NEAR(pose.edge_offset, 0.1e-3, 1e-9);
  EXPECT_TRUE(isometryNear(pose.T_camera_part, blind.T_camera_part, 1e-7, 1e-7));
  // As deep as the spread of the copies leaves it: 20 times 0.05 mm.
  EXPECT_NEAR(std::sqrt(pose.covariance(2, 2)), 1e-3, 2e-5);
  EXPECT_LT(std::sqrt(refined(sure).covariance(2, 2)), 0.1e-3);
}

TEST_F(OwnOffset, ThePoseMovesWithIt) {
  PoseHypothesis pose = seenWith(0.2, 0.05);
  pose.image.per_offset << 1.0, 0.0, 20.0, 0.0, 0.5, 0.0;
  const Vector6d xi = 0.5 * pose.image.offset * pose.image.per_offset;
  const Eigen::Isometry3d expected =
      stepped(pose.image.T_camera_centre, xi, radius()) * centreOf(*part_, pose.face).inverse();
  const RefinedPose out = refined(pose);
  EXPECT_TRUE(isometryNear(out.T_camera_part, expected, 1e-9, 1e-7));
  EXPECT_FALSE(isometryNear(out.T_camera_part, pose.T_camera_part, 1e-3, 1.0));
}

TEST_F(OwnOffset, TheCovarianceHoldsTheImagesAndTheOffsetsUnitsInMetres) {
  PoseHypothesis pose = atDepth(seenWith(0.2, 0.05));
  pose.image.per_offset << 0.0, 0.0, 20.0, 0.0, 0.5, 0.0;
  pose.image.covariance = 1e-6 * Matrix6d::Identity();
  const double offset = 0.5 * std::pow(0.05e-3 / radius(), 2);  // half of either variance
  const double rest = 1e-6 + floorVariance(), r = radius();
  const Matrix6d C = refined(pose).covariance;
  EXPECT_NEAR(C(0, 0) / (r * r * rest), 1.0, 1e-9);
  EXPECT_NEAR(C(2, 2) / (r * r * (rest + 400.0 * offset)), 1.0, 1e-9);
  EXPECT_NEAR(C(3, 3) / rest, 1.0, 1e-9);
  EXPECT_NEAR(C(4, 4) / (rest + 0.25 * offset), 1.0, 1e-9);
  EXPECT_NEAR(C(2, 4) / (r * 10.0 * offset), 1.0, 1e-6);
}

TEST_F(OwnOffset, TheErrorOfTheMeanCountsByTheCopiesShare) {
  PoseHypothesis pose = atDepth(seenWith(0.2, 0.1));
  pose.image.per_offset(2) = 20.0;
  const double before = refined(pose).covariance(2, 2);
  face().offset_sigma = 0.1e-3;
  // The copies decide 0.1^2 of 0.1^2 + 0.05^2: four fifths.
  EXPECT_NEAR((refined(pose).covariance(2, 2) - before) / std::pow(20.0 * 0.8 * 0.1e-3, 2), 1.0,
              1e-6);
}

TEST_F(OwnOffset, NoEdgeBeatsTheFloor) {
  PoseHypothesis pose = atDepth(seenWith(0.0, 0.05));
  pose.image.covariance.setZero();
  const Matrix6d C = refined(pose).covariance;
  for (int i = 0; i < 6; ++i) {
    const double unit = i < 3 ? radius() : 1.0;
    EXPECT_NEAR(C(i, i) / (unit * unit * floorVariance()), 1.0, 1e-6) << i;
  }
}

TEST_F(OwnOffset, TheBackHasItsOwnMeanAndCentre) {
  PoseHypothesis pose = seenWith(0.0, 0.05);
  pose.face = Face::kBack;
  pose.part = 3;
  pose.image.residual_px = 0.25;
  const auto thick = makePart("thick", {rectangle(-30, -20, 30, 20), {}, {}, 4.0});
  outlines_[0].part = thick.get();
  outlines_[0].of(Face::kBack).offset = 0.3e-3;
  outlines_[0].of(Face::kBack).offset_spread = 0.05e-3;
  pose.image.T_camera_centre = pose.T_camera_part * centreOf(*thick, Face::kBack);
  const RefinedPose out = refined(pose);
  EXPECT_EQ(out.part, 3u);
  EXPECT_EQ(out.face, Face::kBack);
  EXPECT_EQ(out.residual_px, 0.25);
  EXPECT_NEAR(out.edge_offset, 0.3e-3, kExact);
  EXPECT_TRUE(isometryNear(out.T_camera_part, pose.T_camera_part, 1e-9, 1e-7));
}

}  // namespace
}  // namespace planar_bin_picking
