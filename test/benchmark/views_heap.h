// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// A simulated heap, pictures of it from where a robot would look, and the parts located in the
/// first of them, each with its truth.

#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/views/next_view.h"
#include "sim/simulated_cell.h"
#include "support/plates.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace planar_bin_picking {

/// What is the same for a whole run: part, light, picture size, and how far the camera may tilt.
struct HeapKind {
  std::string part, light;
  double megapixels = 1.3;
  double cone_deg = 45.0;  // as the calibrator's
};

struct FoundPart {
  Detection detection;
  Eigen::Isometry3d T_first_true;
  std::vector<Eigen::Isometry3d> symmetric_poses;
};

/// Views of one heap; the first looks down from above.
struct HeapPictures {
  std::vector<cv::Mat> images;
  std::vector<Eigen::Isometry3d> T_first_view;
  std::vector<FoundPart> found;  ///< those that a robot would be sent to, the best first
};

class ViewedHeap {
 public:
  explicit ViewedHeap(const HeapKind& kind)
      : kind_(kind), file_(std::string(PACKAGE_DIR) + "/test/data/parts/" + kind.part + ".yaml") {
    part_ = std::make_shared<const PartModel>(loadPartFile(file_));
    poured_ = cell::loadPartKind(file_);
    config_.light = kind.light;
    config_.counts = {20};
    config_.lens = cell::lensOver(config_.bin, kHeight, kind.megapixels);
    cell_ = std::make_unique<cell::SimulatedCell>(config_, std::vector<cell::PartKind>{poured_});
    camera_ = std::make_unique<const Camera>(makeCamera(config_.lens, config_.lens.d));
  }

  const HeapKind& kind() const { return kind_; }
  const PartModel& part() const { return *part_; }
  const Camera& camera() const { return *camera_; }

  /// Three views, fewer where no place is left to look from; the others are where `nextView`
  /// proposes them for the best part, with this robot.
  HeapPictures pour(int seed, const LocatorParams& params) {
    cell_->refill(static_cast<std::uint64_t>(seed));
    if (exposure_ <= 0.0) exposure_ = cell_->exposureFor(T_base_first_);  // a picture's time
    HeapPictures out;
    out.images.push_back(cell_->takePicture(T_base_first_, exposure_));
    out.T_first_view.push_back(Eigen::Isometry3d::Identity());
    out.found = locate(out.images.front());
    if (out.found.empty()) return out;
    Detection known = out.found.front().detection;
    for (int k = 0; k < 2; ++k) {
      const auto next = nextView(known, *part_, *camera_, T_base_first_, limits(), params);
      if (!next) break;
      out.T_first_view.push_back(next->T_first_camera);
      out.images.push_back(cell_->takePicture(T_base_first_ * next->T_first_camera, exposure_));
      known.covariance = next->covariance;
      known.views = k + 2;
    }
    return out;
  }

 private:
  static constexpr double kHeight = 0.75;   // of the first camera over the bin's floor, metres
  static constexpr double kVisible = 0.85;  // parts that a robot would be sent to
  static constexpr std::size_t kPartsPerHeap = 4;
  static constexpr double kFalse = 0.02;  // metres off: another bench counts false detections

  NextViewLimits limits() const {
    NextViewLimits limits;
    limits.box_min = {-0.8, -0.8, 0.3};
    limits.box_max = {0.8, 0.8, 0.85};
    limits.cone_deg = kind_.cone_deg;
    limits.focus = {0.45, 0.85};
    const cell::Bin& bin = config_.bin;
    limits.bin = ViewBin{Eigen::Isometry3d::Identity(),
                         {-0.5 * bin.length, -0.5 * bin.width, 0.0},
                         {0.5 * bin.length, 0.5 * bin.width, bin.height}};
    return limits;
  }

  /// The poured part that a detection is of; nothing for a false one.
  std::optional<FoundPart> truthOf(const Detection& detection) const {
    double least = kFalse;
    std::optional<FoundPart> found;
    const Eigen::Vector3d centre(part_->center().x(), part_->center().y(), 0.0);
    for (const cell::TruePart& truth : cell_->truth(T_base_first_)) {
      if (truth.front_up != (detection.face == Face::kFront) && poured_.symmetric_poses.size() < 2)
        continue;
      const Eigen::Isometry3d T = T_base_first_.inverse() * truth.T_base_part;
      const auto& same = truth.front_up ? poured_.symmetric_poses : poured_.back_symmetric_poses;
      for (const auto& T_part_same : same) {
        const double off = (T * T_part_same * centre - detection.T_camera_part * centre).norm();
        if (off >= least) continue;
        least = off;
        found = FoundPart{detection, T, same};
      }
    }
    return found;
  }

  std::vector<FoundPart> locate(const cv::Mat& image) const {
    LocateRequest request;
    request.parts = {part_};
    request.distance_min = kHeight - config_.bin.height;
    request.distance_max = kHeight + 0.01;
    std::vector<FoundPart> out;
    for (const Detection& d : Locator().locate(image, *camera_, request).detections) {
      if (d.visible_fraction < kVisible || out.size() == kPartsPerHeap) continue;
      if (const auto found = truthOf(d)) out.push_back(*found);
    }
    return out;
  }

  const HeapKind kind_;
  const std::string file_;
  PartPtr part_;
  cell::PartKind poured_;
  cell::CellConfig config_;
  std::unique_ptr<cell::SimulatedCell> cell_;
  std::unique_ptr<const Camera> camera_;
  double exposure_ = 0.0;
  const Eigen::Isometry3d T_base_first_ = Eigen::Translation3d(0.0, 0.0, kHeight) *
                                          Eigen::AngleAxisd(EIGEN_PI, Eigen::Vector3d::UnitX());
};

}  // namespace planar_bin_picking
