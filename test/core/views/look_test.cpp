// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/look.h"

#include "base/plane_pose.h"
#include "part/outline_view.h"
#include "planar_bin_picking/locate/locator.h"
#include "support/looked_bracket.h"
#include "support/matchers.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include <regex>

namespace planar_bin_picking {
namespace {

/// As good a robot as the pictures of these tests are drawn.
const LocatorParams kExact = [] {
  LocatorParams params;
  params.views.robot_sigma = params.views.hand_eye_sigma = 0.0;
  params.views.robot_sigma_deg = params.views.hand_eye_sigma_deg = 0.0;
  return params;
}();

class LookAgain : public testing::Test {
 protected:
  Eigen::Isometry3d truth_ = sim::poseOf(kLie);
  Eigen::Isometry3d T_first_second_ = orbit(kCentre, 30, 20);
  ViewPtr first_ = viewOf(bracketAt(truth_), Eigen::Isometry3d::Identity(), 1);
  ViewPtr second_ = viewOf(bracketAt(truth_), T_first_second_, 2);

  /// With a plate in front of it, from its left up to there.
  sim::Scene coveredTo(double x_mm) const {
    sim::Scene scene = bracketAt(truth_);
    scene.plates.push_back(scene.plates[0]);
    scene.plates[1].plate = {rectangle(-100, -60, x_mm, 60), {}, {}, 0.0};
    return scene;
  }

