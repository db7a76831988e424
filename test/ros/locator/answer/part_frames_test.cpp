// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/answer/part_frames.h"

#include "shared/names.h"

#include <gtest/gtest.h>
#include <tf2/buffer_core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace planar_bin_picking_ros {
namespace {

using planar_bin_picking::LocatedPart;

/// What answers do to tf, as a listener sees it that was there all the time.
class PartFramesTest : public testing::Test {
 protected:
  static std::vector<LocatedPart> partsOf(const std::vector<std::string>& found,
                                          const std::vector<std::string>& picks, double x) {
    std::vector<LocatedPart> located;
    for (const std::string& part : found) {
      located.emplace_back();
      located.back().part = part;
      located.back().pose.pose.position.x = x;
      located.back().pose.pose.orientation.w = 1.0;
      for (const std::string& pick : picks) {
        located.back().picks.emplace_back();
        located.back().picks.back().name = pick;
        located.back().picks.back().pose = located.back().pose.pose;
        located.back().picks.back().pose.position.y = 0.03;
      }
    }
    return located;
  }

  void send(const PartFrames::Transforms& transforms) {
    for (const auto& transform : transforms) {
      EXPECT_TRUE(sent_.emplace(transform.child_frame_id, transform.header.stamp).second)
          << transform.child_frame_id << " twice at " << transform.header.stamp;
      EXPECT_TRUE(buffer_.setTransform(transform, "test"));
    }
  }

  void tick(double seconds = 0.1) {
    now_ += seconds;
    send(frames_.at(ros::Time(now_)));
  }

  /// A call that begins, takes its image, and ends.
  void answer(const std::vector<std::string>& asked_for, const std::vector<std::string>& found,
              const std::vector<std::string>& picks = {}) {
    frames_.withdraw(asked_for);
    tick(0.01);
    std_msgs::Header header;
    header.frame_id = "base";
    image_ = now_ += 0.04;
    header.stamp = ros::Time(image_);
    tick();
    auto located = partsOf(found, picks, x_);
    frames_.name(located);
    frames_.withdraw(asked_for);
    send(frames_.show(header, located));
    tick();
  }

  bool stands(const std::string& frame, double time = 0.0) const {
    return buffer_.canTransform("base", frame, ros::Time(time));
  }
  double xOf(const std::string& frame, double time = 0.0) const {
    return buffer_.lookupTransform("base", frame, ros::Time(time)).transform.translation.x;
  }

