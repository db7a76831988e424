// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The locator as a ROS node: waits for images, answers LocatePart, publishes what it found, and
/// takes in with ReportPick what came of it. The nodelet and the node are two shells around it.
///
/// Calls wait and compute in threads of their own, beside the one that takes in images and the one
/// for what is done at once (reports, tf frames), so that a waiting call keeps neither an image nor
/// another call from coming in, however few worker threads a nodelet manager has.

#include "input/image_source.h"
#include "locator/answer/answer_publisher.h"
#include "locator/answer/scene_publisher.h"
#include "locator/bin_range.h"
#include "locator/cell_frames.h"
#include "locator/health/health.h"
#include "locator/parts/part_services.h"
#include "locator/pick_keeper.h"
#include "locator/region/region_keeper.h"
#include "locator/settings/cell_params.h"
#include "locator/settings/tuning.h"
#include "locator/snapshot/snapshot_keeper.h"
#include "locator/view_services.h"
#include "shared/transform_listener.h"

#include <planar_bin_picking/LocatePart.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking_ros {

class LocatorRos {
 public:
  /// @throws std::exception  a parameter or the parts folder is wrong: which one and why
  LocatorRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);
  ~LocatorRos();
  LocatorRos(const LocatorRos&) = delete;
  LocatorRos& operator=(const LocatorRos&) = delete;

 private:
  using Request = planar_bin_picking::LocatePart::Request;
  using Response = planar_bin_picking::LocatePart::Response;
  class Stopwatch;

  template <class Service>
  using Event = ros::ServiceEvent<typename Service::Request, typename Service::Response>;

  bool serve(Event<planar_bin_picking::LocatePart>& event);
  bool serveReport(Event<planar_bin_picking::ReportPick>& event);
  /// The steps of a call. @throws Refusal  there is no answer
  void answer(const std::string& caller, const Request& request, Response& response);

  /// One at a time: a call uses all cores anyway, and two would need twice the memory.
  void locate(const planar_bin_picking::LocatorParams& params,
              const planar_bin_picking::LocateRequest& request, Stopwatch* watch, Answer* answer);
  PickKeeper::Offered offer(Answer answer, const PickKeeper::Frames& frames,
                            const PickKeeper::Call& call);
  RegionKeeper::Settings regionSettings() const;
  PictureHost pictureHost();
  ViewServices::Host viewHost();
  BinFinder::Host binHost();
  Frame awaitImage(const ros::Time& not_before, const ros::Duration& timeout);
  Frame awaitFrame(const Request& request);
  /// As the file says, where there is one, or else as its camera_info. @throws Refusal
  planar_bin_picking::Camera cameraOf(const Frame& frame) const;
  void showCell(const CellParams& cell);  ///< bin and plane in rviz
  /// Camera, bin and region as a call's picture has them, in rviz and in the overlay.
  /// @param distance  up to which the camera looks, metres
  void show(const CellParams& cell, const Standing& standing, const SeenRegion& region,
            double distance, Answer* answer);
  /// Asks for an image where images do not come of themselves. @throws Refusal  NO_IMAGE
  void trigger();

  const Settings start_;
  const CellParams& cell_;  ///< as at the start: for all but what may be tuned
  const std::optional<planar_bin_picking::Camera> camera_;  ///< of camera_info_file
  PartStore parts_;

  ros::CallbackQueue image_queue_, call_queue_, prompt_queue_;
  ros::NodeHandle image_nh_, call_pnh_, prompt_pnh_;
  TransformBuffer tf_buffer_;
  TransformListener tf_listener_;  // has a thread of its own
  CellFrames cell_frames_;
  ImageSource source_;
  AnswerPublisher publisher_;
  ScenePublisher scene_;
  Tuning tuning_;
  RegionKeeper region_;
  PickKeeper picks_;
  PartServices part_services_;
  SnapshotKeeper snapshots_;
  Health health_;
  std::mutex locate_mutex_;
  BinFinder bin_;
  ViewServices views_;
  ros::ServiceServer service_, report_service_;
  ros::AsyncSpinner image_spinner_, call_spinner_, prompt_spinner_;
};

}  // namespace planar_bin_picking_ros
