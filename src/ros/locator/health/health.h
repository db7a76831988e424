// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// How the locator is, on /diagnostics: its camera, its calibration, its parts, its calls;
/// ~heartbeat, for those who only want to know that it lives; and ~parameters, what is in force.
/// Nothing that a robot waits for.

#include "input/image_source.h"
#include "locator/parts/part_store.h"
#include "locator/settings/tuning.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <planar_bin_picking/LocatePart.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace planar_bin_picking_ros {

class Health {
 public:
  /// Says whether a frame's camera_info, or what the cell has in its place, can be used.
  /// @throws std::exception  why not
  using CheckCamera = std::function<void(const Frame& frame)>;

  /// @param nh  its callback queue publishes, once a second
  Health(const ImageSource& source, const PartStore& parts, const Tuning& tuning,
         CheckCamera check_camera, ros::NodeHandle nh);

  /// A call, from its beginning to its answer. Any thread.
  class Call {
   public:
    explicit Call(Health& health) : health_(health) { health_.count(1); }
    ~Call() { health_.count(-1); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;
    void answered(const planar_bin_picking::LocatePart::Response& response) {
      health_.called(response);
    }

   private:
    Health& health_;
  };

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;
  void count(int change);
  void called(const planar_bin_picking::LocatePart::Response& response);
  void camera(Status& status);
  /// Whether images come, but for some looks now no camera_info of the same stamp.
  bool hasNoPairs(const ImageSource::Traffic& traffic, const std::optional<Frame>& newest);
  /// Of the camera's summary; a log that nobody can overlook and that does not fill the disk.
  void warn(const Status& status);
  void calibration(Status& status);
  void parts(Status& status) const;
  void calls(Status& status);
  void describeLatest(Status& status) const;
  void beat();

  const ImageSource& source_;
  const PartStore& parts_;
  const Tuning& tuning_;
  const CheckCamera check_camera_;
  std::size_t images_ = 0;  ///< at the last look
  SteadyTime looked_ = std::chrono::steady_clock::now();
  std::optional<SteadyTime> unpaired_;  ///< since when the latest image has had no camera_info
  SteadyTime warned_ = {};
  std::string warning_;  ///< the last one in the log
  Status calibration_;   ///< as last read from the files
  SteadyTime calibration_read_ = {};

  std::mutex mutex_;  ///< guards these
  planar_bin_picking::LocatePart::Response latest_;
  double latest_threshold_ = 0.0;
  SteadyTime called_;
  std::map<std::uint8_t, std::size_t> by_status_;
  int under_way_ = 0;
  std::size_t deadlocks_in_a_row_ = 0;

  diagnostic_updater::Updater updater_;
  ros::Publisher heartbeat_;
  ros::WallTimer timer_;
  ros::ServiceServer parameters_;
};

}  // namespace planar_bin_picking_ros
