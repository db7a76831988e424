// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calibrator/sample_store.h"

#include <opencv2/imgcodecs.hpp>

#include <sstream>
#include <stdexcept>

namespace planar_bin_picking_ros {

using planar_bin_picking::HandEyeProblem;
using planar_bin_picking::SampleFolder;
using planar_bin_picking::SampleSet;

namespace {

std::string pngOf(const cv::Mat& image) {
  std::vector<unsigned char> bytes;
  if (!cv::imencode(".png", image, bytes)) {
    throw std::runtime_error("the picture cannot be written as PNG: OpenCV lacks it");
  }
  return {bytes.begin(), bytes.end()};
}

std::string cameraText(const std::string& frame, int width, int height) {
  return "\"" + frame + "\", " + std::to_string(width) + " x " + std::to_string(height);
}

}  // namespace

void checkCamera(const SampleSet& set, const Look& look) {
  const std::string& frame = look.frame.image->header.frame_id;
  const HandEyeProblem& problem = set.problem;
  if (frame == set.camera_frame && look.image.cols == problem.width &&
      look.image.rows == problem.height) {
    return;
  }
  throw std::runtime_error("the image is of another camera than the samples (" +
                           cameraText(frame, look.image.cols, look.image.rows) + ", was " +
                           cameraText(set.camera_frame, problem.width, problem.height) +
                           "); look for a second driver on the topic, or calibrate anew");
}

SampleStore::SampleStore(const CalibratorParams& params)
    : params_(params), folder_(params.output_folder) {}

void SampleStore::begin(const HandEyeProblem& empty, const Frame& frame) {
  folder_.begin();
  set_ = SampleSet{empty, frame.image->header.frame_id};
  set_->problem.observations.clear();
}

std::string SampleStore::add(const Look& look, const HandEyeProblem& empty) {
  if (!set_) begin(empty, look.frame);
  checkCamera(*set_, look);
  const std::string name = SampleFolder::nextName(*set_);
  set_->problem.observations.push_back(
      {name, look.T_base_flange, look.board.corners, look.board.ids});
  folder_.add(*set_, pngOf(look.image));
  return name;
}

void SampleStore::remove(std::size_t number) {
  if (number > size()) {
    throw std::runtime_error("there is no sample " + std::to_string(number) + " of " +
                             std::to_string(size()) + "; ~list_samples shows them");
  }
  if (number == 0) {
    if (set_) folder_.begin();
    set_.reset();
    return;
  }
  auto& observations = set_->problem.observations;
  const auto at = observations.begin() + static_cast<std::ptrdiff_t>(number - 1);
  const std::string name = at->name;
  observations.erase(at);
  folder_.remove(*set_, name);
}

void SampleStore::load() {
  SampleSet set = folder_.load();
  if (set.problem.board != params_.boardValue() ||
      set.problem.mounting != params_.mountingValue()) {
    throw std::runtime_error("the samples in " + params_.output_folder +
                             " are of another board or mounting than the parameters say; correct "
                             "these, or begin anew");
  }
  set_ = std::move(set);
}

std::string SampleStore::list() const {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(4);
  text << size() << (size() == 1 ? " sample" : " samples");
  for (std::size_t i = 0; i < size(); ++i) {
    const auto& observation = set_->problem.observations[i];
    text << "\n"
         << i + 1 << ": " << observation.name << " from ["
         << observation.T_base_flange.translation().transpose() << "] m";
  }
  return text.str();
}

std::string SampleStore::keptText() const {
  if (isEmpty()) return "";
  return "; " + std::to_string(size()) + (size() == 1 ? " sample is" : " samples are") +
         " kept: ~finish solves them";
}

}  // namespace planar_bin_picking_ros
