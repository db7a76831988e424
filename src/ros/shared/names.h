// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Every topic, service and parameter name of the nodes. Remap them in launch files.

namespace planar_bin_picking_ros {

// The comment above each name is "type: what it is", of which doc/interface.md is made.

// The locator's, below the node's name; the image is public, below the node's namespace.
/// sensor_msgs/Image: subscribed; its camera_info stands beside it
constexpr char kImageTopic[] = "camera/image_raw";
/// geometry_msgs/PointStamped: subscribed: corners of a region, from rviz's tool Publish Point
constexpr char kClickedPointTopic[] = "clicked_point";
/// planar_bin_picking/LocatePart: where the parts are in the next image
constexpr char kLocatePartService[] = "locate_part";
/// planar_bin_picking/ReportPick: what came of a pick; the next part of the same image
constexpr char kReportPickService[] = "report_pick";
/// sensor_msgs/Image: below it each part as it was read; drawn for whoever subscribes
constexpr char kPartPicturesTopic[] = "part_pictures";
/// planar_bin_picking/RefinePart: one more look at parts that were located
constexpr char kRefinePartService[] = "refine_part";
/// planar_bin_picking/NextView: where the camera should look from next; moves nothing
constexpr char kNextViewService[] = "next_view";
/// planar_bin_picking/ListParts: what was read of each part, or why it was not
constexpr char kListPartsService[] = "list_parts";
/// std_srvs/Trigger: reads all part files anew; no success where one is broken
constexpr char kReloadPartsService[] = "reload_parts";
/// std_srvs/Trigger: saves the latest call
constexpr char kSaveSnapshotService[] = "save_snapshot";
/// std_srvs/Trigger: all parameters in force
constexpr char kParametersService[] = "parameters";
/// std_srvs/Trigger: writes what was tuned into the cell's file
constexpr char kSaveParametersService[] = "save_parameters";
/// planar_bin_picking/LocatedParts: latched: the latest answer
constexpr char kLocatedPartsTopic[] = "located_parts";
/// visualization_msgs/MarkerArray: latched: outlines and names, for rviz
constexpr char kMarkersTopic[] = "markers";
/// sensor_msgs/Image: the latest answer drawn into its image, for whoever subscribes
constexpr char kOverlayTopic[] = "overlay";
/// planar_bin_picking/LocateBin: finds the bin by its rim
constexpr char kLocateBinService[] = "locate_bin";
/// visualization_msgs/InteractiveMarkerUpdate: the region's corners as handles to drag, for rviz
constexpr char kRegionHandlesTopic[] = "region_handles";
/// geometry_msgs/PoseStamped: latched: the bin as it was found last, and is in force
constexpr char kBinTopic[] = "bin";
/// visualization_msgs/MarkerArray: latched: bin, region, camera, plane and next view, for rviz
constexpr char kSceneTopic[] = "scene";
/// std_srvs/Trigger: puts the clicked region in force and keeps it
constexpr char kSaveRegionService[] = "save_region";
/// std_srvs/Trigger: forgets the clicked points, or else the region that was taught
constexpr char kClearRegionService[] = "clear_region";
/// std_msgs/Header: once a second, as long as the node lives
constexpr char kHeartbeatTopic[] = "heartbeat";

// The HDR node's, below the node's name.
/// sensor_msgs/Image: one image of the bracket, 8 bits; its camera_info stands beside it
constexpr char kHdrImageTopic[] = "image_raw";
/// std_srvs/Trigger: takes an exposure bracket
constexpr char kTakeService[] = "take";

// The calibrator's, below the node's name.
/// planar_bin_picking/MoveRobot: called: the robot, below the node's namespace
constexpr char kMoveRobotService[] = "move_robot";
/// std_srvs/Trigger: begins a new set of pictures
constexpr char kStartService[] = "start";
/// std_srvs/Trigger: stops the robot at once
constexpr char kAbortService[] = "abort";
/// std_srvs/Trigger: goes on where the status says that it waits
constexpr char kNextService[] = "next";
/// std_srvs/Trigger: shows the first poses and moves nothing
constexpr char kPlanService[] = "plan";
/// std_srvs/Trigger: adds a picture from where the robot stands
constexpr char kAddSampleService[] = "add_sample";
/// planar_bin_picking/RemoveSample: leaves out one sample, or all
constexpr char kRemoveSampleService[] = "remove_sample";
/// std_srvs/Trigger: numbers the samples
constexpr char kListSamplesService[] = "list_samples";
/// std_srvs/Trigger: goes on with the samples in output_folder
constexpr char kLoadSamplesService[] = "load_samples";
/// std_srvs/Trigger: as start, but adds to the samples that there are
constexpr char kAddViewsService[] = "add_views";
/// std_srvs/Trigger: whether the calibration is still good; changes nothing
constexpr char kVerifyService[] = "verify";
/// std_srvs/Trigger: solves the samples that there are
constexpr char kFinishService[] = "finish";
/// std_msgs/String: latched: what it does, or how it ended
constexpr char kStatusTopic[] = "status";
/// visualization_msgs/MarkerArray: latched: the poses to come, for rviz
constexpr char kPlanTopic[] = "plan_markers";

// Below which the numbers are that may be changed while the locator runs (dynamic_reconfigure).
constexpr char kTuningName[] = "tuning";

// The teaching node's, below its name; rviz listens to <markers>/update.
/// visualization_msgs/InteractiveMarkerUpdate: the pick poses as markers to drag
constexpr char kTeachMarkersTopic[] = "poses";
/// std_srvs/Trigger: writes the poses into the part's file
constexpr char kSaveService[] = "save";
/// planar_bin_picking/RenamePick: another name for a pick pose, which rviz has no field for
constexpr char kRenameService[] = "rename";

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
