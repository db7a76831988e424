// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The cell's region in force: what its file says, or what was taught by points that somebody
/// clicked in rviz, or by handles that were dragged there. Neither changes anything until
/// ~save_region; ~clear_region forgets them, or else what was taught. Any number of threads.

#include "locator/answer/scene_publisher.h"
#include "locator/region/region_handles.h"
#include "planar_bin_picking/bin/region.h"
#include "shared/transforms.h"

#include <geometry_msgs/PointStamped.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <mutex>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class RegionKeeper {
 public:
  /// As in CellParams.
  struct Settings {
    std::vector<double> region, region_px;
    std::string frame, file;
    double tf_timeout = 0.0;
    /// What the handles begin with where there is no region: the bin's floor.
    planar_bin_picking::RegionOutline floor;
    /// Where the region's own frame is now, as seen from `frame`: a bin may have been found
    /// elsewhere, and its region goes with it.
    std::function<Eigen::Isometry3d()> T_frame_region;
  };

  /// @param prompt_nh   the node's namespace; its callback queue takes in points
  /// @param prompt_pnh  the node's own; its callback queue serves
  /// @param scene       shows the region; outlives it
  /// @throws std::exception  the file cannot be read, or is of another frame
  RegionKeeper(Settings settings, const TransformBuffer& buffer, const ros::NodeHandle& prompt_nh,
               const ros::NodeHandle& prompt_pnh, ScenePublisher& scene);

  planar_bin_picking::Region current() const;
  void redraw();  ///< the bin stands elsewhere

 private:
  using Request = std_srvs::Trigger::Request;
  using Response = std_srvs::Trigger::Response;

  void take(const geometry_msgs::PointStamped& point);
  /// What is done with the handles; on the prompt queue.
  RegionHandles::Actions actions();
  /// Edits what the handles stand at, where it still has that corner.
  void change(std::size_t corner,
              const std::function<void(planar_bin_picking::RegionOutline* corners)>& edit,
              bool with_handles = true);
  /// Whether nothing has been changed yet, and that would not change anything: a click on a handle.
  bool isStill(std::size_t corner, const Eigen::Vector2d& place) const;
  std::string saveTaught(bool* is_saved);
  std::string forgetTaught(bool* is_done);
  bool save(Request& request, Response& response);
  bool clear(Request& request, Response& response);
  /// All under mutex_.
  void show(bool with_handles = true);
  /// What the handles stand at.
  const planar_bin_picking::RegionOutline& corners() const;

  const Settings settings_;
  const TransformBuffer& buffer_;
  ScenePublisher& scene_;
  mutable std::mutex mutex_;
  planar_bin_picking::Region region_;
  planar_bin_picking::RegionOutline points_;  ///< clicked or dragged, and not saved yet
  RegionHandles handles_;
  ros::Subscriber points_in_;
  ros::ServiceServer save_service_, clear_service_;
};

}  // namespace planar_bin_picking_ros
