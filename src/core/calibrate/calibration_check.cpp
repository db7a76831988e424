// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/calibration_check.h"

#include "calibrate/hand_eye/chain.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>

namespace planar_bin_picking {
namespace {

using Finding = CalibrationCheck::Finding;

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr std::size_t kViewsMost = 3;
/// Nothing is taken for better known than this: pixels, metres, radians.
constexpr double kPixelLeast = 0.1, kRobotMetresLeast = 5e-5, kRobotRadiansLeast = 1e-4;
/// A part that is free: no prior worth the name. Pixels, metres or radians.
constexpr double kFree = 1e3;
/// Of the chi-squared distribution with six degrees of freedom, beyond it one time in a thousand.
constexpr double kUnlikely = 22.5;
/// The better of two explanations has to be so much better.
constexpr double kClearlyBetter = 10.0;
/// Corners that fit so much worse than their noise, in standard deviations, fit nothing.
constexpr double kNoFit = 4.0;
constexpr double kSure = 3.0;
constexpr int kRounds = 20;

/// What is free, as columns of SharedMatrix.
struct Part {
  Finding finding;
  Eigen::Index first, count;
};
constexpr Part kNothing{Finding::kHolds, 0, 0};
constexpr Part kCamera{Finding::kCameraMoved, kHandEye, 6};
constexpr Part kTheBoard{Finding::kBoardMoved, kBoard, 6};
constexpr Part kLens{Finding::kLensChanged, kIntrinsics, 4};

/// Normal equations over the shared parameters and a correction of each robot pose.
class Explanation {
 public:
  Explanation(const HandEyeProblem& problem, const HandEyeResult& calibrated,
              const std::vector<Observation>& views, const Part& part)
      : problem_(problem), views_(views), part_(part) {
    chain_ = chainOf(problem, calibrated);
    pixel_ = std::max(kPixelLeast, calibrated.sigma_px);
    const double robot_t = std::max(kRobotMetresLeast, 1e-3 * calibrated.robot_mm);
    const double robot_r = std::max(kRobotRadiansLeast, calibrated.robot_deg / kDegrees);
    size_ = kSharedSize + 6 * static_cast<Eigen::Index>(views.size());
    // What is held fixed in the calibration has no variance; here it gets next to none.
    Eigen::MatrixXd prior = calibrated.covariance;
    constexpr double kFixed = 1e-9;
    prior.diagonal().array() += kFixed * kFixed;
    for (Eigen::Index i = part.first; i < part.first + part.count; ++i) {
      prior.row(i).setZero();
      prior.col(i).setZero();
      prior(i, i) = kFree * kFree;
    }
    information_ = Eigen::MatrixXd::Zero(size_, size_);
    information_.topLeftCorner<kSharedSize, kSharedSize>() =
        prior.ldlt().solve(Eigen::MatrixXd::Identity(kSharedSize, kSharedSize));
    for (Eigen::Index i = kSharedSize; i < size_; ++i) {
      const double sigma = (i - kSharedSize) % 6 < 3 ? robot_t : robot_r;
      information_(i, i) = 1.0 / (sigma * sigma);
    }
    solve();
  }

  double cost() const { return cost_; }
  std::size_t corners() const {
    std::size_t count = 0;
    for (const Observation& view : views_) count += view.corners.size();
    return count;
  }
  /// Of the free part.
  Eigen::VectorXd moved() const { return state_.segment(part_.first, part_.count); }
  /// Root of the mean square residual of a coordinate, in standard deviations.
  double misfit() const { return std::sqrt(corner_cost_ / (2.0 * static_cast<double>(corners()))); }
  /// Of the free part; what the views and all priors leave open.
  Eigen::MatrixXd covariance() const {
    const Eigen::MatrixXd all = normal_.ldlt().solve(Eigen::MatrixXd::Identity(size_, size_));
    return all.block(part_.first, part_.first, part_.count, part_.count);
  }

