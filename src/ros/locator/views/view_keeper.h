// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The parts of the latest answers, each with the pictures that its pose rests on, for further
/// looks. Any number of threads.

#include "locator/answer/answer.h"
#include "planar_bin_picking/views/look.h"
#include "planar_bin_picking/views/next_view.h"

#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

/// One located part. Its first view is the frame of its pose.
struct KeptPart {
  std::string child_frame;  ///< empty where it was not offered
  ros::Time stamp;          ///< of the answer that it stood in
  planar_bin_picking::PartPtr part;
  planar_bin_picking::TrackedPart tracked;
  Eigen::Isometry3d T_target_first = Eigen::Isometry3d::Identity();
  planar_bin_picking::Camera camera;  ///< of the first view
  std::optional<planar_bin_picking::ViewBin> bin;
  std::string camera_frame;
};

class ViewKeeper {
 public:
  explicit ViewKeeper(const planar_bin_picking::EdgesParams& params) : params_(params) {}

  /// An answer to LocatePart: what is offered, and what needs another view, in this order.
  /// @param answer   where they were found
  /// @param located  as many as offered, with their frames' names
  void keep(const Answer& answer, const std::vector<planar_bin_picking::Detection>& offered,
            const std::vector<planar_bin_picking::LocatedPart>& located,
            const std::vector<planar_bin_picking::Detection>& needs_view,
            const Eigen::Isometry3d& T_target_camera,
            const std::optional<planar_bin_picking::ViewBin>& bin);
  /// An answer to RefinePart.
  void keep(const std_msgs::Header& header, std::vector<KeptPart> parts);

  /// @param child_frame  empty = the first
  /// @throws Refusal  UNKNOWN_PART
  std::vector<KeptPart> find(const ros::Time& stamp, const std::string& child_frame,
                             std::size_t count);

 private:
  struct Kept {
    std_msgs::Header header;
    std::vector<KeptPart> parts;
    /// Of LocatePart's answers: made into a view once somebody looks again.
    Frame frame;
    cv::Mat grey;
  };
  void push(Kept kept);

  const planar_bin_picking::EdgesParams params_;
  std::mutex mutex_;
  std::list<Kept> kept_;  ///< the latest first
};

}  // namespace planar_bin_picking_ros
