// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Saves calls as snapshots (planar_bin_picking/snapshot/snapshot.h): on ~save_snapshot, and by
/// itself where something went wrong that somebody may want to look into. Any number of threads; a
/// caller never waits for the disk.

#include "locator/answer/answer.h"
#include "locator/parts/part_library.h"
#include "locator/settings/settings.h"
#include "planar_bin_picking/snapshot/snapshot_ring.h"

#include <planar_bin_picking/LocatePart.h>
#include <ros/node_handle.h>
#include <std_srvs/Trigger.h>

#include <Eigen/Geometry>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace planar_bin_picking_ros {

/// A call that got as far as an image, with all that its answer depends on.
struct CallRecord {
  Answer answer;  ///< with the result as the locator gave it
  planar_bin_picking::LocateRequest request;
  Settings settings;
  std::shared_ptr<const PartLibrary> library;
  Eigen::Isometry3d T_target_camera = Eigen::Isometry3d::Identity();
  planar_bin_picking::LocatePart::Request asked;
  planar_bin_picking::LocatePart::Response answered;
};

class SnapshotKeeper {
 public:
  /// @param cell  its folders and their limits
  /// @param nh    its callback queue serves ~save_snapshot
  /// @throws std::runtime_error  a folder cannot be written to
  SnapshotKeeper(const CellParams& cell, ros::NodeHandle nh);
  ~SnapshotKeeper();
  SnapshotKeeper(const SnapshotKeeper&) = delete;
  SnapshotKeeper& operator=(const SnapshotKeeper&) = delete;

  /// A call has ended. Saved by itself where its status is NO_PART_FOUND or DEADLOCK, and in any
  /// case where the cell has an archive.
  void note(CallRecord record);
  /// A pick was reported.
  void reported(bool success);

 private:
  struct Job {
    std::shared_ptr<const CallRecord> record;
    std::string reason;
    const planar_bin_picking::SnapshotRing* ring = nullptr;
  };

  bool serve(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  /// Unless the same was saved a moment ago. Under mutex_.
  void saveBesides(const std::string& reason);
  void archive();  ///< the latest, beside the calls. Under mutex_.
  void work();
  /// @return  where it lies
  std::string save(const Job& job);

  const int failures_max_;
  std::optional<planar_bin_picking::SnapshotRing> ring_, archive_;
  std::mutex writing_;  ///< one is written at a time

  std::mutex mutex_;  ///< guards what follows
  std::shared_ptr<const CallRecord> latest_;
  std::deque<Job> jobs_;
  std::map<std::string, std::chrono::steady_clock::time_point> saved_at_;  ///< by reason
  int failures_ = 0;
  bool misses_ = false;  ///< the disk is too slow for the archive
  bool ends_ = false;
  std::condition_variable wake_;
  std::thread thread_;
  ros::ServiceServer service_;
};

}  // namespace planar_bin_picking_ros
