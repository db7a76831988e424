// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The calibrator as a ROS node. Does nothing before `~start`; then moves, looks and solves in a
/// thread of its own, and says on the latched `~status` how it stands. A run ends with a status
/// that begins with GOOD, POOR, REFUSED, ABORTED (the robot confirmed that it stopped) or FAILED.

#include "calibrator/calibrator_params.h"
#include "calibrator/calibrator_task.h"
#include "calibrator/robot_mover.h"
#include "planar_bin_picking/calibrate/board/checkerboard.h"
#include "planar_bin_picking/calibrate/calibration_file.h"
#include "shared/image_source.h"
#include "shared/transform_listener.h"

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/static_transform_broadcaster.h>

#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {

class CalibratorRos {
 public:
  /// @throws std::exception  a parameter is wrong: which one and why
  CalibratorRos(const ros::NodeHandle& nh, const ros::NodeHandle& pnh);
  /// Stops the robot if it is on a run; done within stop_timeout and what one image takes to
  /// search.
  ~CalibratorRos();
  CalibratorRos(const CalibratorRos&) = delete;
  CalibratorRos& operator=(const CalibratorRos&) = delete;

 private:
  using Request = std_srvs::Trigger::Request;
  using Response = std_srvs::Trigger::Response;

  /// A picture and where the flange was when it was taken.
  struct Look {
    planar_bin_picking::BoardObservation board;
    Eigen::Isometry3d T_base_flange = Eigen::Isometry3d::Identity();
    cv::Mat image;
    Frame frame;
  };
  /// Pictures of push mode.
  struct Samples {
    planar_bin_picking::HandEyeProblem problem;
    Frame first;
  };

  bool start(Request&, Response& response);
  bool abort(Request&, Response& response);
  bool plan(Request&, Response& response);
  bool addSample(Request&, Response& response);
  bool finish(Request&, Response& response);

  CalibratorTask::Hold begin(CalibratorTask::Kind kind);
  void runThread(CalibratorTask::Hold hold);
  /// Moves and looks until the run has enough. @return  the final status
  std::string calibrate();
  /// Goes to the pose and looks; tells the run what came of it.
  void visit(const Eigen::Isometry3d& T_base_flange, bool move, const Look& first,
             planar_bin_picking::CalibrationRun* run);
  /// @return  false where the robot cannot go there
  bool goTo(const Eigen::Isometry3d& T_base_flange, Eigen::Isometry3d* T_base_reached);
  /// @return  what went wrong, which costs no calibration
  std::string goBack(const Eigen::Isometry3d& T_base_start);
  /// @throws std::runtime_error  no image, no transform
  Look look();
  Eigen::Isometry3d flangeAt(const ros::Time& stamp) const;
  planar_bin_picking::HandEyeProblem emptyProblem(const Look& look) const;
  void keep(const Look& seen);
  /// Publishes the run's poses and keeps what ~plan says of them.
  void show(const planar_bin_picking::CalibrationRun& run);
  std::string save(const planar_bin_picking::HandEyeProblem& problem,
                   const planar_bin_picking::HandEyeResult& result,
                   const std::string& camera_frame);
  void setStatus(const std::string& text);
  /// How a run ends that somebody stopped.
  std::string stoppedStatus();

  const CalibratorParams params_;
  const planar_bin_picking::Board board_;
  ros::CallbackQueue image_queue_, call_queue_;
  ros::NodeHandle image_nh_, call_pnh_;
  TransformBuffer tf_buffer_;
  TransformListener tf_listener_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  ImageSource source_;
  RobotMover robot_;
  CalibratorTask task_;
  std::thread thread_;                // of the run; whoever begins one has the task
  std::unique_ptr<Samples> samples_;  // whoever has the task
  std::mutex status_mutex_;
  std::string poses_so_far_;  // guarded by status_mutex_
  ros::Publisher status_, markers_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner image_spinner_, call_spinner_;
};

}  // namespace planar_bin_picking_ros
