// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locator/snapshot/snapshot_keeper.h"

#include "planar_bin_picking/snapshot/snapshot.h"
#include "shared/convert.h"
#include "shared/names.h"

#include <ros/console.h>

#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking_ros {

namespace fs = std::filesystem;
using planar_bin_picking::SnapshotPartFile;
using Response = planar_bin_picking::LocatePart::Response;

namespace {

/// A robot program that asks again and again would push everything else out of the ring.
constexpr std::chrono::seconds kQuiet(10);
constexpr std::size_t kJobs = 3;  ///< waiting for the disk; each holds an image

template <class Message>
std::string print(const Message& message) {
  std::ostringstream text;
  text << message;
  return text.str();
}

std::string transformText(const CallRecord& record) {
  return "# T_target_camera at the image's stamp\ntarget: " + record.answer.header.frame_id +
         "\ncamera: " + record.answer.frame.image->header.frame_id + "\n" +
         print(toTransformMsg(record.T_target_camera));
}

/// The files of the parts that were looked for.
/// @param changed  gets the paths of those that are no longer as they were read
std::vector<SnapshotPartFile> partFiles(const CallRecord& record, std::string* changed) {
  std::vector<SnapshotPartFile> files;
  const fs::path folder(record.library->folder());
  for (const auto& part : record.request.parts) {
    const FileStamps stamps = record.library->filesOf(part->name());
    const bool has_yaml = stamps.size() > 1 || isPartYaml(stamps.begin()->first);
    for (const auto& [path, stamp] : stamps) {
      if (stampOf(path) != stamp) *changed += "\n  - " + path;
      if (!fs::exists(path)) continue;
      files.push_back({path, fs::path(path).lexically_relative(folder.lexically_normal()).string(),
                       isPartYaml(path) == has_yaml});
    }
  }
  return files;
}

}  // namespace

SnapshotKeeper::SnapshotKeeper(const CellParams& cell, ros::NodeHandle nh)
    : failures_max_(cell.snapshot_failures) {
  const auto bytes = [](const double megabytes) {
    constexpr double kMegabyte = 1e6;
    return static_cast<std::uint64_t>(megabytes * kMegabyte);
  };
  if (!cell.snapshot_folder.empty()) {
    ring_.emplace(cell.snapshot_folder, static_cast<std::size_t>(cell.snapshots_max),
                  bytes(cell.snapshots_mb));
  }
  if (!cell.archive_folder.empty()) {
    if (cell.archive_folder == cell.snapshot_folder)
      throw std::runtime_error(
          "~cell/archive_folder and ~cell/snapshot_folder are the same: each needs its own");
    archive_.emplace(cell.archive_folder, std::numeric_limits<std::size_t>::max(),
                     bytes(cell.archive_mb), cell.archive_hours);
  }
  if (ring_ || archive_) thread_ = std::thread(&SnapshotKeeper::work, this);
  service_ = nh.advertiseService(kSaveSnapshotService, &SnapshotKeeper::serve, this);
}

SnapshotKeeper::~SnapshotKeeper() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void SnapshotKeeper::note(CallRecord record) {
  const std::uint8_t status = record.answered.status;
  const std::lock_guard<std::mutex> lock(mutex_);
  latest_ = std::make_shared<const CallRecord>(std::move(record));
  if (status == Response::NO_PART_FOUND) saveBesides("NO_PART_FOUND");
  if (status == Response::DEADLOCK) saveBesides("DEADLOCK");
  archive();
}

void SnapshotKeeper::archive() {
  if (!archive_) return;
  const bool is_full = jobs_.size() + 1 >= kJobs;  // one place is left for what went wrong
  if (is_full && !misses_)
    ROS_WARN_STREAM("the disk is too slow for all calls to be kept in ~cell/archive_folder");
  misses_ = is_full;
  if (is_full) return;
  jobs_.push_back({latest_, "CALL", &*archive_});
  wake_.notify_all();
}

void SnapshotKeeper::reported(const bool success) {
  const std::lock_guard<std::mutex> lock(mutex_);
  failures_ = success ? 0 : failures_ + 1;
  if (failures_max_ > 0 && failures_ >= failures_max_) {
    saveBesides("FAILED_PICKS");
    failures_ = 0;
  }
}

void SnapshotKeeper::saveBesides(const std::string& reason) {
  if (!ring_ || !latest_) return;
  const auto now = std::chrono::steady_clock::now();
  const auto before = saved_at_.find(reason);
  if (before != saved_at_.end() && now - before->second < kQuiet) return;
  if (jobs_.size() >= kJobs) return;
  saved_at_[reason] = now;
  jobs_.push_back({latest_, reason, &*ring_});
  wake_.notify_all();
}

void SnapshotKeeper::work() {
  while (true) {
    Job job;
    {
      std::unique_lock<std::mutex> lock(mutex_);
      wake_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
      if (jobs_.empty()) return;  // what is waiting is written first
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    try {
      const std::string path = save(job);
      if (!archive_ || job.ring != &*archive_) ROS_INFO_STREAM("saved the snapshot " << path);
    } catch (const std::exception& error) {
      ROS_ERROR_STREAM("a snapshot could not be saved: " << error.what());
    }
  }
}

std::string SnapshotKeeper::save(const Job& job) {
  const std::lock_guard<std::mutex> lock(writing_);
  const CallRecord& record = *job.record;
  std::string changed;
  const auto files = partFiles(record, &changed);
  std::vector<planar_bin_picking::SnapshotText> texts{
      {"ros_request.txt", print(record.asked)},
      {"ros_answer.txt", print(record.answered)},
      {"ros_camera_info.txt", print(*record.answer.frame.info)},
      {"transform.txt", transformText(record)},
      {"settings.txt", describe(record.settings)}};
  if (!changed.empty())
    texts.push_back({"changed_since.txt", "# read before they were changed:" + changed + "\n"});
  const double now = ros::WallTime::now().toSec();
  const std::string path = job.ring->nextPath(now, job.reason);
  planar_bin_picking::writeSnapshot(
      path,
      {PACKAGE_VERSION, record.answer.grey, record.answer.camera, record.settings.locator,
       record.request, planar_bin_picking::resultText(record.answer.result)},
      files, texts);
  job.ring->trim(now);
  return path;
}

bool SnapshotKeeper::serve(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response) {
  Job job;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    job = {latest_, "ASKED_FOR", ring_ ? &*ring_ : nullptr};
  }
  response.success = false;
  if (!ring_) {
    response.message = "~cell/snapshot_folder is not set: name a folder for the snapshots";
  } else if (!job.record) {
    response.message = "no call has looked at an image yet; call ~locate_part first";
  } else {
    try {
      response.message = save(job);
      response.success = true;
    } catch (const std::exception& error) {
      response.message = error.what();
    }
  }
  return true;
}

}  // namespace planar_bin_picking_ros
