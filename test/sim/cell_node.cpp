// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// The simulated cell as ROS nodes would show a real one:
///
/// - camera/image_raw, camera/camera_info: one picture for each call of camera/trigger
/// - camera/trigger (std_srvs/Trigger): the camera's software trigger; answers once it is published
/// - camera/set_parameters: dynamic_reconfigure's service; int `exposure`, microseconds
/// - move_robot (MoveRobot): moves the flange; /tf says where it is
/// - gripper/suction (std_srvs/SetBool): success = the vacuum holds; false lets go
/// - gripper/holds (std_srvs/Trigger): success = it still does
/// - cell/refill (std_srvs/Trigger): empties the bin and pours anew, with the next seed
/// - truth (LocatedParts, latched): what lies where, for the tester alone; `picks` has the poses
///   that look the same
///
/// The camera is a grey one. `bayer` (RGGB, GRBG, GBRG or BGGR) makes it a colour camera, whose
/// picture is demosaiced and made grey again; `jpeg_quality` (1 .. 100) sends its pictures through
/// JPEG.
///
/// Frames: base -> flange -> tool, and base -> camera or flange -> camera.
///
/// Where robot_noise_mm or robot_noise_deg is set (standard deviations per axis), the flange is a
/// little elsewhere than tf says, anew after each move; likewise the camera on it by
/// hand_eye_noise_mm and hand_eye_noise_deg, once and for all.

#include "sim/simulated_cell.h"

#include <dynamic_reconfigure/Reconfigure.h>
#include <geometry_msgs/TransformStamped.h>
#include <image_transport/image_transport.h>
#include <planar_bin_picking/LocatedParts.h>
#include <planar_bin_picking/MoveRobot.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <sensor_msgs/image_encodings.h>
#include <std_srvs/SetBool.h>
#include <std_srvs/Trigger.h>
#include <tf2_eigen/tf2_eigen.h>
#include <tf2_ros/static_transform_broadcaster.h>
#include <tf2_ros/transform_broadcaster.h>

#include <boost/make_shared.hpp>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>
#include <sstream>

namespace planar_bin_picking::cell {
namespace {

constexpr double kPi = 3.14159265358979323846;

Eigen::Isometry3d lookingDown(double x, double y, double z) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = Eigen::Vector3d(x, y, z);
  T.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return T;
}

geometry_msgs::TransformStamped stamped(const std::string& parent, const std::string& child,
                                        const Eigen::Isometry3d& T_parent_child) {
  geometry_msgs::TransformStamped message = tf2::eigenToTransform(T_parent_child);
  message.header.stamp = ros::Time::now();
  message.header.frame_id = parent;
  message.child_frame_id = child;
  return message;
}

/// @throws std::invalid_argument  it is there and of another type
template <class Value>
Value param(const std::string& name, const Value& otherwise) {
  Value value = otherwise;
  if (!ros::param::get("~" + name, value) && ros::param::has("~" + name))
    throw std::invalid_argument("~" + name + " has another type than it must have");
  return value;
}

std::vector<std::string> words(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> list;
  for (std::string word; in >> word;) list.push_back(word);
  return list;
}

std::vector<PartKind> loadKinds() {
  const auto folder = param<std::string>("parts_folder", "");
  std::vector<PartKind> kinds;
  for (const auto& name : words(param<std::string>("parts", "bracket")))
    kinds.push_back(loadPartKind(folder + "/" + name + ".yaml"));
  return kinds;
}

CellConfig loadConfig(double camera_height) {
  CellConfig config;
  for (const auto& count : words(param<std::string>("counts", "20")))
    config.counts.push_back(std::stoi(count));
  config.light = param<std::string>("light", "diffuse");
  config.material = param<std::string>("material", "rolled");
  config.seed = static_cast<std::uint64_t>(param<int>("seed", 1));
  config.sensor.encoding = {param<std::string>("bayer", ""), param<int>("jpeg_quality", 0)};
  check(config.sensor.encoding);
  config.lens = lensOver(config.bin, camera_height, param<double>("megapixels", 1.3));
  return config;
}

/// A small motion with these standard deviations per axis.
Eigen::Isometry3d smallMotion(double millimetres, double degrees, std::mt19937* random) {
  std::normal_distribution<double> normal;
  const auto three = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(*random), sigma * normal(*random),
                           sigma * normal(*random));
  };
  const Eigen::Vector3d shift = three(1e-3 * millimetres), turn = three(degrees * kPi / 180.0);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.translation() = shift;
  if (turn.norm() > 0.0)
    T.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  return T;
}

