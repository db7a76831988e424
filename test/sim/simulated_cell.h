// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A bin of parts, a camera that looks at it and a suction cup that takes parts out. No ROS.
///
/// Frame `base`: z up, origin in the middle of the bin's floor. The tool's frame has its origin at
/// the rim of the cup and its z along the stroke, into the part. Same configuration, same calls:
/// the same pictures and the same heaps to the last bit.

#include "sim/heap.h"
#include "sim/picture.h"

#include <memory>
#include <string>
#include <vector>

namespace planar_bin_picking::cell {

/// A kind of part in the bin. The file is the user's own yaml: drawing, thickness_mm, and
/// pick_poses, of which the cell needs the places where the cup may go.
struct PartKind {
  std::string name;
  Shape fine;                           ///< to look at
  Shape coarse;                         ///< to collide with
  std::vector<Eigen::Vector2d> grasps;  ///< part frame, symmetric copies included
  std::vector<Eigen::Isometry3d>
      symmetric_poses;  ///< T_part_same: poses that look the same, identity first
  /// The same where the back is up: it has no print that could tell them apart.
  std::vector<Eigen::Isometry3d> back_symmetric_poses;
};

/// @throws std::runtime_error  unreadable, or without a drawing, thickness or pick pose
PartKind loadPartKind(const std::string& yaml_path);

struct Suction {
  double radius = 0.006;          ///< of the cup, metres
  double tool_radius = 0.012;     ///< of the tool above it, metres
  double tool_length = 0.30;      ///< metres
  double lateral_max = 0.0015;    ///< off the grasp point, metres
  double depth_max = 0.005;       ///< that the cup's bellows take up, metres
  double tilt_max_deg = 5.0;      ///< against the part's face
  double unevenness_max = 0.001;  ///< of what is below the cup, metres
  double load_max = 0.8;          ///< weight on the part, in units of its own
};

enum class PickResult {
  kPicked,
  kWall,     ///< the tool touches the bin; it stops and nothing moves
  kNothing,  ///< there is no part below the cup
  kLateral,  ///< off the grasp point
  kAbove,    ///< the cup hangs above the part; nothing moves
  kDepth,    ///< runs into the part
  kTilt,     ///< the cup does not lie flat
  kCovered,  ///< something else or a hole is below the cup's rim, or in the tool's way
  kLoaded,   ///< too much lies on the part
};
const char* nameOf(PickResult result);

struct TruePart {
  int id = 0;
  int kind = 0;
  bool front_up = true;
  double visible_fraction = 0.0;  ///< of the face that is up, from the camera
  Eigen::Isometry3d T_base_part = Eigen::Isometry3d::Identity();
};

/// Of a camera so high over the bin's floor that looks straight down: the bin's upper rim fills the
/// picture, 1280 x 1024 pixels or, from 3 megapixels on, 2448 x 2048.
Lens lensOver(const Bin& bin, double height, double megapixels);

struct CellConfig {
  Bin bin;
  Lens lens;
  Sensor sensor;
  Suction suction;
  std::string light = "diffuse";    ///< see makeLamps
  std::string material = "rolled";  ///< of the parts, see material()
  std::vector<int> counts;          ///< how many of each kind
  std::uint64_t seed = 1;
};

class SimulatedCell {
 public:
  SimulatedCell(const CellConfig& config, std::vector<PartKind> kinds);
  ~SimulatedCell();

  /// Empties the bin and pours anew.
  void refill(std::uint64_t seed);

  /// 8 bit. Each picture has noise of its own.
  cv::Mat takePicture(const Eigen::Isometry3d& T_base_camera, double exposure_seconds);
  /// The exposure at which few pixels saturate, seconds.
  double exposureFor(const Eigen::Isometry3d& T_base_camera) const;

  /// Lowers the tool to this pose and sucks. A part that is picked is gone, and the heap settles; a
  /// failure may move parts.
  PickResult pick(const Eigen::Isometry3d& T_base_tool);

  /// Whether the tool can be there without touching the bin's walls or floor.
  bool toolIsFree(const Eigen::Isometry3d& T_base_tool) const;

  std::vector<TruePart> truth(const Eigen::Isometry3d& T_base_camera) const;
  const PartKind& kind(int index) const { return kinds_.at(static_cast<std::size_t>(index)); }
  const CellConfig& config() const { return config_; }
  Heap& heap() { return *heap_; }
  /// After the heap was changed from outside.
  void update();

 private:
  PickResult judge(const Eigen::Isometry3d& T_base_tool, int* id) const;
  double visibleFraction(std::size_t body, bool front_up, const Eigen::Vector3d& eye) const;

  CellConfig config_;
  std::vector<PartKind> kinds_;
  Eye eye_;
  Raycaster world_;
  std::unique_ptr<Heap> heap_;
  std::vector<Body> bodies_;        ///< as in the raycaster
  std::vector<PrintImage> prints_;  ///< by kind
  Looks looks_;
  std::uint64_t pictures_ = 0, failures_ = 0;
};

}  // namespace planar_bin_picking::cell
