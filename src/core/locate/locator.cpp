// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/locator.h"

#include "image/edges.h"
#include "locate/answer_request.h"
#include "locate/judge/rank.h"
#include "locate/judge/score.h"
#include "locate/prior/scene_plane_prior.h"
#include "locate/refine/refine.h"
#include "locate/vote/hough.h"
#include "part/visible_face.h"
#include "planar_bin_picking/locate/prior/plane_prior.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <thread>

namespace planar_bin_picking {
namespace {

/// Pixels: a driver may add or drop a column or two at the far edge; more is another camera or
/// another size.
constexpr int kSlack = 2;
/// Pixels to a side: a smaller image cannot show a part (kLeastLengthPx of part_extent.h).
constexpr int kLeastSide = 64;

/// Times the stages into a Report.
class Clock {
 public:
  explicit Clock(Report* report) : report_(report) {}
  void finish(const std::string& stage, std::size_t out) {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    report_->stages.push_back({stage, seconds, out});
    report_->seconds += seconds;
    last_ = now;
  }

 private:
  Report* report_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

[[noreturn]] void refuse(const std::string& what) {
  throw std::invalid_argument("locate: " + what);
}

void check(const cv::Mat& image, const Camera& camera, const LocateRequest& request) {
  if (image.empty()) refuse("the image is empty");
  if (image.channels() != 1 || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    refuse("the image has " + std::to_string(image.channels()) + " channels of depth " +
           std::to_string(image.depth()) + "; give one channel of 8 or 16 bit");
  }
  if (std::abs(image.cols - camera.model().width) > kSlack ||
      std::abs(image.rows - camera.model().height) > kSlack) {
    refuse("the image is " + std::to_string(image.cols) + " x " + std::to_string(image.rows) +
           ", the camera info " + std::to_string(camera.model().width) + " x " +
           std::to_string(camera.model().height) + "; they must be of one size");
  }
  if (image.cols < kLeastSide || image.rows < kLeastSide) {
    const std::string side = std::to_string(kLeastSide);
    refuse("the image is smaller than " + side + " x " + side + " pixels");
  }
  if (request.parts.empty()) refuse("no part is given");
  for (const auto& part : request.parts)  // and the distances
    checkPartSize(*part, camera, request.distance_min, request.distance_max);
}

bool showsFace(const RefinedPose& pose,
               const std::vector<std::shared_ptr<const PartModel>>& parts) {
  return showsFace(*parts[pose.part], pose.T_camera_part, pose.face);
}

/// What of the picture is looked at, with the camera that sees no more.
struct Looked {
  cv::Mat image;
  Camera camera;
};

Looked cut(const cv::Mat& image, const Camera& camera, const std::optional<PixelBox>& window) {
  if (!window) return {image, camera};
  Camera::Model model = camera.model();
  // A camera's principal point lies in its picture.
  const int cx = static_cast<int>(model.cx), cy = static_cast<int>(model.cy);
  const int left = std::clamp(std::min(window->left, cx), 0, image.cols - 1);
  const int top = std::clamp(std::min(window->top, cy), 0, image.rows - 1);
  const int right = std::clamp(std::max(window->left + window->width, cx + 2), left, image.cols);
  const int bottom = std::clamp(std::max(window->top + window->height, cy + 2), top, image.rows);
  if (std::min(right - left, bottom - top) < kLeastSide) return {image, camera};
  model.width = right - left;
  model.height = bottom - top;
  model.cx -= left;
  model.cy -= top;
  return {image(cv::Rect(left, top, model.width, model.height)).clone(), Camera(model)};
}

/// A robot sent to a pose whose z says the other face than `face` would come from the wrong side.
void dropContradictions(const std::vector<std::shared_ptr<const PartModel>>& parts,
                        std::vector<RefinedPose>* poses) {
  const auto contradicts = [&](const RefinedPose& pose) { return !showsFace(pose, parts); };
  poses->erase(std::remove_if(poses->begin(), poses->end(), contradicts), poses->end());
}

}  // namespace

Locator::Locator(const LocatorParams& params) : params_(params) {
  validate(params_);
  if (params_.threads == 0) {
    params_.threads = std::max(1u, std::thread::hardware_concurrency());
  }
}

Distances Locator::searched(const Camera& camera, const LocateRequest& request,
                            const PartModel& part, const std::optional<Plane>& plane) const {
  const Distances asked{request.distance_min, request.distance_max};
  if (!plane) return asked;
  const auto on_plane = distancesOnPlane(camera, *plane, part.thickness(), asked, params_.plane);
  if (!on_plane) {
    refuse("on the plane " + std::to_string(plane->distance) + " m away, part " + part.name() +
           " would lie outside of the distances " + std::to_string(asked.min) + " .. " +
           std::to_string(asked.max) + " m");
  }
  return *on_plane;
}

LocateResult Locator::locate(const cv::Mat& whole, const Camera& whole_camera,
                             const LocateRequest& request) const {
  check(whole, whole_camera, request);
  const auto [image, camera] = cut(whole, whole_camera, request.window);
  LocateResult result;
  Clock clock(&result.report);
  const int threads = params_.threads;

  std::vector<double> radii_px;
  const double distance = std::sqrt(request.distance_min * request.distance_max);
  for (const auto& part : request.parts)
    radii_px.push_back(camera.model().fx * part->radius() / distance);
  const EdgeMap edges = findEdges(image, camera, radii_px, params_.edges, threads);
  clock.finish("edges", edges.edgels);

  const std::optional<Plane> plane = request.plane ? request.plane : planeOf(params_.plane);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < request.parts.size(); ++i) {
    const Distances distances = searched(camera, request, *request.parts[i], plane);
    const HoughTask task{request.parts[i].get(), i, distances.min, distances.max};
    const auto found = findCandidates(edges, task, params_.hough, threads);
    candidates.insert(candidates.end(), found.begin(), found.end());
  }
  clock.finish("hough", candidates.size());

  auto refined = refineCandidates(edges, camera, request.parts, candidates, request.floor_normal,
                                  params_.rank.overlap_max, params_.refine, threads);
  if (!plane) fuseWithScenePlane(request.parts, &refined);
  clock.finish("refine", refined.size());

  if (plane) {  // known, it says more than the parts do of one another
    refined = fuseWithPlane(refined, request.parts, *plane, params_.plane);
    clock.finish("plane", refined.size());
  }

  dropContradictions(request.parts, &refined);
  const auto scored = scorePoses(edges, camera, request.parts, refined, params_.score, threads);
  clock.finish("score", scored.size());

  const auto ranked = rankPoses(scored, request.parts, params_.score.threshold, params_.rank);
  answerRequest(ranked, request, camera, params_.refine.tilt_limit_deg, &result);
  assert(std::all_of(result.detections.begin(), result.detections.end(),
                     [&](const Detection& d) { return showsFace(d, request.parts); }));
  clock.finish("rank", result.detections.size());
  return result;
}

}  // namespace planar_bin_picking
