// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/show/overlay.h"

#include "support/matchers.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <algorithm>
#include <cstdlib>
#include <memory>

namespace planar_bin_picking {
namespace {

/// A plate of 80 x 40 mm, 0.5 m in front of a camera whose lens bends visibly.
class OverlayTest : public testing::Test {
 protected:
  OverlayTest() {
    Camera::Model model;
    model.width = 640;
    model.height = 480;
    model.fx = model.fy = 900.0;
    model.cx = 320.0;
    model.cy = 240.0;
    model.distortion = {-0.25, 0.05, 0.0, 0.0, 0.0};
    camera_ = std::make_unique<Camera>(model);
    PartFile file;
    file.name = "plate";
    file.thickness = 5e-3;
    file.drawing.loops.push_back(
        {LoopKind::kOuter, true, {{-0.04, -0.02}, {0.04, -0.02}, {0.04, 0.02}, {-0.04, 0.02}}});
    file.drawing.loops.push_back({LoopKind::kPrint, false, {{-0.03, 0.0}, {-0.01, 0.0}}});
    parts_.push_back(std::make_shared<const PartModel>(file));
    detection_.part_name = "plate";
    detection_.T_camera_part.translation() = Eigen::Vector3d(0.06, 0.03, 0.5);
    detection_.T_camera_part.linear() =
        Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX()).toRotationMatrix();
  }

  /// How far from grey the brightest pixel within 2 px of a point on the part is.
  int colorAt(const cv::Mat& overlay, const Eigen::Vector3d& p_part) const {
    const Eigen::Vector2d p = camera_->project(detection_.T_camera_part * p_part);
    int most = 0;
    for (int dy = -2; dy <= 2; ++dy) {
      for (int dx = -2; dx <= 2; ++dx) {
        const auto& c =
            overlay.at<cv::Vec3b>(static_cast<int>(p.y()) + dy, static_cast<int>(p.x()) + dx);
        most = std::max({most, std::abs(c[0] - c[1]), std::abs(c[1] - c[2])});
      }
    }
    return most;
  }

