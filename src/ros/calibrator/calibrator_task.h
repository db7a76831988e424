// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// What the calibrator is about: one thing at a time. Whoever holds the task alone may look, move
/// and write; all others are told what is under way.

#include <functional>
#include <mutex>
#include <string>
#include <utility>

namespace planar_bin_picking_ros {

class CalibratorTask {
 public:
  enum class Kind { kNone, kRun, kPlan, kAddSample, kSamples, kFinish, kVerify };

  /// Ends the task with itself.
  class Hold {
   public:
    explicit Hold(CalibratorTask* task) : task_(task) {}
    Hold(Hold&& other) noexcept : task_(std::exchange(other.task_, nullptr)) {}
    Hold& operator=(Hold&&) = delete;
    ~Hold() { release(); }
    void release() {
      if (task_ != nullptr) std::exchange(task_, nullptr)->end();
    }

   private:
    CalibratorTask* task_;
  };

  /// @param prepare  called before anybody can ask for a stop
  /// @throws std::runtime_error  another task is under way, or the node ends: which, and what to do
  Hold begin(Kind kind, const std::function<void()>& prepare);

  /// Calls `act` while a run is under way and goes on. @return  false where there is none
  bool duringRun(const std::function<void()>& act);

  /// Nothing begins any more. Calls `act` at that moment. @return  whether a run is under way
  bool close(const std::function<void()>& act);

 private:
  void end();

  std::mutex mutex_;
  Kind kind_ = Kind::kNone;
  bool is_closed_ = false;
};

}  // namespace planar_bin_picking_ros
