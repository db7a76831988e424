// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The simulated cell as a ROS node: a camera that draws the board, a robot behind MoveRobot, tf.
/// What goes wrong in it is switched on by parameters; `~manner` may change while it runs, and says
/// how the robot takes the next request:
///     slow        a move takes 20 s
///     slow_ways   a move takes 1 s
///     late        begins a move 0.5 s after it was asked for, whatever stop came before
///     hangs       does not answer a move any more, confirms stops
///     dead        answers neither moves nor stops
///     runs_on     as slow, but does not obey stops, and says so
///     protective  breaks each move off
///     no_return   breaks off moves to where it was at the start
///     refuses     finds no pose reachable
///     still       does not move, and says where it stands
///     elsewhere   goes 5 mm and 1 deg aside, and says so
///     lies        goes 5 mm and 1 deg aside, and says that it stands at the target
///     nan, frame  says so where it stands: not a number; in the flange's frame
///     dies        ends the process
///     blind       takes no pictures
///     late_tf     tf comes 1 s late
///     no_tf       tf does not come
/// `~bump_mm` moves the camera on its mount, likewise at any time.
/// What it was asked for is published: `target`, `speed`, and how many `moves` and `stops`.

#include "support/simulated_run.h"

#include <geometry_msgs/TransformStamped.h>
#include <planar_bin_picking/MoveRobot.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>
#include <std_msgs/Float64.h>
#include <std_msgs/Int32.h>
#include <tf2_ros/transform_broadcaster.h>

#include <unistd.h>

#include <atomic>
#include <deque>
#include <limits>
#include <mutex>

namespace planar_bin_picking {
namespace {

/// Between two pictures: as fast as a small machine draws them beside all else.
constexpr double kImageSeconds = 0.12;

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
      : pnh_(pnh),
        world_(pnh.param("in_hand", true), static_cast<unsigned>(pnh.param("seed", 1)),
               smallCamera()),
        base_frame_(pnh.param<std::string>("base_frame", "base")),
        flange_frame_(pnh.param<std::string>("flange_frame", "flange")),
        move_seconds_(pnh.param("move_seconds", 0.1)),
        board_moves_(pnh.param("board_moves", -1)) {
    world_.unreachable = pnh.param("unreachable", 0.0);
    world_.cell.robot_mm = pnh.param("robot_mm", 0.0);
    world_.cell.robot_deg = pnh.param("robot_deg", 0.0);
    if (pnh.param("markers", false)) sim::giveMarkers(&world_.cell);
    at_ = said_ = world_.T_base_start;
    images_ = nh.advertise<sensor_msgs::Image>("camera/image_raw", 1);
    infos_ = nh.advertise<sensor_msgs::CameraInfo>("camera/camera_info", 1);
    moves_ = nh.advertise<std_msgs::Int32>("moves", 1, true);
    stops_ = nh.advertise<std_msgs::Int32>("stops", 1, true);
    targets_ = nh.advertise<geometry_msgs::PoseStamped>("target", 100);
    speeds_ = nh.advertise<std_msgs::Float64>("speed", 100);
    robot_ = nh.advertiseService("move_robot", &CalibrationCell::move, this);
    tf_timer_ = nh.createTimer(ros::Duration(0.02), &CalibrationCell::sendTf, this);
    image_timer_ = nh.createTimer(ros::Duration(kImageSeconds), &CalibrationCell::sendImage, this);
  }

 private:
  static void publishCount(const ros::Publisher& publisher, int count) {
    std_msgs::Int32 message;
    message.data = count;
    publisher.publish(message);
  }

  std::string manner() const { return pnh_.param<std::string>("manner", ""); }

  /// Until somebody gives the robot other manners.
  void hang(const std::string& manner_now) const {
    while (ros::ok() && manner() == manner_now) ros::WallDuration(0.05).sleep();
  }

  bool stop(MoveRobot::Response& response) {
    publishCount(stops_, ++stop_count_);
    if (manner() == "dead") hang("dead");
    response.success = manner() != "runs_on";
    if (response.success) {
      stop_ = true;
    } else {
      response.message = "cannot stop";
    }
    return true;
  }