class CellNode {
 public:
  CellNode()
      : on_arm_(param<bool>("camera_on_arm", false)),
        height_(param<double>("camera_height", 0.75)),
        exposure_us_(param<int>("exposure_us", 0)),
        seed_(static_cast<std::uint64_t>(param<int>("seed", 1))),
        cell_(loadConfig(height_), loadKinds()),
        images_(nh_),
        camera_(images_.advertiseCamera("camera/image_raw", 1)),
        truth_(nh_.advertise<planar_bin_picking::LocatedParts>("truth", 1, true)) {
    T_flange_camera_ =
        Eigen::Translation3d(0.05, -0.03, 0.02) * Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
    T_flange_tool_ = Eigen::Translation3d(0.0, 0.0, 0.12);
    T_base_flange_ = home();
    random_.seed(static_cast<unsigned>(seed_));
    T_camera_true_ = smallMotion(param<double>("hand_eye_noise_mm", 0.0),
                                 param<double>("hand_eye_noise_deg", 0.0), &random_);
    const bool is_automatic = exposure_us_ <= 0;
    if (is_automatic)
      exposure_us_ = static_cast<int>(std::lround(1e6 * cell_.exposureFor(T_base_camera())));
    const auto& [parent, T] = on_arm_ ? std::make_pair("flange", T_flange_camera_)
                                      : std::make_pair("base", T_base_camera());
    static_tf_.sendTransform(
        {stamped(parent, "camera", T), stamped("flange", "tool", T_flange_tool_)});
    services_ = {nh_.advertiseService("camera/trigger", &CellNode::trigger, this),
                 nh_.advertiseService("camera/set_parameters", &CellNode::configure, this),
                 nh_.advertiseService("move_robot", &CellNode::move, this),
                 nh_.advertiseService("gripper/suction", &CellNode::suction, this),
                 nh_.advertiseService("gripper/holds", &CellNode::holds, this),
                 nh_.advertiseService("cell/refill", &CellNode::refill, this)};
    // In a thread of its own: a robot does not fall silent while the camera takes its picture.
    tf_nh_.setCallbackQueue(&tf_queue_);
    timer_ = tf_nh_.createWallTimer(ros::WallDuration(0.02),
                                    [this](const ros::WallTimerEvent&) { sendTf(); });
    tf_spinner_.start();
    publishTruth(ros::Time::now());
    ROS_INFO("simulated cell: %zu parts, exposure %d us", cell_.heap().bodies().size(),
             exposure_us_);
  }

 private:
  /// The camera, fixed or on the arm, is above the middle of the bin there.
  Eigen::Isometry3d home() const {
    const Eigen::Isometry3d T_base_camera = lookingDown(0.0, 0.0, height_);
    return on_arm_ ? T_base_camera * T_flange_camera_.inverse() : lookingDown(0.0, 0.45, 0.5);
  }
  Eigen::Isometry3d T_base_camera() const {
    if (on_arm_) return trueFlange() * T_flange_camera_ * T_camera_true_;
    return lookingDown(0.012, -0.008, height_) *
           Eigen::Isometry3d(Eigen::AngleAxisd(0.03, Eigen::Vector3d(1.0, 0.5, 0.3).normalized()));
  }

  Eigen::Isometry3d trueFlange() const { return T_base_flange_ * T_flange_true_; }

  void sendTf() {
    const std::lock_guard<std::mutex> lock(flange_mutex_);
    tf_.sendTransform(stamped("base", "flange", T_base_flange_));
  }

  bool trigger(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    sendTf();
    const ros::Time stamp = ros::Time::now();
    const cv::Mat picture = cell_.takePicture(T_base_camera(), 1e-6 * exposure_us_);
    auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.stamp = stamp;
    image->header.frame_id = "camera";
    image->height = picture.rows;
    image->width = image->step = picture.cols;
    image->encoding = sensor_msgs::image_encodings::MONO8;
    image->data.assign(picture.data, picture.data + picture.total());
    camera_.publish(image, makeInfo(image->header));
    sendTf();
    publishTruth(stamp);
    response.success = true;
    return true;
  }

