// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The lines that a robot controller and the robot server send each other; no ROS, no socket.
/// doc/robot_server.md has the protocol.

#include "planar_bin_picking/base/types.h"
#include "planar_bin_picking/robot/orientation.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace planar_bin_picking {

/// First number of each answer.
enum class RobotCode : int {
  kPose = 0,       ///< a pose to go to follows
  kNothing = 1,    ///< nothing can be picked now: look again, or see to the bin
  kEmpty = 2,      ///< the bin is empty
  kAgain = 3,      ///< no image or no transform in time: it may help to ask again
  kSetUp = 4,      ///< the cell is not set up as it must be: the text says what to mend
  kBadLine = 5,    ///< the line was not understood, or does not fit here
  kNoLocator = 6,  ///< the locator does not answer
  kDone = 7,       ///< done; no pose belongs to it
};

/// What a controller can say after `calibrate`.
inline constexpr const char* kCalibrateSteps[] = {"plan", "start",  "next",   "abort",
                                                  "add",  "finish", "verify", "status"};

struct RobotCommand {
  enum class Kind { kHello, kLocate, kNext, kReport, kCalibrate };
  Kind kind = Kind::kHello;
  std::vector<std::string> parts;                  ///< of locate; empty = all
  FaceFilter face = FaceFilter::kAny;              ///< of locate
  std::optional<Eigen::Isometry3d> T_base_flange;  ///< of locate: where the robot stands
  bool success = false;                            ///< of report
  std::string step;                                ///< of calibrate: one of kCalibrateSteps
};

/// One line without its end.
/// @throws std::invalid_argument  what is wrong with it and what is known
RobotCommand parseRobotLine(const std::string& line, PoseConvention convention);

/// A pose for the robot and what it belongs to.
struct RobotPose {
  Eigen::Isometry3d T_base_target = Eigen::Isometry3d::Identity();
  std::optional<Eigen::Isometry3d> T_base_approach, T_base_retreat;
  std::optional<std::pair<unsigned, unsigned>> numbers;  ///< of part and tool
  std::size_t left = 0;  ///< parts that are offered besides this one
  Face face = Face::kFront;
  std::string part, pick;
};

/// A line with its end. For UR's controllers, "(0,3,1,...)", which they read into a list; for all
/// others "0 3 1 ... part pick". After the face come the numbers of part and tool, then the poses:
/// to go to, before and after it, as far as there are any.
std::string poseLine(const RobotPose& pose, PoseConvention convention);

/// The same for an answer without a pose; the text becomes one line of plain ASCII. UR's get the
/// number alone, and then zeros: they read a fixed count of numbers, and do not say what they got
/// of fewer.
/// @param count  of numbers in a line with a pose
std::string textLine(RobotCode code, const std::string& text, PoseConvention convention,
                     std::size_t count);

}  // namespace planar_bin_picking
