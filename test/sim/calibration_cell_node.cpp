// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The simulated cell as a ROS node: a camera that draws the board, a robot behind MoveRobot, tf.
/// What goes wrong in it is switched on by parameters.

#include "support/simulated_run.h"

#include <geometry_msgs/TransformStamped.h>
#include <planar_bin_picking/MoveRobot.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <std_msgs/Int32.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <mutex>

namespace planar_bin_picking {
namespace {

geometry_msgs::Pose toMsg(const Eigen::Isometry3d& T) {
  const Eigen::Quaterniond q(T.linear());
  geometry_msgs::Pose pose;
  pose.position.x = T.translation().x();
  pose.position.y = T.translation().y();
  pose.position.z = T.translation().z();
  pose.orientation.x = q.x();
  pose.orientation.y = q.y();
  pose.orientation.z = q.z();
  pose.orientation.w = q.w();
  return pose;
}

Eigen::Isometry3d fromMsg(const geometry_msgs::Pose& p) {
  const Eigen::Quaterniond q(p.orientation.w, p.orientation.x, p.orientation.y, p.orientation.z);
  return rigid(q.normalized().toRotationMatrix(), {p.position.x, p.position.y, p.position.z});
}

sim::PinholeCamera smallCamera() {
  return {800, 640, 1100.0, 1098.5, 404.0, 316.0, {-0.1, 0.06, -5e-4, 4e-4, 0.0}};
}

class CalibrationCell {
 public:
  CalibrationCell(ros::NodeHandle nh, const ros::NodeHandle& pnh)
      : world_(pnh.param("in_hand", true), static_cast<unsigned>(pnh.param("seed", 1)),
               smallCamera()),
        move_seconds_(pnh.param("move_seconds", 0.2)),
        pictures_left_(pnh.param("pictures", -1)),
        board_moves_(pnh.param("board_moves", -1)),
        has_tf_(pnh.param("tf", true)) {
    world_.unreachable = pnh.param("unreachable", 0.0);
    world_.failing = pnh.param("failing", 0.0);
    world_.cell.robot_mm = pnh.param("robot_mm", 0.0);
    world_.cell.robot_deg = pnh.param("robot_deg", 0.0);
    at_ = said_ = world_.T_base_start;
    images_ = nh.advertise<sensor_msgs::Image>("camera/image_raw", 1);
    infos_ = nh.advertise<sensor_msgs::CameraInfo>("camera/camera_info", 1);
    moves_ = nh.advertise<std_msgs::Int32>("moves", 1, true);
    robot_ = nh.advertiseService("move_robot", &CalibrationCell::move, this);
    tf_timer_ = nh.createTimer(ros::Duration(0.02), &CalibrationCell::sendTf, this);
    image_timer_ = nh.createTimer(ros::Duration(0.3), &CalibrationCell::sendImage, this);
  }

 private:
  bool move(MoveRobot::Request& request, MoveRobot::Response& response) {
    if (!(request.speed_scale > 0.0)) {
      stop_ = true;
      response.success = true;
      return true;
    }
    const Eigen::Isometry3d target = fromMsg(request.target.pose);
    if (world_.isUnreachable(target)) {
      response.message = "not reachable";
      return true;
    }
    response.reachable = true;
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    if (chance(random_) < world_.failing) {
      response.message = "failed on the way";
      return true;
    }
    response.success = drive(target);
    if (!response.success) response.message = "stopped";
    const std::lock_guard<std::mutex> lock(mutex_);
    response.reached = request.target;
    response.reached.pose = toMsg(said_);
    return true;
  }

  /// @return  false where it was stopped on its way
  bool drive(const Eigen::Isometry3d& target) {
    stop_ = false;
    std_msgs::Int32 count;
    count.data = ++count_;
    moves_.publish(count);
    const Eigen::Isometry3d from = at_;
    const Vector6d way = log(from.inverse() * target);
    constexpr int kSteps = 50;
    for (int i = 1; i <= kSteps; ++i) {
      ros::WallDuration(move_seconds_ / kSteps).sleep();
      if (stop_) return false;
      const std::lock_guard<std::mutex> lock(mutex_);
      at_ = said_ = from * exp(way * (static_cast<double>(i) / kSteps));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    said_ = sim::reported(world_.cell, at_, &random_);
    return true;
  }

  void sendTf(const ros::TimerEvent&) {
    if (!has_tf_) return;
    geometry_msgs::TransformStamped transform;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const geometry_msgs::Pose pose = toMsg(said_);
      transform.transform.translation.x = pose.position.x;
      transform.transform.translation.y = pose.position.y;
      transform.transform.translation.z = pose.position.z;
      transform.transform.rotation = pose.orientation;
    }
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = "base";
    transform.child_frame_id = "flange";
    tf_.sendTransform(transform);
  }

  void sendImage(const ros::TimerEvent&) {
    if (pictures_left_ == 0) return;
    if (pictures_left_ > 0) --pictures_left_;
    sensor_msgs::Image image;
    Eigen::Isometry3d at;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      at = at_;
      image.header.stamp = ros::Time::now();
    }
    image.header.frame_id = "camera";
    Eigen::Isometry3d T_camera_board = world_.cell.cameraBoard(at);
    // Somebody carries the board off: too far away to be made out.
    if (board_moves_ >= 0 && count_ > board_moves_) T_camera_board.translation().z() += 5.0;
    const cv::Mat picture = sim::takeBoardImage(world_.cell, T_camera_board, 0.7, 2.0, ++pictures_);
    image.height = static_cast<std::uint32_t>(picture.rows);
    image.width = image.step = static_cast<std::uint32_t>(picture.cols);
    image.encoding = sensor_msgs::image_encodings::MONO8;
    image.data.assign(picture.datastart, picture.dataend);
    sensor_msgs::CameraInfo info;
    info.header = image.header;
    info.height = image.height;
    info.width = image.width;
    images_.publish(image);
    infos_.publish(info);
  }

  RunWorld world_;
  const double move_seconds_;
  int pictures_left_;
  const int board_moves_;
  const bool has_tf_;
  std::mt19937 random_{17};
  std::mutex mutex_;
  Eigen::Isometry3d at_, said_;  // where the flange is, and where the robot says it is
  std::atomic<bool> stop_{false};
  std::atomic<int> count_{0};
  int pictures_ = 0;
  ros::Publisher images_, infos_, moves_;
  ros::ServiceServer robot_;
  ros::Timer tf_timer_, image_timer_;
  tf2_ros::TransformBroadcaster tf_;
};

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  ros::init(argc, argv, "calibration_cell");
  const ros::NodeHandle nh, pnh("~");
  planar_bin_picking::CalibrationCell cell(nh, pnh);
  ros::MultiThreadedSpinner(4).spin();
  return 0;
}
