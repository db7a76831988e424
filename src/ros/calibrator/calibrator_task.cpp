// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/calibrator_task.h"

#include <stdexcept>

namespace planar_bin_picking_ros {

namespace {

std::string refusal(const CalibratorTask::Kind under_way) {
  using Kind = CalibratorTask::Kind;
  const std::string later = " is under way; call again once it has answered";
  switch (under_way) {
    case Kind::kRun:
      return "a calibration is under way; ~abort ends it";
    case Kind::kPlan:
      return "~plan" + later;
    case Kind::kAddSample:
      return "~add_sample" + later;
    case Kind::kSamples:
      return "another call about samples" + later;
    case Kind::kVerify:
      return "~verify" + later;
    case Kind::kFinish:
      return "~finish" + later;
    case Kind::kNone:
      break;
  }
  return "the calibrator is ending; start it again";
}

}  // namespace

CalibratorTask::Hold CalibratorTask::begin(Kind kind, const std::function<void()>& prepare) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (is_closed_) throw std::runtime_error(refusal(Kind::kNone));
  if (kind_ != Kind::kNone) throw std::runtime_error(refusal(kind_));
  prepare();
  kind_ = kind;
  return Hold(this);
}

bool CalibratorTask::duringRun(const std::function<void()>& act) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (kind_ != Kind::kRun) return false;
  act();
  return true;
}

bool CalibratorTask::close(const std::function<void()>& act) {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_closed_ = true;
  act();
  return kind_ == Kind::kRun;
}

void CalibratorTask::end() {
  const std::lock_guard<std::mutex> lock(mutex_);
  kind_ = Kind::kNone;
}

}  // namespace planar_bin_picking_ros
