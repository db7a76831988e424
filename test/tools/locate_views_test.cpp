// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs locate_image with further views of a drawn scene, as a user does.

#include "support/dxf_writer.h"
#include "support/orbit.h"
#include "support/tool_test.h"

#include <yaml-cpp/yaml.h>
#include <opencv2/imgcodecs.hpp>

namespace planar_bin_picking {
namespace {

const sim::PinholeCamera kPinhole;
const sim::Lie kLie{20, -10, 600, 30, 12, 60};
const Eigen::Vector3d kCentre(0.02, -0.01, 0.6);

class LocateViews : public ToolTest {
 protected:
  LocateViews() : ToolTest(LOCATE_IMAGE) {
    DxfWriter drawing;
    const sim::Plate plate = bracketPlate();
    for (std::size_t i = 0; i < plate.outer.size(); ++i) {
      const Eigen::Vector2d &a = plate.outer[i], &b = plate.outer[(i + 1) % plate.outer.size()];
      drawing.line(a.x(), a.y(), b.x(), b.y());
    }
    drawing.circle(-18, 6, 6).circle(32, -19, 4);
    std::string lens;
    for (const double d : kPinhole.lens) lens += (lens.empty() ? "" : ", ") + std::to_string(d);
    camera_ = dir_.write(
        "camera.yaml",
        "image_width: 1200\nimage_height: 1000\ncamera_name: drawn\n"
        "camera_matrix: {rows: 3, cols: 3, data: [1700.0, 0, 604.3, 0, 1697.0, 492.8, 0, 0, 1]}\n"
        "distortion_model: plumb_bob\n"
        "distortion_coefficients: {rows: 1, cols: 5, data: [-0.11, 0.07, 4e-4, -5e-4, 0.01]}\n");
    first_ = "--part " + dir_.write("bracket.dxf", drawing.text()) + " --camera " + camera_ +
             " --image " + picture("first", Eigen::Isometry3d::Identity(), kLie) +
             " --distance-min 0.5 --distance-max 0.7 --output " + dir_.path("result.yaml");
  }

  std::string picture(const std::string& name, const Eigen::Isometry3d& T_first_this,
                      const sim::Lie& lie) {
    const std::string path = dir_.path(name + ".png");
    cv::imwrite(path, pictureFrom(kPinhole, sceneOf(bracketPlate(), lie), T_first_this, 3));
    return path;
  }

  std::string view(const std::string& name, const Eigen::Isometry3d& T_first_this,
                   const sim::Lie& lie) {
    const Eigen::Quaterniond q(T_first_this.linear());
    const Eigen::Vector3d p = T_first_this.translation();
    std::ostringstream pose;
    pose.precision(15);
    pose << "position: [" << p.x() << ", " << p.y() << ", " << p.z() << "]\norientation: [" << q.x()
         << ", " << q.y() << ", " << q.z() << ", " << q.w() << "]\n";
    return " --view " + picture(name, T_first_this, lie) + " " + camera_ + " " +
           dir_.write(name + ".yaml", pose.str());
  }

  YAML::Node result() { return YAML::LoadFile(dir_.path("result.yaml")); }

  double depthError(const YAML::Node& detection) const {
    return std::abs(detection["position"][2].as<double>() - 0.6);
  }

