// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "locate/vote/hough.h"

#include "image/edges.h"
#include "locate/vote/vote_planes.h"
#include "part/pose_distance.h"
#include "support/matchers.h"
#include "support/plates.h"

#include <gtest/gtest.h>

#include <cmath>

namespace planar_bin_picking {
namespace {

const sim::PinholeCamera kCamera;

EdgeMap edgesOf(const sim::Scene& scene) {
  return findEdges(sim::takeImage(kCamera, scene), makeCamera(kCamera), {}, 1);
}

std::vector<Candidate> candidatesOf(const EdgeMap& edges, const PartModel& part,
                                    const HoughParams& params = {}, int threads = 1) {
  return findCandidates(edges, {&part, 0, 0.55, 0.65}, params, threads);
}

/// Nearest candidate of the true face, in radii of the part.
double nearest(const std::vector<Candidate>& candidates, const PartModel& part,
               const Eigen::Isometry3d& truth) {
  double best = 1e9;
  for (const Candidate& c : candidates) {
    if (c.face != faceOf(truth)) continue;
    best = std::min(best, poseDistance(part, c.T_camera_part, truth, c.face));
  }
  return best;
}

/// What the refinement must make up for: a quarter of a radius at the rim (a cell, a yaw step and
/// half the step between two foreshortenings together), 3 % in distance.
constexpr double kWithin = 0.25;

// Neighbouring rows and planes share the empty cells between them.
TEST(Hough, PointsOutOfThePictureGetNoVotes) {
  Field field;
  field.width = 21;
  field.height = 13;
  field.distance.assign(static_cast<std::size_t>(21 * 13 * kDirections), 0);  // edges everywhere
  VotePlanes planes = sizePlanes(field, 1.0, 5.0);
  fillPlanes(field, 1.0, 1, &planes);
  const int right = planes.cols + planes.pad + kChunk - 1, below = planes.rows + planes.pad;
  for (int direction = 0; direction < kDirections; ++direction) {
    for (int y = -2 * planes.pad; y < 2 * below; ++y) {
      for (int x = -2 * planes.pad; x < 2 * right; ++x) {
        const std::size_t at = planes.offset(direction, x, y);
        ASSERT_LT(planes.byteOf(at), planes.votes.size()) << direction << " " << x << " " << y;
        const bool inside = x >= 0 && x < field.width && y >= 0 && y < field.height;
        const int votes = inside ? kMaxVote : 0;
        ASSERT_EQ(planes.votes[planes.byteOf(at)] & 15, votes) << direction << " " << x << " " << y;
        if (at == 0) continue;
        ASSERT_EQ(planes.votes[planes.byteOf(at - 1)] >> 4, votes)
            << direction << " " << x << " " << y;
      }
    }
  }
}

TEST(Hough, UprightPartsAreAmongTheCandidates) {
  const auto part = makePart("bracket", bracketPlate());
  for (const bool front : {true, false}) {
    for (const double yaw : {0.0, 77.0, 161.0, 303.0}) {
      const sim::Lie lie{30, -20, 590 + yaw / 10, yaw, 3, yaw, front};
      const auto candidates = candidatesOf(edgesOf(sceneOf(bracketPlate(), lie)), *part);
      EXPECT_LT(nearest(candidates, *part, sim::poseOf(lie)), kWithin) << yaw << " " << front;
    }
  }
}

TEST(Hough, TiltedPartsAreAmongTheCandidates) {
  const auto part = makePart("bracket", bracketPlate());
  for (const bool front : {true, false}) {
    for (const double axis : {0.0, 50.0, 120.0, 200.0, 290.0}) {
      const sim::Lie lie{-40, 30, 600, 40, 30, axis, front};
      const auto candidates = candidatesOf(edgesOf(sceneOf(bracketPlate(), lie)), *part);
      EXPECT_LT(nearest(candidates, *part, sim::poseOf(lie)), kWithin) << axis << " " << front;
    }
  }
}

/// Cells of a fourteenth of a radius are half a tooth of such a wheel.
TEST(Hough, TeethAreToldFromGaps) {
  constexpr int kTeeth = 44;
  const sim::Plate plate = wheelPlate(kTeeth, false);
  const auto part = makePart("wheel", plate);
  for (const double yaw : {0.0, 2.5, 5.0}) {
    const sim::Lie lie{30, -20, 585, yaw};
    const auto candidates = candidatesOf(edgesOf(sceneOf(plate, lie)), *part);
    ASSERT_FALSE(candidates.empty());
    const Eigen::Isometry3d off = sim::poseOf(lie).inverse() * candidates[0].T_camera_part;
    const double teeth = std::atan2(off(1, 0), off(0, 0)) * kTeeth / (2.0 * M_PI);
    EXPECT_NEAR(teeth, std::round(teeth), 0.3) << yaw;
    EXPECT_LT(1e3 * off.translation().head<2>().norm(), 2.0) << yaw;
  }
}

TEST(Hough, TheBestCandidateIsTheRightOne) {
  const auto part = makePart("bracket", bracketPlate());
  const sim::Lie lie{30, -20, 600, 200};
  const auto candidates = candidatesOf(edgesOf(sceneOf(bracketPlate(), lie)), *part);
  ASSERT_FALSE(candidates.empty());
  EXPECT_LT(nearest({candidates[0]}, *part, sim::poseOf(lie)), kWithin);
  EXPECT_GT(candidates[0].votes, 0.8);
}

TEST(Hough, VotesDescendWithinTheirLimits) {
  const auto part = makePart("bracket", bracketPlate());
  const auto edges = edgesOf(sceneOf(bracketPlate(), {30, -20, 600, 200}));
  HoughParams params;
  params.votes_min = 0.4;
  for (const int most : {7, 300}) {
    params.max_candidates = most;
    const auto candidates = candidatesOf(edges, *part, params);
    ASSERT_FALSE(candidates.empty());
    EXPECT_LE(candidates.size(), static_cast<std::size_t>(most));
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      EXPECT_LE(candidates[i].votes, 1.0);
      EXPECT_GE(candidates[i].votes, params.votes_min);
      EXPECT_LE(candidates[i].votes, candidates[i > 0 ? i - 1 : i].votes);
    }
  }
}

TEST(Hough, WithoutALeastShareEveryTileHasItsBest) {
  const auto part = makePart("bracket", bracketPlate());
  const sim::Lie lie{30, -20, 600, 200};
  HoughParams params;
  params.votes_min = 0.0;
  const auto candidates = candidatesOf(edgesOf(sceneOf(bracketPlate(), lie)), *part, params);
  ASSERT_GE(candidates.size(), static_cast<std::size_t>(params.max_candidates) - 2);
  EXPECT_LT(nearest({candidates[0]}, *part, sim::poseOf(lie)), kWithin);
}

TEST(Hough, OnlyWithinTheDistances) {
  const auto part = makePart("bracket", bracketPlate());
  const sim::Lie lie{30, -20, 600, 200};
  const auto edges = edgesOf(sceneOf(bracketPlate(), lie));
  HoughParams params;
  params.votes_min = 0.3;
  for (const auto& [from, to] : {std::pair{0.55, 0.65}, {0.58, 0.58}, {0.7, 0.8}}) {
    const auto candidates = findCandidates(edges, {part.get(), 0, from, to}, params, 1);
    ASSERT_FALSE(candidates.empty());
    for (const Candidate& c : candidates) {
      const Eigen::Vector3d centre =
          c.T_camera_part * Eigen::Vector3d(part->center().x(), part->center().y(), 0.0);
      // The nominal distance is along the axis, the pose's along its line of sight: 20 degrees at
      // the corner.
      EXPECT_GT(centre.z(), 0.93 * from);
      EXPECT_LT(centre.z(), 1.07 * to);
    }
  }
}

TEST(Hough, TiltsStayWithinTheLimit) {
  const auto part = makePart("bracket", bracketPlate());
  const auto edges = edgesOf(sceneOf(bracketPlate(), {30, -20, 600, 40, 30}));
  HoughParams params;
  params.votes_min = 0.3;
  params.tilt_max_deg = 15.0;
  const auto candidates = candidatesOf(edges, *part, params);
  ASSERT_FALSE(candidates.empty());
  for (const Candidate& c : candidates) {
    EXPECT_GT(std::abs(c.T_camera_part.linear()(2, 2)), std::cos((15.0 + 6.0) * kDegrees) - 1e-9);
  }
}

TEST(Hough, ThreadsDoNotMatter) {
  const auto part = makePart("bracket", bracketPlate());
  const auto edges = edgesOf(sceneOf(bracketPlate(), {30, -20, 600, 40, 20}));
  const auto one = candidatesOf(edges, *part);
  ASSERT_GT(one.size(), 1u);
  for (const int threads : {1, 2, 3}) {
    const auto more = candidatesOf(edges, *part, {}, threads);
    ASSERT_EQ(more.size(), one.size());
    for (std::size_t i = 0; i < one.size(); ++i) {
      EXPECT_EQ(more[i].votes, one[i].votes);
      EXPECT_EQ(more[i].face, one[i].face);
      EXPECT_EQ(more[i].T_camera_part.matrix(), one[i].T_camera_part.matrix());
    }
  }
}

TEST(Hough, SeveralPartsOfOneKind) {
  const auto part = makePart("bracket", bracketPlate());
  sim::Scene scene;
  const std::vector<sim::Lie> lies = {
      {-120, -80, 600, 10}, {90, -70, 580, 100, 0, 0, false}, {-60, 80, 620, 220}};
  for (const auto& lie : lies) scene.plates.push_back({bracketPlate(), sim::poseOf(lie)});
  const auto candidates = candidatesOf(edgesOf(scene), *part);
  for (const auto& lie : lies) {
    EXPECT_LT(nearest(candidates, *part, sim::poseOf(lie)), kWithin) << lie.x_mm;
  }
}

TEST(Hough, NoEdgesNoCandidates) {
  const auto part = makePart("bracket", bracketPlate());
  EXPECT_TRUE(candidatesOf(edgesOf(sim::Scene()), *part).empty());
}

TEST(Hough, RefusesASearchThatWouldTakeTooMuchMemory) {
  const auto part = makePart("bracket", bracketPlate());
  const EdgeMap edges = edgesOf({});
  HoughParams params;
  params.yaw_step_deg = 0.5;
  params.distance_step = 0.005;
  params.tilt_max_deg = 60.0;
  const auto search = [&](double distance_max) {
    findCandidates(edges, {part.get(), 0, 0.3, distance_max}, params, 1);
  };
  EXPECT_TRUE(refuses([&] { search(3.0); }, {"bracket", "GB", "hough/yaw_step_deg (0.5)",
                                             "hough/distance_step (0.005)"}));
  // One grain for near and far: a huge picture of a near part.
  EdgeMap wide;
  wide.fields.resize(1);
  wide.field_of = {0};
  wide.fields[0].width = wide.fields[0].height = 20000;
  wide.fields[0].focal = 1000.0;
  EXPECT_TRUE(refuses(
      [&] {
        findCandidates(wide, {part.get(), 0, 2.0, 2.0}, {}, 1);
      },
      {"GB", "edges/megapixels"}));
}

TEST(Hough, HolesOnAGridAreNotTakenForTheirNeighbours) {
  constexpr double kPitch = 8.0;
  sim::Plate plate;
  plate.outer = rectangle(-60, -44, 60, 44);
  for (int i = 0; i < 14; ++i)
    for (int k = 0; k < 10; ++k)
      plate.holes.push_back(circle(kPitch * (i - 6.5), kPitch * (k - 4.5), 2.5, true));
  const auto part = makePart("perforated", plate);
  for (const double yaw : {0.0, 21.0, 48.0}) {
    const sim::Lie lie{15, -10, 600, yaw, 3};
    auto candidates = candidatesOf(edgesOf(sceneOf(plate, lie)), *part);
    ASSERT_GT(candidates.size(), 10u);
    candidates.resize(10);
    // The plate looks the same after half a turn, and from behind.
    double off = 1e9;
    for (const Candidate& c : candidates)
      off = std::min(
          off, (c.T_camera_part.translation() - sim::poseOf(lie).translation()).head<2>().norm());
    EXPECT_LT(1e3 * off, 0.3 * kPitch) << yaw;
  }
}

}  // namespace
}  // namespace planar_bin_picking