  sensor_msgs::CameraInfoPtr makeInfo(const std_msgs::Header& header) const {
    const Lens& lens = cell_.config().lens;
    auto info = boost::make_shared<sensor_msgs::CameraInfo>();
    info->header = header;
    info->width = lens.width;
    info->height = lens.height;
    info->distortion_model = "plumb_bob";
    info->D.assign(lens.d.begin(), lens.d.end());
    info->K = {lens.fx, 0.0, lens.cx, 0.0, lens.fy, lens.cy, 0.0, 0.0, 1.0};
    info->R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
    info->P = {lens.fx, 0.0, lens.cx, 0.0, 0.0, lens.fy, lens.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
    return info;
  }

  bool configure(dynamic_reconfigure::Reconfigure::Request& request,
                 dynamic_reconfigure::Reconfigure::Response& response) {
    for (const auto& value : request.config.ints)
      if (value.name == "exposure") exposure_us_ = std::clamp(value.value, 10, 1000000);
    response.config.ints.resize(1);
    response.config.ints[0].name = "exposure";
    response.config.ints[0].value = exposure_us_;
    return true;
  }

  bool move(planar_bin_picking::MoveRobot::Request& request,
            planar_bin_picking::MoveRobot::Response& response) {
    constexpr double kReach = 1.2;  // metres
    Eigen::Isometry3d T_base_target;
    tf2::fromMsg(request.target.pose, T_base_target);
    const bool is_base = request.target.header.frame_id == "base";
    response.reachable = is_base && T_base_target.translation().norm() < kReach &&
                         T_base_target.translation().z() > 0.0;
    if (!is_base) response.message = "the target's frame must be base";
    if (is_base && !response.reachable) response.message = "out of reach";
    if (response.reachable && !cell_.toolIsFree(T_base_target * T_flange_tool_)) {
      response.reachable = false;
      response.message = "the tool would touch the bin";
    }
    response.success = response.reachable;
    if (response.success) {
      const std::lock_guard<std::mutex> lock(flange_mutex_);
      T_base_flange_ = T_base_target;
      T_flange_true_ = smallMotion(robot_noise_mm_, robot_noise_deg_, &random_);
    }
    sendTf();
    response.reached = request.target;
    response.reached.header.stamp = ros::Time::now();
    response.reached.pose = tf2::toMsg(T_base_flange_);
    return true;
  }

  bool suction(std_srvs::SetBool::Request& request, std_srvs::SetBool::Response& response) {
    response.success = true;
    holds_ = false;
    if (!request.data) return true;
    const PickResult result = cell_.pick(trueFlange() * T_flange_tool_);
    response.success = holds_ = result == PickResult::kPicked;
    response.message = nameOf(result);
    publishTruth(ros::Time::now());
    return true;
  }

  bool holds(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    response.success = holds_;
    return true;
  }

  bool refill(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
    cell_.refill(++seed_);
    publishTruth(ros::Time::now());
    response.success = true;
    response.message = "seed " + std::to_string(seed_);
    return true;
  }

  void publishTruth(const ros::Time& stamp) {
    planar_bin_picking::LocatedParts message;
    message.header.stamp = stamp;
    message.header.frame_id = "base";
    for (const TruePart& part : cell_.truth(T_base_camera())) {
      planar_bin_picking::LocatedPart located;
      located.header = message.header;
      located.part = cell_.kind(part.kind).name;
      located.child_frame = "truth_" + std::to_string(part.id);
      located.face = part.front_up ? located.FRONT : located.BACK;
      located.pose.pose = tf2::toMsg(part.T_base_part);
      located.visible_fraction = part.visible_fraction;
      const PartKind& kind = cell_.kind(part.kind);
      for (const auto& T_part_same :
           part.front_up ? kind.symmetric_poses : kind.back_symmetric_poses) {
        located.picks.emplace_back();
        located.picks.back().name = "symmetric";
        located.picks.back().pose = tf2::toMsg(Eigen::Isometry3d(part.T_base_part * T_part_same));
      }
      message.parts.push_back(located);
    }
    truth_.publish(message);
  }

  ros::NodeHandle nh_;
  const bool on_arm_;
  const double height_;
  int exposure_us_;
  std::uint64_t seed_;
  SimulatedCell cell_;
  bool holds_ = false;       ///< the gripper has a part
  std::mutex flange_mutex_;  ///< the thread that sends tf reads where the flange is
  Eigen::Isometry3d T_base_flange_, T_flange_camera_, T_flange_tool_;
  const double robot_noise_mm_ = param<double>("robot_noise_mm", 0.0);
  const double robot_noise_deg_ = param<double>("robot_noise_deg", 0.0);
  std::mt19937 random_;
  /// From where tf says that flange and camera are to where they are.
  Eigen::Isometry3d T_flange_true_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_camera_true_ = Eigen::Isometry3d::Identity();
  image_transport::ImageTransport images_;
  image_transport::CameraPublisher camera_;
  ros::Publisher truth_;
  tf2_ros::TransformBroadcaster tf_;
  tf2_ros::StaticTransformBroadcaster static_tf_;
  std::vector<ros::ServiceServer> services_;
  ros::CallbackQueue tf_queue_;
  ros::NodeHandle tf_nh_;
  ros::WallTimer timer_;
  ros::AsyncSpinner tf_spinner_{1, &tf_queue_};
};

}  // namespace
}  // namespace planar_bin_picking::cell

int main(int argc, char** argv) {
  ros::init(argc, argv, "cell");
  const ros::NodeHandle nh;
  try {
    planar_bin_picking::cell::CellNode node;
    ros::spin();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM("simulated cell: " << error.what());
    return 1;
  }
  return 0;
}
