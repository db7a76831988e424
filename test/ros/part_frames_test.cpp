// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "part_frames.h"

#include "names.h"

#include <gtest/gtest.h>
#include <tf2/buffer_core.h>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::LocatedPart;

/// What an answer does to tf, as a listener sees it.
class PartFramesTest : public testing::Test {
 protected:
  /// @param picks  names of the pick poses that each part has
  void answer(const std::vector<std::string>& asked_for, const std::vector<std::string>& found,
              const std::vector<std::string>& picks = {}) {
    std::vector<LocatedPart> located;
    for (const std::string& part : found) {
      located.emplace_back();
      located.back().part = part;
      located.back().pose.pose.position.x = x_;
      located.back().pose.pose.orientation.w = 1.0;
      for (const std::string& pick : picks) {
        located.back().picks.emplace_back();
        located.back().picks.back().name = pick;
        located.back().picks.back().pose = located.back().pose.pose;
        located.back().picks.back().pose.position.y = 0.03;
      }
    }
    frames_.name(located);
    std_msgs::Header header;
    header.frame_id = "base";
    for (const auto& transform : frames_.update(asked_for, header, located)) {
      buffer_.setTransform(transform, "test", /*is_static=*/true);
    }
  }

  bool stands(const std::string& frame) const {
    return buffer_.canTransform("base", frame, ros::Time(5.0));
  }

  double x_ = 0.1;
  PartFrames frames_{"left_"};
  tf2::BufferCore buffer_;
};

TEST_F(PartFramesTest, NamedByRankWithinEachPart) {
  answer({"bracket", "gasket"}, {"bracket", "gasket", "bracket"});
  EXPECT_TRUE(stands("left_bracket_1"));
  EXPECT_TRUE(stands("left_bracket_2"));
  EXPECT_TRUE(stands("left_gasket_1"));
  EXPECT_FALSE(stands("left_gasket_2"));
}

TEST_F(PartFramesTest, LostPartsCannotBeLookedUp) {
  answer({"bracket"}, {"bracket", "bracket"});
  answer({"bracket"}, {"bracket"});
  EXPECT_TRUE(stands("left_bracket_1"));
  EXPECT_FALSE(stands("left_bracket_2"));
  answer({"bracket"}, {});
  EXPECT_FALSE(stands("left_bracket_1"));
}

TEST_F(PartFramesTest, LostPartsCanComeBack) {
  answer({"bracket"}, {"bracket"});
  answer({"bracket"}, {});
  x_ = 0.7;
  answer({"bracket"}, {"bracket"});
  ASSERT_TRUE(stands("left_bracket_1"));
  const auto found = buffer_.lookupTransform("base", "left_bracket_1", ros::Time(5.0));
  EXPECT_EQ(found.transform.translation.x, 0.7);
}

TEST_F(PartFramesTest, PickPosesHangBelowTheirPart) {
  answer({"bracket"}, {"bracket", "bracket"}, {"web", "web@2"});
  ASSERT_TRUE(stands("left_bracket_2/web@2"));
  const auto in_base = buffer_.lookupTransform("base", "left_bracket_1/web", ros::Time(5.0));
  EXPECT_NEAR(in_base.transform.translation.x, 0.1, 1e-12);
  EXPECT_NEAR(in_base.transform.translation.y, 0.03, 1e-12);
  const auto in_part =
      buffer_.lookupTransform("left_bracket_1", "left_bracket_1/web", ros::Time(5.0));
  EXPECT_NEAR(in_part.transform.translation.x, 0.0, 1e-12);
}

TEST_F(PartFramesTest, PickPosesThatAreNotOfferedCannotBeLookedUp) {
  answer({"bracket"}, {"bracket", "bracket"}, {"web", "web@2"});
  answer({"bracket"}, {"bracket"}, {"web@2"});
  EXPECT_FALSE(stands("left_bracket_1/web"));
  EXPECT_TRUE(stands("left_bracket_1/web@2"));
  EXPECT_FALSE(stands("left_bracket_2/web@2"));
  answer({"gasket"}, {});
  EXPECT_TRUE(stands("left_bracket_1/web@2"));
  answer({"bracket"}, {"bracket"}, {"web"});
  EXPECT_TRUE(stands("left_bracket_1/web"));
}

TEST_F(PartFramesTest, OtherPartsStay) {
  answer({"bracket"}, {"bracket"});
  answer({"gasket"}, {});
  EXPECT_TRUE(stands("left_bracket_1"));
}

}  // namespace
}  // namespace planar_bin_picking_ros
