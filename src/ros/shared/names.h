// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Every topic, service and parameter name of the nodes. Remap them in launch files.

namespace planar_bin_picking_ros {

// Public, below the node's namespace. The camera_info topic is the sibling of the image.
constexpr char kImageTopic[] = "camera/image_raw";
constexpr char kClickedPointTopic[] = "clicked_point";  // rviz's tool Publish Point

// Private, below the node's name.
constexpr char kLocatePartService[] = "locate_part";
constexpr char kReportPickService[] = "report_pick";
constexpr char kParametersService[] = "parameters";
constexpr char kSaveSnapshotService[] = "save_snapshot";
constexpr char kListPartsService[] = "list_parts";
constexpr char kReloadPartsService[] = "reload_parts";
constexpr char kRefinePartService[] = "refine_part";
constexpr char kNextViewService[] = "next_view";
constexpr char kLocatedPartsTopic[] = "located_parts";
constexpr char kMarkersTopic[] = "markers";
constexpr char kOverlayTopic[] = "overlay";
constexpr char kLocateBinService[] = "locate_bin";
constexpr char kBinTopic[] = "bin";
constexpr char kSceneTopic[] = "scene";
constexpr char kSaveRegionService[] = "save_region";
constexpr char kClearRegionService[] = "clear_region";
constexpr char kHdrImageTopic[] = "image_raw";
constexpr char kTakeService[] = "take";

// The calibrator's, below the node's name; the robot's service below the node's namespace.
constexpr char kMoveRobotService[] = "move_robot";
constexpr char kStartService[] = "start";
constexpr char kAbortService[] = "abort";
constexpr char kNextService[] = "next";
constexpr char kPlanService[] = "plan";
constexpr char kAddSampleService[] = "add_sample";
constexpr char kRemoveSampleService[] = "remove_sample";
constexpr char kListSamplesService[] = "list_samples";
constexpr char kLoadSamplesService[] = "load_samples";
constexpr char kAddViewsService[] = "add_views";
constexpr char kVerifyService[] = "verify";
constexpr char kFinishService[] = "finish";
constexpr char kStatusTopic[] = "status";
constexpr char kPlanTopic[] = "plan_markers";

// Private parameter trees; nothing else is read.
constexpr char kLocatorParams[] = "locator";
constexpr char kCellParams[] = "cell";
constexpr char kHdrParams[] = "hdr";
constexpr char kPickParams[] = "pick";
constexpr char kCalibratorParams[] = "calibrator";

// Public: what frames a locator has put on tf, so that its next process can withdraw them. The
// node's name follows.
constexpr char kPublishedFramesParam[] = "/planar_bin_picking/published_frames/";

/// Hz; how often the parts' frames are sent on /tf.
constexpr double kFrameRate = 10.0;

/// Parent of the frames of parts that are not, or no longer, offered. It hangs on nothing, so that
/// looking such a part up fails instead of answering with where it once was.
constexpr char kNotLocatedFrame[] = "planar_bin_picking/not_located";

}  // namespace planar_bin_picking_ros