  bool move(MoveRobot::Request& request, MoveRobot::Response& response) {
    if (!(request.speed_scale > 0.0)) return stop(response);
    targets_.publish(request.target);
    std_msgs::Float64 speed;
    speed.data = request.speed_scale;
    speeds_.publish(speed);
    const std::string manner_now = manner();
    Eigen::Isometry3d target = fromMsg(request.target.pose);
    if (world_.isUnreachable(target) || manner_now == "refuses") {
      response.message = "not reachable";
      return true;
    }
    response.reachable = true;
    if (manner_now == "dies") {
      ros::WallDuration(0.3).sleep();  // until what was published has been sent
      _exit(1);
    }
    const bool is_start = target.isApprox(world_.T_base_start, 1e-6);
    if (manner_now == "protective" || (manner_now == "no_return" && is_start)) {
      response.message = "the light curtain was broken";
      return true;
    }
    if (manner_now == "hangs" || manner_now == "dead") hang(manner_now);
    if (manner_now == "late") ros::WallDuration(0.5).sleep();
    if (manner_now == "elsewhere" || manner_now == "lies") target = target * aside();
    if (manner_now == "still") target = at_;
    response.success = drive(target, secondsOf(manner_now));
    if (!response.success) response.message = "stopped";
    const std::lock_guard<std::mutex> lock(mutex_);
    response.reached = request.target;
    if (manner_now != "lies") response.reached.pose = toMsg(said_);
    if (manner_now == "nan") {
      response.reached.pose.position.x = std::numeric_limits<double>::quiet_NaN();
    }
    if (manner_now == "frame") response.reached.header.frame_id = flange_frame_;
    return true;
  }

  double secondsOf(const std::string& manner_now) const {
    if (manner_now == "slow" || manner_now == "runs_on") return 20.0;
    return manner_now == "slow_ways" ? 1.0 : move_seconds_;
  }

  static Eigen::Isometry3d aside() {
    Vector6d xi = Vector6d::Zero();
    xi[0] = 0.005;
    xi[5] = sim::kDegree;
    return exp(xi);
  }

  /// @return  false where it was stopped on its way
  bool drive(const Eigen::Isometry3d& target, double seconds) {
    stop_ = false;
    publishCount(moves_, ++count_);
    const Eigen::Isometry3d from = at_;
    const Vector6d way = log(from.inverse() * target);
    constexpr int kSteps = 50;
    for (int i = 1; i <= kSteps; ++i) {
      for (int tick = 0; tick < 10; ++tick) {
        ros::WallDuration(seconds / kSteps / 10.0).sleep();
        if (stop_) return false;
      }
      const std::lock_guard<std::mutex> lock(mutex_);
      at_ = said_ = from * exp(way * (static_cast<double>(i) / kSteps));
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    said_ = sim::reported(world_.cell, at_, &random_);
    return true;
  }

  void sendTf(const ros::TimerEvent&) {
    if (manner() == "no_tf") return;
    const std::lock_guard<std::mutex> lock(mutex_);
    geometry_msgs::TransformStamped transform;
    const geometry_msgs::Pose pose = toMsg(said_);
    transform.transform.translation.x = pose.position.x;
    transform.transform.translation.y = pose.position.y;
    transform.transform.translation.z = pose.position.z;
    transform.transform.rotation = pose.orientation;
    transform.header.stamp = ros::Time::now();
    transform.header.frame_id = base_frame_;
    transform.child_frame_id = flange_frame_;
    late_tf_.push_back(transform);
    while (!late_tf_.empty() &&
           late_tf_.front().header.stamp + ros::Duration(tf_delay_) <= ros::Time::now()) {
      tf_.sendTransform(late_tf_.front());
      late_tf_.pop_front();
    }
  }

  void sendImage(const ros::TimerEvent&) {
    tf_delay_ = manner() == "late_tf" ? 1.0 : 0.0;
    if (manner() == "blind") return;
    sensor_msgs::Image image;
    Eigen::Isometry3d at;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      at = at_;
      image.header.stamp = ros::Time::now();
    }
    image.header.frame_id = "camera";
    Eigen::Isometry3d T_camera_board = world_.cell.cameraBoard(at);
    // Somebody runs into the camera.
    Vector6d bump = Vector6d::Zero();
    bump[0] = 1e-3 * pnh_.param("bump_mm", 0.0);
    T_camera_board = exp(bump).inverse() * T_camera_board;
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
    if (pnh_.param("calibrated", false)) {
      const sim::PinholeCamera& camera = world_.cell.camera;
      info.distortion_model = "plumb_bob";
      info.D.assign(camera.lens.begin(), camera.lens.end());
      info.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
    }
    images_.publish(image);
    infos_.publish(info);
  }

  const ros::NodeHandle pnh_;
  RunWorld world_;
  const std::string base_frame_, flange_frame_;
  const double move_seconds_;
  const int board_moves_;
  std::atomic<double> tf_delay_{0.0};
  std::deque<geometry_msgs::TransformStamped> late_tf_;
  std::mt19937 random_{17};
  std::mutex mutex_;
  Eigen::Isometry3d at_, said_;  // where the flange is, and where the robot says it is
  std::atomic<bool> stop_{false};
  std::atomic<int> count_{0}, stop_count_{0};
  int pictures_ = 0;
  ros::Publisher images_, infos_, moves_, stops_, targets_, speeds_;
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
  ros::MultiThreadedSpinner(12).spin();  // some of them hang
  return 0;
}