  LookResult look(const Eigen::Isometry3d& known, const ViewPtr& view) const {
    return Looker(kExact).look(knownAt(known), *kBracket, {first_, view});
  }
};

/// The numbers of a text, in their order.
std::vector<double> numbersIn(const std::string& text) {
  const std::regex number("[0-9]+([.][0-9]+)?");
  std::vector<double> numbers;
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end; ++at)
    numbers.push_back(std::stod(at->str()));
  return numbers;
}

Eigen::Isometry3d deeper(Eigen::Isometry3d T, double metres) {
  T.translation() *= 1.0 + metres / kCentre.norm();
  return T;
}

double depthSigma(const Detection& d) {
  const Eigen::Matrix3d R = d.T_camera_part.linear();
  return std::sqrt((R * d.covariance.topLeftCorner<3, 3>() * R.transpose())(2, 2));
}

TEST_F(LookAgain, ConfirmsWhatIsThere) {
  LocateRequest request;
  request.parts = {kBracket};
  request.distance_min = 0.5;
  request.distance_max = 0.7;
  const auto alone = Locator().locate(first_->image(), first_->camera(), request);
  ASSERT_EQ(alone.detections.size(), 1u);
  const auto result = Looker(kExact).look(alone.detections[0], *kBracket, {first_, second_});
  EXPECT_EQ(result.status, LookStatus::kConfirmed) << result.text;
  EXPECT_TRUE(isometryNear(result.detection.T_camera_part, truth_, 0.1e-3, 0.1 * kDegrees));
  EXPECT_GT(result.seen, 0.8);
  EXPECT_LT(depthSigma(result.detection), 0.5 * depthSigma(alone.detections[0]));
  EXPECT_LT(result.moved, 2e-3);
}

/// Its edges are seen as far below the face as inside the drawn outline.
TEST_F(LookAgain, FindsTheFaceAboveBrokenEdges) {
  constexpr double kBreakMm = 0.15;
  sim::Scene scene = bracketAt(truth_ * Eigen::Translation3d(0.0, 0.0, -1e-3 * kBreakMm));
  scene.plates[0].plate = smallerBracket(kBreakMm);
  Detection known = knownAt(truth_);
  known.edge_offset = 1e-3 * kBreakMm;
  double depth = 0.0;
  constexpr int kLooks = 4;
  for (int i = 0; i < kLooks; ++i) {
    const auto result = Looker(kExact).look(known, *kBracket,
                                            {viewOf(scene, Eigen::Isometry3d::Identity(), 10 + i),
                                             viewOf(scene, T_first_second_, 20 + i)});
    ASSERT_EQ(result.status, LookStatus::kConfirmed) << result.text;
    EXPECT_NEAR(result.detection.edge_offset, 1e-3 * kBreakMm, 0.05e-3);
    depth += (truth_.inverse() * result.detection.T_camera_part).translation().z() / kLooks;
  }
  EXPECT_NEAR(depth, 0.0, 0.06e-3);
}

TEST_F(LookAgain, FindsAPartInAnotherDepth) {
  for (const double off : {-0.012, -0.008, 0.005, 0.008, 0.012}) {
    Eigen::Isometry3d wrong = truth_;
    wrong.translation() *= 1.0 + off / kCentre.norm();
    const auto result = look(wrong, second_);
    EXPECT_EQ(result.status, LookStatus::kCorrected) << off << " m: " << result.text;
    EXPECT_NEAR(result.moved, std::abs(off), 0.5e-3);
    EXPECT_TRUE(isometryNear(result.detection.T_camera_part, truth_, 0.2e-3, 0.2 * kDegrees));
  }
}

TEST_F(LookAgain, FindsTheOtherTilt) {
  const Eigen::Isometry3d T = truth_ * centreOf(*kBracket, Face::kFront);
  const Eigen::Vector2d p = T.translation().hnormalized();
  Eigen::Matrix<double, 2, 3> project;
  project << 1, 0, -p.x(), 0, 1, -p.y();
  const Eigen::Matrix2d A = project * T.linear().leftCols<2>() / T.translation().z();
  const auto planes = posesFromAffine(A, p);
  const auto apart = [&](int k) { return (planes[k].linear() - T.linear()).norm(); };
  const Eigen::Isometry3d wrong =
      planes[apart(0) > apart(1) ? 0 : 1] * centreOf(*kBracket, Face::kFront).inverse();
  ASSERT_FALSE(isometryNear(wrong, truth_, 1.0, 15 * kDegrees));
  const auto result = look(wrong, second_);
  EXPECT_EQ(result.status, LookStatus::kCorrected) << result.text;
  EXPECT_GT(result.moved_rad, 15 * kDegrees);
  EXPECT_TRUE(isometryNear(result.detection.T_camera_part, truth_, 0.2e-3, 0.2 * kDegrees));
}

/// Also along the line on which another depth would be seen: never the mean of both.
TEST_F(LookAgain, TellsAPartThatMoved) {
  const Eigen::Vector3d beside = T_first_second_.linear().col(0), ray = kCentre.normalized();
  const Eigen::Vector3d along = (T_first_second_.linear() * Eigen::Vector3d::UnitZ())
                                    .cross(ray.cross(T_first_second_.linear().col(2)));
  for (const Eigen::Vector3d& way : {beside, Eigen::Vector3d(along.normalized())}) {
    Eigen::Isometry3d moved = truth_;
    moved.translation() += 3e-3 * way;
    const auto result = look(truth_, viewOf(bracketAt(moved), T_first_second_, 3));
    EXPECT_EQ(result.status, LookStatus::kMoved) << result.text;
    EXPECT_NEAR(result.moved, 3e-3, 1.5e-3);  // the new view alone says little of its depth
    EXPECT_GT(result.seen, 0.7);
    EXPECT_TRUE(isometryNear(result.detection.T_camera_part, moved, 1.5e-3, 2 * kDegrees));
  }
}

TEST_F(LookAgain, ContradictsWhatIsNotThere) {
  sim::Scene empty;
  const auto result = look(truth_, viewOf(empty, T_first_second_, 3));
  EXPECT_EQ(result.status, LookStatus::kContradicted) << result.text;
  EXPECT_LT(result.seen, 0.3);
  Eigen::Isometry3d far = truth_;
  far.translation().x() += 0.02;
  EXPECT_EQ(look(far, second_).status, LookStatus::kContradicted);
}

TEST_F(LookAgain, SaysWhatIsNotSeen) {
  Eigen::Isometry3d aside = T_first_second_;
  aside.translation().x() += 0.3;
  const auto outside = look(truth_, viewOf(bracketAt(truth_), aside, 3));
  EXPECT_EQ(outside.status, LookStatus::kNotSeen) << outside.text;
  EXPECT_NE(outside.text.find("outline"), std::string::npos);
  EXPECT_TRUE(isometryNear(outside.detection.T_camera_part, truth_, 1e-12, 1e-12));
  const auto covered = look(truth_, viewOf(coveredTo(14), T_first_second_, 3));
  EXPECT_EQ(covered.status, LookStatus::kNotSeen) << covered.text;
}

/// What bears out a pose that was known is too little for another one.
TEST_F(LookAgain, ACoveredPartIsNotCorrected) {
  Eigen::Isometry3d deep = truth_;
  deep.translation() *= 1.0 + 0.008 / kCentre.norm();
  const ViewPtr half = viewOf(coveredTo(-8), T_first_second_, 3);
  const auto right = look(truth_, half);
  EXPECT_EQ(right.status, LookStatus::kConfirmed) << right.text;
  EXPECT_LT(right.seen, 0.65);
  const auto wrong = look(deep, half);
  EXPECT_EQ(wrong.status, LookStatus::kContradicted) << wrong.text;
  const auto less = look(deep, viewOf(coveredTo(14), T_first_second_, 3));
  EXPECT_EQ(less.status, LookStatus::kContradicted) << less.text;
}

/// As when the camera's place is taken from tf at another time than the picture's.
TEST_F(LookAgain, ACameraThatIsElsewhereConfirmsNothing) {
  for (const double off : {0.004, 0.02, 0.05}) {
    Eigen::Isometry3d said = T_first_second_;
    said.translation().y() += off;
    const auto result = look(truth_, viewOf(bracketAt(truth_), T_first_second_, 3, &said));
    EXPECT_NE(result.status, LookStatus::kConfirmed) << off << " m: " << result.text;
  }
}

TEST_F(LookAgain, AThirdLookAddsUp) {
  LocatorParams params;  // of a robot as it is by default
  const Looker looker(params);
  const auto two = looker.look(knownAt(truth_), *kBracket, {first_, second_});
  ASSERT_EQ(two.status, LookStatus::kConfirmed);
  const ViewPtr third = viewOf(bracketAt(truth_), orbit(kCentre, 30, 110), 4);
  const auto three = looker.look(two.detection, *kBracket, {first_, second_, third});
  EXPECT_EQ(three.status, LookStatus::kConfirmed) << three.text;
  EXPECT_LT(three.detection.covariance.trace(), 0.9 * two.detection.covariance.trace());
}

/// Errors against what the covariance says of them, with a robot that is as wrong as it is said.
TEST_F(LookAgain, TheCovarianceIsHonest) {
  LocatorParams params = kExact;
  params.views.robot_sigma = 0.2e-3;
  params.views.robot_sigma_deg = 0.03;
  std::mt19937 random(7);
  double sum = 0.0;
  constexpr int kLooks = 20;
  for (int i = 0; i < kLooks; ++i) {
    const auto known = shaken(truth_, 0.1e-3, 0.1, &random);
    const Eigen::Isometry3d noisy = shaken(Eigen::Isometry3d::Identity(), 0.2e-3, 0.03, &random);
    const Eigen::Isometry3d said = noisy * shaken(T_first_second_, 0.2e-3, 0.03, &random);
    const auto result =
        Looker(params).look(knownAt(known), *kBracket,
                            {viewOf(bracketAt(truth_), Eigen::Isometry3d::Identity(), 100 + i),
                             viewOf(bracketAt(truth_), T_first_second_, 200 + i, &said)});
    ASSERT_EQ(result.status, LookStatus::kConfirmed) << result.text;
    const Eigen::Isometry3d T_centre = centreOf(*kBracket, Face::kFront);
    const Vector6d off =
        log((result.detection.T_camera_part * T_centre).inverse() * truth_ * T_centre);
    sum += off.dot(result.detection.covariance.ldlt().solve(off)) / 6.0;
  }
  EXPECT_LT(sum / kLooks, 1.5);
  EXPECT_GT(sum / kLooks, 0.05);  // drawn without bevel and shadow, less than is allowed for
}

/// What a robot program logs, and its operator reads.
TEST_F(LookAgain, SaysWhatItFoundInNumbers) {
  for (const double off : {0.0, 0.008}) {
    const auto result = look(deeper(truth_, off), second_);
    EXPECT_EQ(std::string(nameOf(result.status)), off > 0.0 ? "corrected" : "confirmed");
    EXPECT_NE(result.text.find("2 views agree (chi squared"), std::string::npos) << result.text;
    EXPECT_NE(result.text.find("mm and"), std::string::npos) << result.text;
    EXPECT_NE(result.text.find("degrees from what was known"), std::string::npos) << result.text;
    const auto said = numbersIn(result.text);  // views, chi squared, of, mm, degrees
    ASSERT_EQ(said.size(), 5u) << result.text;
    EXPECT_GT(said[1], 0.0);
    EXPECT_EQ(said[2], 8.0);
    EXPECT_NEAR(said[3], 1e3 * result.moved, 0.006);
    EXPECT_NEAR(said[3], 1e3 * off, 0.5);
    EXPECT_NEAR(said[4], result.moved_rad / kDegrees, 0.006);
    EXPECT_EQ(result.detection.views, 2);
  }
  Eigen::Isometry3d moved = truth_;
  moved.translation() += 3e-3 * T_first_second_.linear().col(0);
  const auto apart = look(truth_, viewOf(bracketAt(moved), T_first_second_, 3));
  EXPECT_EQ(std::string(nameOf(apart.status)), "moved");
  EXPECT_NE(apart.text.find("seen in either view, but"), std::string::npos) << apart.text;
  EXPECT_NE(apart.text.find("apart: locate again"), std::string::npos) << apart.text;
  EXPECT_NEAR(numbersIn(apart.text).at(0), 1e3 * apart.moved, 0.006);
  EXPECT_NEAR(numbersIn(apart.text).at(1), apart.moved_rad / kDegrees, 0.006);
  EXPECT_EQ(apart.detection.views, 1);
  // One view tells much less of it than two do.
  EXPECT_GT(depthSigma(apart.detection), 2.0 * depthSigma(look(truth_, second_).detection));
}

/// Half of its outline is there in either view, and agrees: it is not what was seen first.
TEST_F(LookAgain, WhatFitsByHalfIsNotConfirmed) {
  const sim::Plate half{
      {{-33, -29}, {15, -29}, {15, -9}, {-3, -9}, {-3, 21}, {-33, 21}}, {}, {}, 0.0};
  sim::Scene scene;
  scene.plates.push_back({half, truth_});
  const auto first = viewOf(scene, Eigen::Isometry3d::Identity(), 2);
  const auto second = viewOf(scene, T_first_second_, 3);
  const auto result = Looker(kExact).look(knownAt(truth_), *kBracket, {first, second});
  EXPECT_EQ(std::string(nameOf(result.status)), "contradicted") << result.text;
  const auto said = numbersIn(result.text);
  ASSERT_EQ(said.size(), 6u) << result.text;
  EXPECT_GT(said[0], 45.0);  // as much as a view that hides a part may have
  EXPECT_GT(said[1], 45.0);
  EXPECT_LT(said[0], 65.0);
}

TEST_F(LookAgain, SaysWhyNothingFits) {
  const auto gone = look(truth_, viewOf(sim::Scene(), T_first_second_, 3));
  EXPECT_EQ(std::string(nameOf(gone.status)), "contradicted");
  EXPECT_NE(gone.text.find("the part is not there: no pose fits"), std::string::npos) << gone.text;
  // Percent: first, new, each by itself.
  const auto said = numbersIn(gone.text);
  ASSERT_EQ(said.size(), 6u) << gone.text;
  EXPECT_LE(said[0], 100.0);
  EXPECT_LT(said[1], 30.0);
  EXPECT_GT(said[2], 80.0);
  EXPECT_LE(said[2], 100.0);
  EXPECT_LT(said[3], 30.0);
  EXPECT_TRUE(gone.detection.T_camera_part.isApprox(truth_, 1e-12));
  EXPECT_EQ(gone.detection.covariance, knownAt(truth_).covariance);
  EXPECT_EQ(gone.moved, 0.0);
  // As well where it is the first picture that does not bear it out.
  const auto before =
      Looker(kExact).look(knownAt(truth_), *kBracket,
                          {viewOf(sim::Scene(), Eigen::Isometry3d::Identity(), 1), second_});
  EXPECT_EQ(before.status, LookStatus::kContradicted) << before.text;
  EXPECT_LT(numbersIn(before.text).at(2), 30.0);
  EXPECT_GT(numbersIn(before.text).at(3), 80.0);
  const auto hidden = look(truth_, viewOf(coveredTo(14), T_first_second_, 3));
  EXPECT_EQ(std::string(nameOf(hidden.status)), "not_seen");
  EXPECT_NE(hidden.text.find("% of its outline is borne out: something is in front of it"),
            std::string::npos)
      << hidden.text;
  EXPECT_GT(numbersIn(hidden.text).at(0), 30.0);
  EXPECT_LT(numbersIn(hidden.text).at(0), 45.0);
  EXPECT_NEAR(numbersIn(hidden.text).at(0), 100.0 * hidden.seen, 15.0);
}

/// The camera moves aside until less and less of the part is in its picture.
TEST_F(LookAgain, APartAtThePicturesBorderIsNotSeen) {
  const auto from = [&](double pixels_inside) {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    const double px_per_metre = 1700.0 / 0.6;
    T.translation().x() = kCentre.x() + (604.3 - pixels_inside) / px_per_metre;
    return look(truth_, viewOf(bracketAt(truth_), T, 3));
  };
  const auto half = from(0.0), most = from(70.0);
  EXPECT_EQ(half.status, LookStatus::kNotSeen);
  EXPECT_NE(half.text.find("the picture shows"), std::string::npos) << half.text;
  EXPECT_NE(half.text.find("~next_view"), std::string::npos) << half.text;
  EXPECT_NEAR(numbersIn(half.text).at(0), 45.0, 15.0);
  EXPECT_EQ(most.text.find("the picture shows"), std::string::npos) << most.text;
}

TEST_F(LookAgain, AnotherPlaceIsFartherThanWasKnown) {
  const auto statusAt = [&](double off, double vague) {
    Detection known = knownAt(deeper(truth_, off));
    known.covariance *= vague * vague;
    const auto result = Looker(kExact).look(known, *kBracket, {first_, second_});
    return std::string(nameOf(result.status));
  };
  EXPECT_EQ(statusAt(0.0006, 0.1), "confirmed");  // too little for a gripper
  EXPECT_EQ(statusAt(0.0020, 0.1), "corrected");
  EXPECT_EQ(statusAt(0.0020, 5.0), "confirmed");  // as vague as was said
  EXPECT_EQ(statusAt(0.0045, 5.0), "corrected");  // a robot would have felt it
}

TEST_F(LookAgain, OnlyViewsThatAgreeAreKept) {
  TrackedPart tracked{knownAt(truth_), {first_}};
  const Looker looker(kExact);
  EXPECT_EQ(looker.look(*kBracket, second_, &tracked).status, LookStatus::kConfirmed);
  EXPECT_EQ(tracked.views, (std::vector<ViewPtr>{first_, second_}));
  EXPECT_EQ(tracked.detection.views, 2);
  const Detection before = tracked.detection;
  const auto gone = looker.look(*kBracket, viewOf(sim::Scene(), T_first_second_, 3), &tracked);
  EXPECT_EQ(gone.status, LookStatus::kContradicted);
  EXPECT_EQ(tracked.views.size(), 2u);
  EXPECT_EQ(tracked.detection.T_camera_part.matrix(), before.T_camera_part.matrix());
  tracked = {knownAt(deeper(truth_, 0.008)), {first_}};
  EXPECT_EQ(looker.look(*kBracket, second_, &tracked).status, LookStatus::kCorrected);
  EXPECT_EQ(tracked.views.size(), 2u);
}

TEST_F(LookAgain, AViewHoldsItsOwnPicture) {
  cv::Mat image = first_->image().clone(), deep;
  image.convertTo(deep, CV_16U, 256.0);
  const View view(image, first_->camera(), T_first_second_);
  image.setTo(0);
  EXPECT_EQ(cv::norm(view.image(), first_->image(), cv::NORM_INF), 0.0);
  EXPECT_EQ(view.noise(), first_->noise());
  EXPECT_GT(view.noise()[100], 0.0F);
  EXPECT_TRUE(view.T_first_this().isApprox(T_first_second_));
  const View of_deep(deep, first_->camera(), T_first_second_);
  EXPECT_EQ(of_deep.image().depth(), CV_8U);
  EXPECT_LE(cv::norm(of_deep.image(), first_->image(), cv::NORM_INF), 128.0);
}

TEST_F(LookAgain, RefusesWhatIsNoView) {
  EXPECT_TRUE(refuses([&] { Looker().look(knownAt(truth_), *kBracket, {first_}); }, {"two views"}));
  const Camera camera = makeCamera(kPinhole);
  const auto make = [&](const cv::Mat& image, double x) {
    return [&camera, image, x] {
      Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
      T.translation().x() = x;
      View(image, camera, T);
    };
  };
  EXPECT_TRUE(refuses(make({}, 0.0), {"empty"}));
  EXPECT_TRUE(refuses(make(cv::Mat(100, 100, CV_8U), 0.0), {"100 x 100", "1200 x 1000"}));
  EXPECT_TRUE(refuses(make(cv::Mat(1000, 1200, CV_8UC3), 0.0), {"3 channels"}));
  EXPECT_TRUE(refuses(make(cv::Mat(1000, 1200, CV_8U, cv::Scalar(9)), NAN), {"pose"}));
  EXPECT_TRUE(refuses(make(cv::Mat(1000, 1200, CV_32F), 0.0), {"8 or 16 bit"}));
  // Some drivers pad or crop by a pixel or two.
  make(cv::Mat(998, 1198, CV_8U, cv::Scalar(9)), 0.0)();
  EXPECT_TRUE(refuses(make(cv::Mat(1000, 1197, CV_8U), 0.0), {"1197 x 1000"}));
  EXPECT_TRUE(refuses(make(cv::Mat(997, 1200, CV_8U), 0.0), {"1200 x 997"}));
  sim::PinholeCamera small;
  small.width = small.height = 64;
  small.cx = small.cy = 32.0;
  const Camera least = makeCamera(small);
  const auto of_size = [&least](int width, int height) {
    return [&least, width, height] {
      View(cv::Mat(height, width, CV_8U, cv::Scalar(9)), least, Eigen::Isometry3d::Identity());
    };
  };
  of_size(64, 64)();
  EXPECT_TRUE(refuses(of_size(63, 64), {"smaller than 64 x 64"}));
  EXPECT_TRUE(refuses(of_size(64, 63), {"smaller than 64 x 64"}));
}

}  // namespace
}  // namespace planar_bin_picking