  std::unique_ptr<Camera> camera_;
  std::vector<std::shared_ptr<const PartModel>> parts_;
  Detection detection_;
  cv::Mat image_ = cv::Mat(480, 640, CV_8U, cv::Scalar(90));
};

TEST_F(OverlayTest, WithoutDetectionsItIsTheGreyImage) {
  const cv::Mat overlay = drawOverlay(image_, *camera_, parts_, {});
  ASSERT_EQ(overlay.type(), CV_8UC3);
  EXPECT_EQ(overlay.size(), image_.size());
  EXPECT_EQ(cv::mean(overlay), cv::Scalar(90, 90, 90, 0));
}

TEST_F(OverlayTest, OutlinesLieWhereTheLensPutsThem) {
  const cv::Mat overlay = drawOverlay(image_, *camera_, parts_, {detection_});
  // Corners, and points on the sides in between, where a straight line would be off.
  for (const double x : {-0.04, -0.02, 0.015, 0.04}) {
    EXPECT_GT(colorAt(overlay, {x, 0.02, 0.0}), 60) << x;
    EXPECT_GT(colorAt(overlay, {x, -0.02, 0.0}), 60) << x;
  }
  EXPECT_EQ(colorAt(overlay, {0.035, 0.012, 0.0}), 0);  // inside it stays grey
}

TEST_F(OverlayTest, FacesDifferInColourAndPrint) {
  const cv::Mat front = drawOverlay(image_, *camera_, parts_, {detection_});
  EXPECT_GT(colorAt(front, {-0.02, 0.0, 0.0}), 60);
  const Eigen::Vector2d corner =
      camera_->project(detection_.T_camera_part * Eigen::Vector3d(0.03, 0.02, 0.0));
  const cv::Point pixel(static_cast<int>(corner.x()), static_cast<int>(corner.y()));
  const cv::Vec3b front_color = front.at<cv::Vec3b>(pixel);
  detection_.face = Face::kBack;
  detection_.T_camera_part.linear() = Eigen::Matrix3d::Identity();
  detection_.T_camera_part.translation().z() += 5e-3;  // the visible face stays where it was
  const cv::Mat back = drawOverlay(image_, *camera_, parts_, {detection_});
  EXPECT_EQ(colorAt(back, {-0.02, 0.0, -5e-3}), 0);
  EXPECT_GT(front_color[1], front_color[2]);                              // green
  EXPECT_GT(back.at<cv::Vec3b>(pixel)[2], back.at<cv::Vec3b>(pixel)[1]);  // orange
}

TEST_F(OverlayTest, DotsWhatIsCovered) {
  const Eigen::Vector2d cell = parts_[0]->faceGrid().cells().at(100);
  const Eigen::Vector3d middle(cell.x(), cell.y(), parts_[0]->faceZ(detection_.face));
  EXPECT_LT(colorAt(drawOverlay(image_, *camera_, parts_, {detection_}), middle), 20);
  detection_.covered = {100};
  EXPECT_GT(colorAt(drawOverlay(image_, *camera_, parts_, {detection_}), middle), 100);
}

TEST_F(OverlayTest, DrawsWhatIsRefusedAndWhereTheToolGoes) {
  OverlayMore more;
  more.refused.push_back({detection_, "TILT"});
  const cv::Mat refused = drawOverlay(image_, *camera_, parts_, {}, more);
  EXPECT_EQ(colorAt(refused, {-0.04, 0.02, 0.0}), 0);  // grey
  EXPECT_GT(cv::norm(refused, drawOverlay(image_, *camera_, parts_, {})), 1000.0);
  more.refused.clear();
  const Eigen::Isometry3d T_part_pick =
      Eigen::Translation3d(0.03, 0.01, 0.0) *
      Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX());
  more.T_camera_pick = {detection_.T_camera_part * T_part_pick};
  EXPECT_GT(colorAt(drawOverlay(image_, *camera_, parts_, {}, more), {0.03, 0.01, 0.0}), 100);
  more.T_camera_pick.clear();
  more.outlines = {{{-0.1, -0.1, 0.5}, {0.1, -0.1, 0.5}, {0.1, 0.1, 0.5}}};
  const Eigen::Vector3d on_it = detection_.T_camera_part.inverse() * Eigen::Vector3d(0.1, 0.0, 0.5);
  EXPECT_GT(colorAt(drawOverlay(image_, *camera_, parts_, {}, more), on_it), 100);
  more.outlines.clear();
  more.has_legend = true;
  const cv::Mat legend = drawOverlay(image_, *camera_, parts_, {}, more);
  more.outlines = {{}};  // of which there is nothing to draw
  EXPECT_GT(cv::norm(legend, drawOverlay(image_, *camera_, parts_, {}, more)),
            1000.0);  // one line more
  more.outlines.clear();
  EXPECT_EQ(cv::mean(legend(cv::Rect(320, 0, 320, 480))), cv::Scalar(90, 90, 90, 0));
  EXPECT_NE(cv::mean(legend(cv::Rect(0, 240, 320, 240))), cv::Scalar(90, 90, 90, 0));
  EXPECT_NO_THROW(drawOverlay(cv::Mat(20, 20, CV_8U, cv::Scalar(90)), *camera_, parts_, {}, more));
}

TEST_F(OverlayTest, StretchesSixteenBits) {
  cv::Mat dark(480, 640, CV_16U, cv::Scalar(10));
  dark(cv::Rect(0, 0, 320, 480)) = cv::Scalar(400);
  const cv::Mat overlay = drawOverlay(dark, *camera_, parts_, {});
  EXPECT_EQ(overlay.at<cv::Vec3b>(100, 100), cv::Vec3b(255, 255, 255));
  EXPECT_LT(overlay.at<cv::Vec3b>(100, 500)[0], 10);
}

TEST_F(OverlayTest, DrawsNothingOfWhatLiesOutsideTheView) {
  detection_.T_camera_part.translation() = Eigen::Vector3d(0.0, 0.0, -0.5);
  EXPECT_EQ(cv::mean(drawOverlay(image_, *camera_, parts_, {detection_})),
            cv::Scalar(90, 90, 90, 0));
  detection_.T_camera_part.translation() = Eigen::Vector3d(5.0, 0.0, 0.5);
  EXPECT_EQ(cv::mean(drawOverlay(image_, *camera_, parts_, {detection_})),
            cv::Scalar(90, 90, 90, 0));
}

TEST_F(OverlayTest, RefusesOtherImages) {
  EXPECT_TRUE(refuses([&] { drawOverlay(cv::Mat(480, 640, CV_8UC3), *camera_, parts_, {}); },
                      {"one channel"}));
  EXPECT_TRUE(refuses([&] { drawOverlay(cv::Mat(480, 640, CV_32F), *camera_, parts_, {}); },
                      {"8- or 16-bit"}));
}

}  // namespace
}  // namespace planar_bin_picking
