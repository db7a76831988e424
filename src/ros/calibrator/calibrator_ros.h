// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The calibrator as a ROS node. Does nothing before `~start`; then moves, looks and solves in a
/// thread of its own, and says on the latched `~status` how it stands: "waiting" where it asks for
/// ~next. A run ends with a status that begins with GOOD, POOR, REFUSED, ABORTED (the robot
/// confirmed that it stopped) or FAILED.

#include "calibrator/board_look.h"
#include "calibrator/calibration_drive.h"
#include "calibrator/calibration_verifier.h"
#include "calibrator/calibrator_params.h"
#include "calibrator/calibrator_task.h"
#include "calibrator/robot_mover.h"
#include "calibrator/sample_store.h"
#include "input/image_source.h"
#include "planar_bin_picking/calibrate/calibration_file.h"
#include "shared/transform_listener.h"

#include <planar_bin_picking/RemoveSample.h>
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

  bool start(Request&, Response& response);
  bool abort(Request&, Response& response);
  bool next(Request&, Response& response);
  bool plan(Request&, Response& response);
  bool addViews(Request&, Response& response);
  bool addSample(Request&, Response& response);
  bool removeSample(planar_bin_picking::RemoveSample::Request& request,
                    planar_bin_picking::RemoveSample::Response& response);
  bool listSamples(Request&, Response& response);
  bool loadSamples(Request&, Response& response);
  bool finish(Request&, Response& response);
  bool verify(Request&, Response& response);

  CalibratorTask::Hold begin(CalibratorTask::Kind kind);
  /// @param adds  to the samples that are there
  bool startRun(bool adds, Response& response);
  void runThread(CalibratorTask::Hold hold, bool adds);
  /// Moves and looks until the run has enough. @return  the final status
  std::string calibrate(bool adds);
  /// Those in memory; without any, those in the folder.
  void haveSamples(const Look& look);
  CalibrationDrive::Listener listener();
  /// Publishes the run's poses and keeps what ~plan says of them.
  void show(const planar_bin_picking::CalibrationRun& run,
            const std::vector<Eigen::Isometry3d>& way);
  /// The first poses of a run that begins now.
  void showPlan(const Look& first);
  std::string save(const planar_bin_picking::HandEyeProblem& problem,
                   const planar_bin_picking::HandEyeResult& result,
                   const std::string& camera_frame);
  void setStatus(const std::string& text);
  /// How a run ends that somebody stopped.
  std::string stoppedStatus();

  const CalibratorParams params_;
  ros::CallbackQueue image_queue_, call_queue_;
  ros::NodeHandle image_nh_, call_pnh_;
  TransformBuffer tf_buffer_;
  TransformListener tf_listener_;
  tf2_ros::StaticTransformBroadcaster broadcaster_;
  ImageSource source_;
  RobotMover robot_;
  const BoardLook board_;
  CalibratorTask task_;
  std::thread thread_;            // of the run; whoever begins one has the task
  SampleStore samples_;           // whoever has the task
  CalibrationVerifier verifier_;  // likewise
  std::mutex status_mutex_;
  std::string poses_so_far_;  // guarded by status_mutex_
  ros::Publisher status_, markers_;
  std::vector<ros::ServiceServer> services_;
  ros::AsyncSpinner image_spinner_, call_spinner_;
};

}  // namespace planar_bin_picking_ros
