// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/teach/taught_part.h"

#include "planar_bin_picking/teach/snap.h"
#include "support/dxf_writer.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>

namespace planar_bin_picking {
namespace {

/// 40 x 20 x 3 mm with one hole.
class TaughtPartTest : public testing::Test {
 protected:
  TaughtPartTest() {
    DxfWriter dxf;
    dxf.rectangle(0, 0, 40, 20).circle(10, 10, 3);
    dir_.write("plate.dxf", dxf.text());
  }

  std::string write(const std::string& poses) {
    return dir_.write("plate.yaml",
                      "drawing: plate.dxf\nthickness_mm: 3\n# by hand\npick_poses:\n" + poses);
  }
  std::string content(const std::string& name) const {
    std::ifstream in(dir_.path(name));
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }

  TempDir dir_;
};

const char kCup[] =
    "  - {name: cup, face: front, position_mm: [30, 10, 0], rpy_deg: [180, 0, 0]}\n";

Eigen::Vector3d mm(const PickPose& pose) { return 1e3 * pose.T_part_pick.translation(); }
Eigen::Vector3d zOf(const PickPose& pose) { return pose.T_part_pick.linear().col(2); }

TEST_F(TaughtPartTest, PosesAreAddedWhereTheToolCanGo) {
  TaughtPart taught(write(kCup));
  EXPECT_EQ(taught.add(Face::kFront, std::nullopt), "front");
  EXPECT_EQ(taught.add(Face::kBack, Eigen::Vector2d(0.02, 0.005)), "back");
  EXPECT_EQ(taught.add(Face::kBack, std::nullopt), "back_2");
  // The hole's 28.3 mm2 at x = 10 are missing.
  EXPECT_TRUE(mm(taught.pose("front")).isApprox(Eigen::Vector3d(20.366, 10, 0), 1e-4));
  EXPECT_TRUE(mm(taught.pose("back")).isApprox(Eigen::Vector3d(20, 5, -3), 1e-9));
  for (const PickPose& pose : taught.poses()) EXPECT_EQ(taught.faultOf(pose), "") << pose.name;
  EXPECT_TRUE(taught.isChanged());
  taught.remove("back");
  EXPECT_EQ(taught.poses().size(), 3u);
  EXPECT_TRUE(refuses([&] { taught.pose("back"); }, {"plate", "back"}));
  taught.readAnew();
  EXPECT_EQ(taught.poses().size(), 1u);
  EXPECT_FALSE(taught.isChanged());
}

TEST_F(TaughtPartTest, WhatIsWrongIsSaid) {
  TaughtPart taught(write(kCup));
  PickPose pose = taught.pose("cup");
  const auto fault = [&](double x_mm, double z_mm) {
    pose.T_part_pick.translation() = Eigen::Vector3d(1e-3 * x_mm, 0.01, 1e-3 * z_mm);
    return taught.faultOf(pose);
  };
  EXPECT_EQ(fault(30, 0), "");
  EXPECT_NE(fault(10, 0).find("lies over a hole"), std::string::npos);
  EXPECT_NE(fault(50, 0).find("lies outside"), std::string::npos);
  EXPECT_NE(fault(30, -3).find("far face"), std::string::npos);
  pose.face = FaceFilter::kBack;
  EXPECT_NE(fault(30, 0).find("does not point into the part"), std::string::npos);
  // And is not written.
  taught.change(pose);
  EXPECT_TRUE(refuses([&] { taught.save(); }, {"nothing is saved", "cup", "snap"}));
  EXPECT_EQ(content("plate.yaml").find("face: back"), std::string::npos);
}

TEST_F(TaughtPartTest, AFileWithAWrongPoseCanBeMended) {
  const std::string path = write("  - {name: cup, face: front, position_mm: [30, 10, 0]}\n");
  EXPECT_TRUE(refuses([&] { loadPartFile(path); }, {"cup"}));
  TaughtPart taught(path);
  EXPECT_NE(taught.faultOf(taught.pose("cup")), "");
  taught.change(snappedToNormal(taught.pose("cup"), 0.003));
  EXPECT_NE(taught.save().find("1 pick pose written"), std::string::npos);
  EXPECT_TRUE(zOf(loadPartFile(path).pick_poses[0]).isApprox(-Eigen::Vector3d::UnitZ(), 1e-6));
}

TEST_F(TaughtPartTest, SavingChangesThePosesAlone) {
  const std::string path = write(kCup), before = content("plate.yaml");
  ASSERT_EQ(chmod(path.c_str(), 0664), 0);
  TaughtPart taught(path);
  EXPECT_NE(taught.save().find("already"), std::string::npos);
  PickPose pose = taught.pose("cup");
  pose.T_part_pick.translation().x() = 0.009;
  taught.change(pose);
  taught.add(Face::kBack, std::nullopt);
  taught.prefer("back");
  EXPECT_EQ(taught.poses().front().name, "back");
  EXPECT_THROW(taught.prefer("back"), std::invalid_argument);
  taught.prefer("cup");
  const std::string said = taught.save();
  EXPECT_NE(said.find("look at cup"), std::string::npos) << said;  // over the hole, as a pin goes
  EXPECT_FALSE(taught.isChanged());
  EXPECT_EQ(content("plate.yaml.before"), before);
  EXPECT_EQ(content("plate.yaml").substr(0, 60), before.substr(0, 60));
  const auto read = loadPartFile(path).pick_poses;
  ASSERT_EQ(read.size(), 2u);
  EXPECT_TRUE(mm(read[0]).isApprox(Eigen::Vector3d(9, 10, 0), 1e-6));
  EXPECT_EQ(read[1].name, "back");
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0664u);
}

TEST_F(TaughtPartTest, PosesAreRenamed) {
  const std::string path =
      write(std::string(kCup) + "  - {name: pin, face: back, position_mm: [30, 10, -3]}\n");
  TaughtPart taught(path);
  for (const char* wrong : {"", "a b", "a/b", "a@2"})
    EXPECT_TRUE(refuses([&] { taught.rename("cup", wrong); }, {"cup", "a word without @ and /"}));
  EXPECT_TRUE(refuses([&] { taught.rename("cup", "pin"); }, {"a pick pose pin already"}));
  EXPECT_TRUE(refuses([&] { taught.rename("none", "pin"); }, {"no pick pose none"}));
  taught.rename("cup", "other");
  taught.rename("pin", "cup");
  taught.rename("other", "pin");
  EXPECT_EQ(taught.add(Face::kFront, std::nullopt), "front");
  taught.rename("front", "suction");
  taught.save();
  const std::string before = content("plate.yaml.before");
  std::string expected = before;
  expected.replace(expected.find("name: cup"), 9, "name: tmp");
  expected.replace(expected.find("name: pin"), 9, "name: cup");
  expected.replace(expected.find("name: tmp"), 9, "name: pin");
  EXPECT_EQ(content("plate.yaml").substr(0, expected.size()), expected);
  EXPECT_EQ(loadPartFile(path).pick_poses.back().name, "suction");
  // There and back again is no change; a name whose pose was deleted is free once that is saved.
  taught.rename("pin", "tip");
  taught.rename("tip", "pin");
  EXPECT_FALSE(taught.isChanged());
  taught.remove("pin");
  EXPECT_TRUE(refuses([&] { taught.rename("cup", "pin"); }, {"pin that was deleted; save first"}));
  taught.save();
  taught.rename("cup", "pin");
  taught.save();
  EXPECT_EQ(loadPartFile(path).pick_poses.front().name, "pin");
}

TEST_F(TaughtPartTest, ADrawingAloneGetsAPartFile) {
  TaughtPart taught(findPart("plate", dir_.path("")));
  taught.add(Face::kFront, std::nullopt);
  taught.save();
  EXPECT_EQ(loadPartFile(dir_.path("plate.dxf")).pick_poses.size(), 1u);
  taught.add(Face::kFront, std::nullopt);
  taught.save();
  EXPECT_EQ(loadPartFile(dir_.path("plate.yaml")).pick_poses.size(), 2u);
  EXPECT_EQ(findPart("plate", dir_.path("")), dir_.path("plate.yaml"));
  EXPECT_EQ(findPart("./plate.dxf", "elsewhere"), "./plate.dxf");
  EXPECT_TRUE(refuses([&] { findPart("plat", dir_.path("")); }, {"no part 'plat'"}));
}

TEST_F(TaughtPartTest, WhatOthersWroteMeanwhileIsNotLost) {
  const std::string path = write(kCup);
  TaughtPart taught(path);
  taught.add(Face::kBack, std::nullopt);
  write(std::string(kCup) + "tool_radius_mm: 4\n");  // not about poses
  taught.save();
  EXPECT_DOUBLE_EQ(loadPartFile(path).tool.radius.value_or(0.0), 4e-3);
  taught.add(Face::kBack, std::nullopt);
  const std::string other = "  - {name: theirs, face: back, position_mm: [30, 10, -3]}\n";
  write(other);
  EXPECT_TRUE(
      refuses([&] { taught.save(); }, {"meanwhile", "nothing is saved", "read the file anew"}));
  EXPECT_NE(content("plate.yaml").find("theirs"), std::string::npos);
  TaughtPart alone((std::filesystem::remove(path), dir_.path("plate.dxf")));
  alone.add(Face::kBack, std::nullopt);
  write(other);
  EXPECT_TRUE(refuses([&] { alone.save(); }, {"has come meanwhile"}));
}

TEST(Snap, EachMoveLeavesTheRestAlone) {
  PickPose pose;
  pose.face = FaceFilter::kFront;
  pose.T_part_pick = Eigen::Translation3d(0.01, 0.02, 0.005) *
                     Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX()) *
                     Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  const PickPose upright = snappedToNormal(pose, 0.003);
  EXPECT_TRUE(zOf(upright).isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  // Along the tool's axis onto the face: 5 mm up, tan(0.3) of them aside.
  EXPECT_TRUE(upright.T_part_pick.translation().isApprox(
      Eigen::Vector3d(0.01 + 0.005 * std::tan(0.3), 0.02, 0.0), 1e-9));
  // The least turn leaves the axis about which it turns.
  EXPECT_TRUE(upright.T_part_pick.linear().col(1).isApprox(pose.T_part_pick.linear().col(1), 1e-9));

  const PickPose back = forOtherFace(upright, 0.003);
  EXPECT_EQ(back.face, FaceFilter::kBack);
  EXPECT_TRUE(zOf(back).isApprox(Eigen::Vector3d::UnitZ(), 1e-12));
  EXPECT_NEAR(back.T_part_pick.translation().z(), -0.003, 1e-12);
  EXPECT_TRUE(
      isometryNear(forOtherFace(back, 0.003).T_part_pick, upright.T_part_pick, 1e-12, 1e-7));
  // A gripper 1 mm below the front is 1 mm below the back.
  PickPose deep = upright;
  deep.T_part_pick.translation().z() = -0.001;
  EXPECT_NEAR(forOtherFace(deep, 0.003).T_part_pick.translation().z(), -0.002, 1e-12);

  const PickPose quarter = turned(upright, EIGEN_PI / 2);
  EXPECT_TRUE(zOf(quarter).isApprox(zOf(upright), 1e-12));
  EXPECT_NEAR(quarter.T_part_pick.linear().col(0).dot(upright.T_part_pick.linear().col(1)), 1.0,
              1e-9);
  // A tool that lies flat stands up where it is.
  PickPose flat = pose;
  flat.T_part_pick.linear() =
      Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_TRUE(snappedToNormal(flat, 0.003)
                  .T_part_pick.translation()
                  .isApprox(Eigen::Vector3d(0.01, 0.02, 0), 1e-9));
}

TEST_F(TaughtPartTest, SnapsToHoles) {
  TaughtPart taught(write(kCup));
  const Drawing& drawing = taught.part().file().drawing;
  const auto pin = snappedToHole(taught.pose("cup"), drawing);
  ASSERT_TRUE(pin.has_value());
  EXPECT_TRUE(mm(*pin).isApprox(Eigen::Vector3d(10, 10, 0), 1e-6));
  Drawing solid = drawing;
  solid.loops.resize(1);
  EXPECT_FALSE(snappedToHole(taught.pose("cup"), solid).has_value());
  EXPECT_TRUE(
      mm(snappedToCentroid(taught.pose("cup"), solid)).isApprox(Eigen::Vector3d(20, 10, 0), 1e-9));
}

}  // namespace
}  // namespace planar_bin_picking
