// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// `--view IMAGE CAMERA POSE` of locate_image: further pictures of the same scene.

#include "planar_bin_picking/image/camera_file.h"
#include "planar_bin_picking/locate/locator.h"
#include "planar_bin_picking/views/look.h"
#include "planar_bin_picking/views/pose_file.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace planar_bin_picking {

struct ViewFiles {
  std::string image, camera, pose;
};

/// Three words for each view, as the command line gives them.
inline std::vector<ViewFiles> viewFiles(const std::vector<std::string>& words) {
  if (words.size() % 3 != 0)
    throw std::invalid_argument("--view: give IMAGE CAMERA POSE each time, three files");
  std::vector<ViewFiles> files;
  for (std::size_t i = 0; i < words.size(); i += 3)
    files.push_back({words[i], words[i + 1], words[i + 2]});
  return files;
}

/// What the last look at a detection said.
struct Looked {
  Detection detection;
  LookResult last;
};

/// Looks at each detection in each view, in order, until one says that it is not where it was.
/// @param load  (path, camera) -> image, one channel
template <class Load>
std::vector<Looked> lookInViews(const cv::Mat& first, const Camera& first_camera,
                                const std::vector<ViewFiles>& files, const LocatorParams& params,
                                const std::vector<PartPtr>& parts,
                                const std::vector<Detection>& detections, Load&& load,
                                double* seconds) {
  std::vector<ViewPtr> views;
  const auto add = [&](const cv::Mat& image, const Camera& camera, const Eigen::Isometry3d& T) {
    views.push_back(std::make_shared<const View>(image, camera, T, params.edges));
  };
  add(first, first_camera, Eigen::Isometry3d::Identity());
  for (const ViewFiles& f : files) {
    const Camera camera = loadCamera(f.camera);
    add(load(f.image, camera), camera, loadPose(f.pose));
  }
  const auto start = std::chrono::steady_clock::now();
  const Looker looker(params);
  std::vector<Looked> out;
  for (const Detection& detection : detections) {
    TrackedPart tracked{detection, {views.front()}};
    Looked looked{detection, {}};
    for (std::size_t k = 1; k < views.size(); ++k) {
      looked.last = looker.look(*parts[detection.part], views[k], &tracked);
      looked.detection = looked.last.detection;
      const LookStatus status = looked.last.status;
      if (status == LookStatus::kMoved || status == LookStatus::kContradicted) break;
    }
    out.push_back(looked);
  }
  *seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

}  // namespace planar_bin_picking
