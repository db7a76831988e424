// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A part as its user describes it: a drawing, and optionally a few lines of YAML beside it.

#include "planar_bin_picking/drawing/drawing.h"
#include "planar_bin_picking/part/pick_poses.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// What a part's file tells the robot program besides where the tool goes.
struct RobotHints {
  /// Metres from the contact: before the pick against the pick pose's z, after it straight up;
  /// nothing = not said.
  std::optional<double> approach, retreat;
  int part_number = 0, tool_number = 0;  ///< as the robot program counts; 0 = not said
};

/// Everything a user said about a part.
struct PartFile {
  std::string name;  ///< the stem of the file
  Drawing drawing;
  double thickness = 0.0;            ///< metres; 0 where unknown
  std::vector<PickPose> pick_poses;  ///< in order of preference
  PickTool tool;
  RobotHints robot;
  std::vector<std::string> warnings;  ///< about pick poses; those of the drawing stand in `drawing`
  std::string yaml_path;              ///< its part file; empty where the drawing stands alone
};

/// What becomes of a pick pose whose z does not point into the part: no robot may go there, but who
/// mends it has to see it.
enum class WrongPicks { kRefused, kWarned };

/// A YAML file that has nothing to do with parts, such as a result or a camera's calibration that
/// lies in the parts folder. The text says what it seems to be.
class NoPartFile : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads `<name>.yaml` or `<name>.yml` (keys: drawing, thickness_mm, units, join_tolerance_mm,
/// keep_layers, skip_layers, print_layers, pick_poses, tool_radius_mm, tool_height_mm, approach_mm,
/// retreat_mm, part_number, tool_number) or a drawing
/// alone. A drawing beside which a part file of the same stem lies is read with it. Nothing outside
/// of the folder of `path` is read, whatever links and relative paths say.
/// @throws NoPartFile          YAML that is no part file
/// @throws std::runtime_error  naming file, key, value and remedy: unknown keys, two part files of
///         one stem, what is no regular file, a pick pose whose z does not point into the part
PartFile loadPartFile(const std::string& path, WrongPicks wrong_picks = WrongPicks::kRefused);

/// The pick poses that loadPartFile would read in a part file of this text.
/// @param path  of the file, for messages
/// @throws std::runtime_error  as loadPartFile, but for what the drawing says
std::vector<PickPose> pickPosesIn(const std::string& text, const std::string& path,
                                  WrongPicks wrong_picks = WrongPicks::kRefused);

/// The path of the drawing that a part file names, in the form of lexically_normal(); nothing where
/// it is no part file or cannot be read, which loadPartFile explains.
std::optional<std::string> drawingNamedBy(const std::string& part_file);

}  // namespace planar_bin_picking