 private:
  /// @return  false where a board is not in front of the camera
  bool evaluate(const Eigen::VectorXd& state, Eigen::MatrixXd* normal, Eigen::VectorXd* gradient,
                double* cost, double* corner_cost) const {
    *normal = information_;
    *gradient = information_ * state;
    *cost = state.dot(*gradient);
    *corner_cost = 0.0;
    Chain chain = chain_;
    for (std::size_t i = 0; i < chain.intrinsics.size(); ++i) {
      chain.intrinsics[i] += state[static_cast<Eigen::Index>(i)];
    }
    for (std::size_t v = 0; v < views_.size(); ++v) {
      const Eigen::Index at = kSharedSize + 6 * static_cast<Eigen::Index>(v);
      Increment increment;
      increment.mount_camera = state.segment<6>(kHandEye);
      increment.other_board = state.segment<6>(kBoard);
      increment.correction = state.segment<6>(at);
      const auto seen = predict(chain, views_[v].T_base_flange, increment,
                                views_[v].points(problem_.board), true);
      if (!seen) return false;
      Eigen::VectorXd off(seen->pixels.size());
      for (Eigen::Index i = 0; i < off.size(); ++i) {
        off[i] = views_[v].corners[static_cast<std::size_t>(i / 2)][i % 2] - seen->pixels[i];
      }
      off /= pixel_;
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(off.size(), size_);
      J.leftCols<kSharedSize>() = seen->shared.leftCols<kSharedSize>() / pixel_;
      J.middleCols<6>(at) = seen->correction / pixel_;
      *normal += J.transpose() * J;
      *gradient -= J.transpose() * off;
      *corner_cost += off.squaredNorm();
    }
    *cost += *corner_cost;
    return true;
  }

  /// Levenberg and Marquardt.
  void solve() {
    state_ = Eigen::VectorXd::Zero(size_);
    Eigen::VectorXd gradient;
    cost_ = std::numeric_limits<double>::infinity();
    if (!evaluate(state_, &normal_, &gradient, &cost_, &corner_cost_)) return;
    double damping = 1e-6;
    for (int round = 0; round < kRounds; ++round) {
      Eigen::MatrixXd damped = normal_;
      damped.diagonal() *= 1.0 + damping;
      const Eigen::VectorXd next = state_ - damped.ldlt().solve(gradient);
      Eigen::MatrixXd normal;
      Eigen::VectorXd slope;
      double cost = 0.0, corner_cost = 0.0;
      if (next.allFinite() && evaluate(next, &normal, &slope, &cost, &corner_cost) &&
          cost < cost_) {
        const bool is_done = cost_ - cost < 1e-6 * (1.0 + cost_);
        state_ = next;
        normal_ = normal;
        gradient = slope;
        cost_ = cost;
        corner_cost_ = corner_cost;
        if (is_done) return;
        damping *= 0.1;
      } else {
        damping *= 10.0;
      }
    }
  }

