// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/views/look.h"

#include "base/parallel.h"
#include "image/profile.h"
#include "views/joint_pose.h"
#include "views/view_starts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>
#include <type_traits>

namespace planar_bin_picking {
namespace {

/// Share of the outline that the new picture has to show, and how far inside of it.
constexpr double kInPicture = 0.6, kBorderPx = 10.0;
/// Inlier scores: of a pose that fits a view; and what it may have less than the view's own best.
constexpr double kFits = 0.45, kWorse = 0.12;
/// From this on, a pose is one that has been seen, not one that chance made: asked of one view
/// alone, of the views that the pose was known from, and of all where they contradict what was
/// known.
constexpr double kClear = 0.65;
/// With less of the outline than kFits and more than this, something is in front of the part.
constexpr double kHidden = 0.3;
/// Squared standard deviations per number that a joint pose may be off what its views say: errors
/// have longer tails than a Gaussian, and a part that moved is off by far more.
constexpr double kChiSquared = 3.0;
/// A pose that differs by more of its own standard deviations, and by more than this many metres at
/// the outline, is another one.
constexpr double kSigmasOff = 5.0, kMetresOff = 0.001;
/// From this on it is another one however vague it was: a robot would have felt it.
constexpr double kMetresFar = 0.003;

/// The joint pose from one start, and how each view likes it.
struct Fit {
  JointPose pose;
  std::vector<double> scores;
  double mean = 0.0;
};

double shareInPicture(const SeenPart& seen, const View& view,
                      const Eigen::Isometry3d& T_view_centre) {
  int inside = 0;
  for (const LocalPoint& p : seen.coarse) {
    PosedPoint at;
    if (posePoint(view.camera(), p, seen.solid.radius, T_view_centre, &at) &&
        fitsInside(view.image(), at.pixel, kBorderPx))
      ++inside;
  }
  return static_cast<double>(inside) / static_cast<double>(seen.coarse.size());
}

Fit fitFrom(const SeenPart& seen, const std::vector<ViewPtr>& views,
            const JointAlignment& alignment, const Eigen::Isometry3d& T_first_centre) {
  Fit fit;
  fit.pose = alignment.align(alignment.startAt(T_first_centre));
  for (std::size_t k = 0; k < views.size(); ++k) {
    const JointState& state = fit.pose.state;
    fit.scores.push_back(
        scoreIn(seen, *views[k], viewPose(state, views, k), inward(seen.fine, state.offsets[k])));
    fit.mean += fit.scores.back() / static_cast<double>(views.size());
  }
  return fit;
}

/// From all starts, the one that the views like best.
Fit bestFit(const SeenPart& seen, const std::vector<ViewPtr>& views, double offset,
            const Eigen::Isometry3d& T_known, const std::vector<ViewStart>& found,
            const LocatorParams& params) {
  std::vector<Eigen::Isometry3d> starts{T_known};
  for (const ViewStart& start : found) {
    starts.push_back(start.T_first_centre);
    starts.push_back(views.back()->T_first_this() * start.own.T_camera_centre);
  }
  const JointAlignment alignment(seen, views, offset, params.views);
  std::vector<Fit> fits(starts.size());
  parallelFor(static_cast<int>(starts.size()), params.threads, [&](int i) {
    const auto at = static_cast<std::size_t>(i);
    fits[at] = fitFrom(seen, views, alignment, starts[at]);
  });
  return *std::max_element(fits.begin(), fits.end(),
                           [](const Fit& a, const Fit& b) { return a.mean < b.mean; });
}

/// What a view that took part before says of the known pose by itself.
double ownScore(const SeenPart& seen, const View& view, double offset_radii,
                const Eigen::Isometry3d& T_known) {
  const EdgeMap edges = edgesOf(view);
  const auto points = inward(seen.fine, offset_radii);
  Eigen::Isometry3d T = view.T_first_this().inverse() * T_known;
  const double before = scoreIn(seen, view, T, points);
  for (const double tukey : {3.0, 2.0}) {
    T = alignInImage(edges, view.camera(), points, seen.solid, T, {4, true, 0.8}, tukey)
            .T_camera_centre;
  }
  return std::max(before, scoreIn(seen, view, T, points));
}

Matrix6d inMetres(const Matrix6d& covariance, double radius) {
  Vector6d unit;
  unit << radius, radius, radius, 1.0, 1.0, 1.0;
  return unit.asDiagonal() * covariance * unit.asDiagonal();
}

/// Whether the pose is another one than was known.
bool isAnother(const Detection& known, const Eigen::Isometry3d& T_known,
               const Eigen::Isometry3d& T_now, const Matrix6d& covariance, double radius) {
  const Vector6d off = log(T_known.inverse() * T_now);
  const Matrix6d both = known.covariance + covariance;
  const double sigmas = std::sqrt(std::max(0.0, off.dot(both.ldlt().solve(off))));
  const double metres = off.head<3>().norm() + radius * off.tail<3>().norm();
  return (sigmas > kSigmasOff && metres > kMetresOff) || off.head<3>().norm() > kMetresFar;
}

/// EIGEN_PI is a long double, which no pattern here takes.
constexpr double kInDegrees = 180.0 / static_cast<double>(EIGEN_PI);

template <class... Values>
std::string text(const char* pattern, Values... values) {
  static_assert((!std::is_same_v<Values, long double> && ...), "%f reads a double");
  char out[300];
  std::snprintf(out, sizeof out, pattern, values...);
  return out;
}

void setMoved(const Eigen::Isometry3d& T_known, const Eigen::Isometry3d& T_now, LookResult* out) {
  out->moved = (T_now.translation() - T_known.translation()).norm();
  out->moved_rad = rotationAngle((T_known.inverse() * T_now).linear());
}

}  // namespace

const char* nameOf(LookStatus status) {
  switch (status) {
    case LookStatus::kConfirmed:
      return "confirmed";
    case LookStatus::kCorrected:
      return "corrected";
    case LookStatus::kMoved:
      return "moved";
    case LookStatus::kContradicted:
      return "contradicted";
    case LookStatus::kNotSeen:
      break;
  }
  return "not_seen";
}

Looker::Looker(const LocatorParams& params) : params_(params) {
  validate(params_);
  if (params_.threads == 0) {
    params_.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  }
}

/// What the views say, before it is judged.
struct Looker::Seen {
  SeenPart part;
  Eigen::Isometry3d T_known;
  std::vector<ViewStart> found;  ///< in the new view alone, best first
  Fit fit;
  std::vector<double> own;  ///< by view: score of its own best pose
};

LookResult Looker::look(const Detection& known, const PartModel& part,
                        const std::vector<ViewPtr>& views) const {
  if (views.size() < 2) throw std::invalid_argument("look: at least two views are needed");
  Seen seen{SeenPart(part, known.face, params_.refine), Eigen::Isometry3d::Identity(), {}, {}, {}};
  seen.T_known = known.T_camera_part * seen.part.T_part_centre;
  const View& view = *views.back();
  LookResult out;
  out.detection = known;
  const double share =
      shareInPicture(seen.part, view, view.T_first_this().inverse() * seen.T_known);
  if (share < kInPicture) {
    out.text = text(
        "the picture shows %.0f %% of the part's outline: bring the camera to where it is seen, as "
        "~next_view proposes",
        100.0 * share);
    return out;
  }
  const double sigma = std::sqrt(std::max(0.0, known.covariance.topLeftCorner<3, 3>().trace()));
  constexpr double kSigmasSought = 4.0;
  const double reach = std::max(params_.views.depth_reach, kSigmasSought * sigma);
  seen.found = bestStarts(seen.part, view, known.edge_offset,
                          startsAbout(seen.part, seen.T_known, view, reach), params_.threads);
  seen.fit = bestFit(seen.part, views, known.edge_offset, seen.T_known, seen.found, params_);
  for (std::size_t k = 0; k + 1 < views.size(); ++k) {
    seen.own.push_back(
        ownScore(seen.part, *views[k], known.edge_offset / part.radius(), seen.T_known));
  }
  seen.own.push_back(seen.found.empty() ? 0.0 : seen.found.front().score);
  judge(known, views, seen, &out);
  return out;
}

LookResult Looker::look(const PartModel& part, const ViewPtr& view, TrackedPart* tracked) const {
  std::vector<ViewPtr> views = tracked->views;
  views.push_back(view);
  const LookResult result = look(tracked->detection, part, views);
  if (result.status == LookStatus::kConfirmed || result.status == LookStatus::kCorrected)
    *tracked = {result.detection, views};
  return result;
}

void Looker::judge(const Detection& known, const std::vector<ViewPtr>& views, const Seen& seen,
                   LookResult* out) const {
  const double radius = seen.part.solid.radius;
  const Fit& fit = seen.fit;
  out->seen = std::max(fit.scores.back(), seen.own.back());
  const Matrix6d covariance = inMetres(fit.pose.covariance, radius);
  const Eigen::Isometry3d T = facePose(fit.pose.state, known.face, radius);
  const bool another = isAnother(known, seen.T_known, T, covariance, radius);
  bool fits = fit.pose.chi_squared < kChiSquared * std::max(1, fit.pose.freedom);
  for (std::size_t k = 0; k < views.size(); ++k) {
    const bool is_new = k + 1 == views.size();
    const double enough = is_new && !another ? kFits : kClear;
    fits = fits && fit.scores[k] > enough && fit.scores[k] > seen.own[k] - kWorse;
  }
  const auto place = [&](const Eigen::Isometry3d& T_first_centre, const Matrix6d& uncertainty) {
    out->detection.T_camera_part = T_first_centre * seen.part.T_part_centre.inverse();
    out->detection.covariance = uncertainty;
    setMoved(seen.T_known, T_first_centre, out);
  };
  if (fits) {
    out->status = another ? LookStatus::kCorrected : LookStatus::kConfirmed;
    place(T, covariance);
    out->detection.views = static_cast<int>(views.size());
    out->detection.edge_offset = radius * fit.pose.state.offsets.front();
    out->text = text(
        "%zu views agree (chi squared %.1f of %d), %.2f mm and %.2f degrees from what was known",
        views.size(), fit.pose.chi_squared, fit.pose.freedom, 1e3 * out->moved,
        kInDegrees * out->moved_rad);
    return;
  }
  const bool was_seen =
      std::all_of(seen.own.begin(), seen.own.end(), [](double own) { return own > kClear; });
  if (was_seen) {
    out->status = LookStatus::kMoved;
    out->detection.views = 1;
    const ImagePose& own = seen.found.front().own;
    place(views.back()->T_first_this() * own.T_camera_centre, inMetres(own.covariance, radius));
    out->text = text("seen in either view, but %.2f mm and %.2f degrees apart: locate again",
                     1e3 * out->moved, kInDegrees * out->moved_rad);
  } else if (!another && fit.scores.back() > kHidden && fit.scores.back() < kFits &&
             fit.scores.front() > kFits) {
    out->status = LookStatus::kNotSeen;
    out->text = text(
        "%.0f %% of its outline is borne out: something is in front of it; look from "
        "another side",
        100.0 * fit.scores.back());
  } else {
    out->status = LookStatus::kContradicted;
    out->text = text(
        "the part is not there: no pose fits (%.0f %% of its outline in the first view, %.0f %% in "
        "the new one; %.0f and %.0f %% by themselves; chi squared %.0f of %d); locate again",
        100.0 * fit.scores.front(), 100.0 * fit.scores.back(), 100.0 * seen.own.front(),
        100.0 * seen.own.back(), fit.pose.chi_squared, fit.pose.freedom);
  }
}

}  // namespace planar_bin_picking