  double x_ = 0.1, now_ = 100.0, image_ = 0.0;
  PartFrames frames_{"left_"};
  tf2::BufferCore buffer_;
  std::set<std::pair<std::string, ros::Time>> sent_;
};

TEST_F(PartFramesTest, NamedByRankWithinEachPart) {
  answer({"bracket", "gasket"}, {"bracket", "gasket", "bracket"});
  EXPECT_TRUE(stands("left_bracket_1"));
  EXPECT_TRUE(stands("left_bracket_2"));
  EXPECT_TRUE(stands("left_gasket_1"));
  EXPECT_FALSE(stands("left_gasket_2"));
}

TEST_F(PartFramesTest, StandAtTheImagesStampAndFromThenOn) {
  answer({"bracket"}, {"bracket"}, {"web"});
  EXPECT_EQ(xOf("left_bracket_1", image_), 0.1);
  EXPECT_TRUE(stands("left_bracket_1/web", image_));
  for (int i = 0; i < 50; ++i) tick();
  EXPECT_EQ(xOf("left_bracket_1", now_), 0.1);
  EXPECT_EQ(xOf("left_bracket_1/web", now_ - 0.05), 0.1);
}

TEST_F(PartFramesTest, LostPartsCannotBeLookedUp) {
  answer({"bracket"}, {"bracket", "bracket"});
  answer({"bracket"}, {"bracket"});
  EXPECT_TRUE(stands("left_bracket_1"));
  EXPECT_FALSE(stands("left_bracket_2"));
  answer({"bracket"}, {});
  EXPECT_FALSE(stands("left_bracket_1"));
}

// A call that fails gives no answer, and the former one no longer holds from its beginning on.
TEST_F(PartFramesTest, ACallThatBeginsWithdrawsWhatWasSaidBefore) {
  answer({"bracket"}, {"bracket"}, {"web"});
  frames_.withdraw({"bracket"});
  tick();
  EXPECT_FALSE(stands("left_bracket_1"));
  EXPECT_FALSE(stands("left_bracket_1/web"));
  EXPECT_FALSE(stands("left_bracket_1", now_));
}

TEST_F(PartFramesTest, LostPartsCanComeBack) {
  answer({"bracket"}, {"bracket"});
  answer({"bracket"}, {});
  x_ = 0.7;
  answer({"bracket"}, {"bracket"});
  EXPECT_EQ(xOf("left_bracket_1"), 0.7);
  EXPECT_EQ(xOf("left_bracket_1", image_), 0.7);
}

// tf2 draws a line between two samples: none may lead from one answer's part to another's.
TEST_F(PartFramesTest, NothingLiesBetweenTwoAnswers) {
  answer({"bracket"}, {"bracket"});
  const double first = image_;
  x_ = 0.7;
  answer({"bracket"}, {"bracket"});
  for (double time = first; time < now_; time += 0.003) {
    if (!stands("left_bracket_1", time)) continue;
    const double x = xOf("left_bracket_1", time);
    EXPECT_LT(std::min(std::abs(x - 0.1), std::abs(x - 0.7)), 1e-9) << time;
  }
  // The same for an image that is older than what was sent last.
  for (int i = 0; i < 5; ++i) tick();
  x_ = 0.3;
  auto located = partsOf({"bracket"}, {}, x_);
  frames_.withdraw({"bracket"});
  frames_.name(located);
  std_msgs::Header header;
  header.frame_id = "base";
  header.stamp = ros::Time(now_ - 0.25);
  send(frames_.show(header, located));
  EXPECT_EQ(xOf("left_bracket_1", now_ - 0.25), 0.3);
  EXPECT_FALSE(stands("left_bracket_1", now_ - 0.23));
  EXPECT_EQ(xOf("left_bracket_1", now_ - 0.27), 0.7);
  tick();
  EXPECT_EQ(xOf("left_bracket_1"), 0.3);
}

TEST_F(PartFramesTest, TwoAnswersToOneImageSendItsStampOnce) {
  answer({"bracket"}, {"bracket"});
  auto located = partsOf({"bracket"}, {}, 0.2);
  frames_.withdraw({"bracket"});
  frames_.name(located);
  std_msgs::Header header;
  header.frame_id = "base";
  header.stamp = ros::Time(image_);
  EXPECT_TRUE(frames_.show(header, located).empty());
  tick();
  EXPECT_EQ(xOf("left_bracket_1"), 0.2);
}

TEST_F(PartFramesTest, PickPosesHangBelowTheirPart) {
  answer({"bracket"}, {"bracket", "bracket"}, {"web", "web@2"});
  ASSERT_TRUE(stands("left_bracket_2/web@2"));
  const auto in_base = buffer_.lookupTransform("base", "left_bracket_1/web", ros::Time());
  EXPECT_NEAR(in_base.transform.translation.x, 0.1, 1e-12);
  EXPECT_NEAR(in_base.transform.translation.y, 0.03, 1e-12);
  const auto in_part = buffer_.lookupTransform("left_bracket_1", "left_bracket_1/web", ros::Time());
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

/// RefinePart: one that was not offered before gets a name that no other part has.
TEST_F(PartFramesTest, APartThatWasLookedAtKeepsItsNameAndOthersStand) {
  answer({"bracket"}, {"bracket", "bracket"}, {"web"});
  frames_.withdrawLocated({"left_bracket_1"});
  tick();
  EXPECT_FALSE(stands("left_bracket_1"));
  EXPECT_FALSE(stands("left_bracket_1/web"));
  EXPECT_TRUE(stands("left_bracket_2/web"));
  auto located = partsOf({"bracket", "bracket"}, {}, 0.2);
  located[1].child_frame = "left_bracket_1";
  frames_.name(located);
  EXPECT_EQ(located[0].child_frame, "left_bracket_3");
  EXPECT_EQ(located[1].child_frame, "left_bracket_1");
}

TEST_F(PartFramesTest, WithdrawsAllAtTheEnd) {
  answer({"bracket", "gasket"}, {"bracket", "gasket"}, {"web"});
  frames_.withdrawAll();
  tick();
  for (const char* frame : {"left_bracket_1", "left_gasket_1", "left_bracket_1/web"})
    EXPECT_FALSE(stands(frame)) << frame;
}

// A listener that was there when a former process sent them.
TEST_F(PartFramesTest, WithdrawsFramesOfAFormerProcess) {
  answer({"bracket"}, {"bracket"}, {"web"});
  const auto former = frames_.names();
  EXPECT_EQ(former, (std::vector<std::string>{"left_bracket_1", "left_bracket_1/web"}));
  frames_ = PartFrames("left_");
  tick();
  EXPECT_TRUE(stands("left_bracket_1"));
  frames_.withdrawFrames(former);
  tick();
  EXPECT_FALSE(stands("left_bracket_1"));
  EXPECT_FALSE(stands("left_bracket_1/web"));
  EXPECT_EQ(frames_.names(), former);  // also for the process after this one
  answer({"bracket"}, {"bracket"});
  EXPECT_TRUE(stands("left_bracket_1"));
}

TEST_F(PartFramesTest, SaysOfLostFramesForTenSeconds) {
  answer({"bracket"}, {"bracket"});
  frames_.withdraw({"bracket"});
  const auto before = sent_.size();
  for (int i = 0; i < 150; ++i) tick();
  EXPECT_EQ(sent_.size() - before, 100u);
  frames_.withdraw({"bracket"});  // lost already
  tick();
  EXPECT_EQ(sent_.size() - before, 100u);
}

TEST_F(PartFramesTest, SendsNoMomentTwice) {
  answer({"bracket"}, {"bracket"});
  EXPECT_TRUE(frames_.at(ros::Time(now_)).empty());
  EXPECT_TRUE(frames_.at(ros::Time(now_ - 1.0)).empty());
  EXPECT_TRUE(frames_.at(ros::Time()).empty());
  frames_.forgetTimes();  // the clock was set back
  EXPECT_EQ(frames_.at(ros::Time(1.0)).size(), 1u);
  EXPECT_TRUE(frames_.at(ros::Time()).empty());
}

TEST(DefaultFramePrefix, TellsLocatorsApart) {
  EXPECT_EQ(defaultFramePrefix("/locator"), "");
  EXPECT_EQ(defaultFramePrefix("/left/locator"), "left/locator/");
  EXPECT_EQ(defaultFramePrefix("/second"), "second/");
}

}  // namespace
}  // namespace planar_bin_picking_ros