  std::string camera_, first_;
  const Eigen::Isometry3d left_ = orbit(kCentre, 30, 20), right_ = orbit(kCentre, 30, 110);
};

TEST_F(LocateViews, EachViewAddsToThePose) {
  ASSERT_EQ(run(first_), 0) << error_;
  ASSERT_EQ(result()["detections"].size(), 1u);
  EXPECT_FALSE(result()["detections"][0]["views"]);
  EXPECT_FALSE(result()["contradicted"]);
  ASSERT_EQ(run(first_ + view("left", left_, kLie) + view("right", right_, kLie)), 0) << error_;
  ASSERT_EQ(result()["detections"].size(), 1u);
  const YAML::Node part = result()["detections"][0];
  EXPECT_EQ(part["views"].as<int>(), 3);
  EXPECT_EQ(part["look"].as<std::string>(), "confirmed");
  EXPECT_LT(part["moved"].as<double>(), 0.002);
  EXPECT_LT(depthError(part), 0.1e-3);
  EXPECT_EQ(result()["contradicted"].size(), 0u);
  EXPECT_NE(out_.find("look at 1: confirmed"), std::string::npos);
  EXPECT_NE(out_.find("views"), std::string::npos);
}

TEST_F(LocateViews, APartThatIsGoneIsNoDetection) {
  sim::Lie gone = kLie;
  gone.x_mm += 60;
  ASSERT_EQ(run(first_ + view("left", left_, gone)), 0) << error_;
  EXPECT_EQ(result()["detections"].size(), 0u);
  ASSERT_EQ(result()["contradicted"].size(), 1u);
  EXPECT_EQ(result()["contradicted"][0]["look"].as<std::string>(), "contradicted");
  EXPECT_NE(out_.find("no part found"), std::string::npos);
}

TEST_F(LocateViews, APartThatMovedIsWhereTheLastViewHasIt) {
  sim::Lie moved = kLie;
  moved.y_mm += 3;
  ASSERT_EQ(run(first_ + view("left", left_, moved)), 0) << error_;
  ASSERT_EQ(result()["detections"].size(), 1u);
  const YAML::Node part = result()["detections"][0];
  EXPECT_EQ(part["look"].as<std::string>(), "moved");
  EXPECT_EQ(part["views"].as<int>(), 1);
  EXPECT_NEAR(part["moved"].as<double>(), 3e-3, 1.5e-3);
  EXPECT_NEAR(part["position"][1].as<double>(), -7e-3, 1.0e-3);
}

/// The same pictures with the camera's place of another time.
TEST_F(LocateViews, APoseOfAnotherTimeConfirmsNothing) {
  const std::string wrong = view("late", right_, kLie);
  const std::string right = view("left", left_, kLie);
  ASSERT_EQ(run(first_ + " --view " + dir_.path("left.png") + " " + camera_ + " " +
                dir_.path("late.yaml")),
            0)
      << error_;
  for (const auto& part : result()["detections"])
    EXPECT_NE(part["look"].as<std::string>(), "confirmed");
}

TEST_F(LocateViews, RefusesWhatIsNoView) {
  const std::string good = view("left", left_, kLie);
  const std::string picture = dir_.path("left.png");
  EXPECT_TRUE(refused(first_ + " --view " + picture, {"--view"}));
  const auto posed = [&](const std::string& yaml) {
    return first_ + " --view " + picture + " " + camera_ + " " + dir_.write("bad.yaml", yaml);
  };
  EXPECT_TRUE(refused(posed("position: [0, 0]\norientation: [0, 0, 0, 1]\n"),
                      {"bad.yaml", "position", "3 numbers"}));
  EXPECT_TRUE(refused(posed("position: [0, 0, .nan]\norientation: [0, 0, 0, 1]\n"),
                      {"position", "3 numbers"}));
  EXPECT_TRUE(refused(posed("position: [0, 0, 0]\norientation: [0, 0, 0, 2]\n"),
                      {"orientation", "length 1"}));
  EXPECT_TRUE(refused(posed("position: [0, 0, 0]\n"), {"orientation"}));
  EXPECT_TRUE(refused(posed("position: [0, 0, 0]\norientation: [0, 0, 0, 1]\npose: 1\n"),
                      {"pose", "unknown"}));
  const std::string small = dir_.write(
      "small.yaml",
      "image_width: 600\nimage_height: 500\ncamera_name: drawn\n"
      "camera_matrix: {rows: 3, cols: 3, data: [850.0, 0, 302.1, 0, 848.0, 246.4, 0, 0, 1]}\n"
      "distortion_model: plumb_bob\n"
      "distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}\n");
  EXPECT_TRUE(refused(first_ + " --view " + picture + " " + small + " " + dir_.path("left.yaml"),
                      {"1200 x 1000", "600 x 500"}));
  EXPECT_TRUE(
      refused(first_ + " --view none.png " + camera_ + " " + dir_.path("left.yaml"), {"none.png"}));
  EXPECT_TRUE(refused(first_ + good + " --overlay " + picture, {"left.png", "is what is read"}));
}

}  // namespace
}  // namespace planar_bin_picking