  const HandEyeProblem& problem_;
  const std::vector<Observation>& views_;
  const Part part_;
  Chain chain_;
  double pixel_ = 1.0;
  Eigen::Index size_ = 0;
  Eigen::MatrixXd information_, normal_;
  Eigen::VectorXd state_;
  double cost_ = 0.0, corner_cost_ = 0.0;
};

/// The corners in the order that fits best what the calibration expects.
std::vector<Observation> inOrder(const HandEyeProblem& problem, const HandEyeResult& calibrated,
                                 std::vector<Observation> views) {
  for (Observation& view : views) {
    double best = std::numeric_limits<double>::infinity();
    std::vector<Eigen::Vector2d> ordered = view.corners;
    // A board of which parts may be seen has one order alone.
    if (!view.ids.empty()) continue;
    for (const std::vector<std::size_t>& order : orderings(problem.board)) {
      Observation turned = view;
      for (std::size_t i = 0; i < order.size(); ++i) turned.corners[i] = view.corners[order[i]];
      const std::vector<Observation> one{turned};
      const double cost = Explanation(problem, calibrated, one, kCamera).cost();
      if (!(cost < best)) continue;
      best = cost;
      ordered = turned.corners;
    }
    view.corners = ordered;
  }
  return views;
}

void setMoved(const Explanation& explanation, CalibrationCheck* check) {
  const Eigen::VectorXd moved = explanation.moved();
  const Eigen::MatrixXd covariance = explanation.covariance();
  check->moved_mm = 1e3 * moved.head<3>().norm();
  check->moved_deg = kDegrees * moved.tail<3>().norm();
  check->expected_mm = 1e3 * kSure * std::sqrt(covariance.topLeftCorner<3, 3>().trace());
  check->expected_deg = kDegrees * kSure * std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

std::string sentence(const CalibrationCheck& check, std::size_t views) {
  std::ostringstream by, text;
  by.imbue(std::locale::classic());
  text.imbue(std::locale::classic());
  by.precision(3);
  text.precision(3);
  by << "by " << check.moved_mm << " mm and " << check.moved_deg << " deg; up to "
     << check.expected_mm << " mm and " << check.expected_deg << " deg would be expected";
  switch (check.finding) {
    case Finding::kHolds:
      text << "the calibration holds: the camera seems to have moved " << by.str();
      break;
    case Finding::kBoardMoved:
      text << "the calibration holds: the board alone has moved, " << by.str();
      break;
    case Finding::kCameraMoved:
      text << "the camera has moved on its mount " << by.str() << "; fasten it and calibrate anew";
      break;
    case Finding::kLensChanged:
      text << "the lens has changed: the focal length by " << check.focal_percent
           << " %; look at focus and zoom, and calibrate anew";
      break;
    case Finding::kCameraOrBoard:
      text << "camera or board has moved " << by.str()
           << (views < kViewsMost
                   ? "; a further view, turned by 20 deg or more about another axis, "
                     "may tell which"
                   : "; these views do not tell which: calibrate anew");
      break;
    case Finding::kUnexplained:
      text << "what is seen fits neither a camera, a board nor a lens that changed: look for a "
              "robot "
              "that lost its reference, a bent board, or several of these; calibrate anew";
      break;
  }
  return text.str();
}

void validate(const HandEyeProblem& problem, const HandEyeResult& calibrated,
              const std::vector<Observation>& views) {
  if (views.empty() || views.size() > kViewsMost) {
    throw std::invalid_argument("a check takes 1 to 3 views, got " + std::to_string(views.size()));
  }
  if (!calibrated.solved) throw std::invalid_argument("the calibration has no solution to check");
  HandEyeProblem of_views = problem;
  of_views.observations = views;
  validate(of_views);
}

}  // namespace

CalibrationCheck checkCalibration(const HandEyeProblem& problem, const HandEyeResult& calibrated,
                                  const std::vector<Observation>& given) {
  validate(problem, calibrated, given);
  const std::vector<Observation> views = inOrder(problem, calibrated, given);
  const Explanation nothing(problem, calibrated, views, kNothing);
  const Explanation camera(problem, calibrated, views, kCamera);
  const Explanation board(problem, calibrated, views, kTheBoard);
  const Explanation lens(problem, calibrated, views, kLens);
  const double best = std::min({camera.cost(), board.cost(), lens.cost()});
  // Where corners fit worse than their noise, so do all explanations.
  const double scale =
      std::max(1.0, std::pow(std::min({camera.misfit(), board.misfit(), lens.misfit()}), 2.0));
  const double unlikely = kUnlikely * scale, clearly = kClearlyBetter * scale;
  CalibrationCheck check;
  const bool is_board = board.cost() <= camera.cost();
  setMoved(is_board && nothing.cost() - best >= unlikely ? board : camera, &check);
  if (std::sqrt(scale) > kNoFit || !std::isfinite(best)) {
    check.finding = Finding::kUnexplained;
  } else if (nothing.cost() - best < unlikely) {
    check.finding = Finding::kHolds;
  } else if (lens.cost() + clearly < std::min(camera.cost(), board.cost())) {
    check.finding = Finding::kLensChanged;
    check.focal_percent = 100.0 * lens.moved()[0] / calibrated.camera.fx;
  } else if (std::abs(board.cost() - camera.cost()) < clearly) {
    check.finding = Finding::kCameraOrBoard;
  } else {
    check.finding = is_board ? Finding::kBoardMoved : Finding::kCameraMoved;
  }
  check.text = sentence(check, views.size());
  return check;
}

}  // namespace planar_bin_picking
