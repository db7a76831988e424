// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/locate/locator.h"

#include "support/matchers.h"
#include "support/stages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <random>
#include <string>

namespace planar_bin_picking {
namespace {

LocateRequest requestFor(const Parts& parts) {
  LocateRequest request;
  request.parts = parts;
  request.distance_min = 0.55;
  request.distance_max = 0.65;
  return request;
}

sim::Scene threeKinds() {
  sim::Scene scene;
  scene.plates.push_back({bracketPlate(), sim::poseOf({-110, -80, 600, 20, 8, 30})});
  scene.plates.push_back({bracketPlate(), sim::poseOf({100, -70, 590, 120, 12, 100, false})});
  scene.plates.push_back({wheelPlate(15, true), sim::poseOf({-70, 80, 610, 3, 6})});
  scene.plates.push_back({slenderPlate(), sim::poseOf({90, 90, 620, 40})});
  return scene;
}

TEST(Locator, FindsThePartsAndNoOthers) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const sim::Scene scene = threeKinds();
  const auto result =
      Locator().locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), requestFor(parts));
  ASSERT_EQ(result.detections.size(), 2u);
  for (const Detection& d : result.detections) {
    const auto& truth = scene.plates[d.face == Face::kFront ? 0 : 1].T_camera_part;
    EXPECT_TRUE(isometryNear(d.T_camera_part, truth, 0.6e-3, 0.6 * kDegrees));
    EXPECT_GT(d.score, 0.8);
    EXPECT_GT(d.visible_fraction, 0.95);
  }
}

TEST(Locator, AWindowHidesTheRestOfThePicture) {
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  const Camera camera = makeCamera(kPinhole);
  LocateRequest request = requestFor({makePart("bracket", bracketPlate())});
  const auto all = Locator().locate(image, camera, request);
  ASSERT_EQ(all.detections.size(), 2u);
  request.window = PixelBox{0, 0, image.cols / 2, image.rows};
  const auto left = Locator().locate(image, camera, request);
  ASSERT_EQ(left.detections.size(), 1u);
  EXPECT_LT(left.report.stages[0].out, all.report.stages[0].out);  // edges
  EXPECT_TRUE(isometryNear(left.detections[0].T_camera_part, threeKinds().plates[0].T_camera_part,
                           0.6e-3, 0.6 * kDegrees));
  request.window = PixelBox{-50, -50, 10 * image.cols, 10 * image.rows};
  EXPECT_EQ(Locator().locate(image, camera, request).detections.size(), 2u);
  request.window = PixelBox{image.cols, image.rows, 10, 10};  // the principal point holds it back
  EXPECT_LT(Locator().locate(image, camera, request).detections.size(), 2u);
}

TEST(Locator, SeveralPartsAreRankedTogether) {
  const Parts parts = {makePart("bracket", bracketPlate()),
                       makePart("wheel", wheelPlate(15, true))};
  const auto result = Locator().locate(sim::takeImage(kPinhole, threeKinds()), makeCamera(kPinhole),
                                       requestFor(parts));
  int brackets = 0, wheels = 0;
  for (const Detection& d : result.detections) {
    (d.part == 0 ? brackets : wheels) += 1;
    EXPECT_EQ(d.part_name, d.part == 0 ? "bracket" : "wheel");
  }
  EXPECT_EQ(brackets, 2);
  EXPECT_EQ(wheels, 1);
}

sim::Plate movedBy(sim::Plate plate, const Eigen::Vector2d& off_mm) {
  for (auto& p : plate.outer) p += off_mm;
  for (auto* rings : {&plate.holes, &plate.prints})
    for (auto& ring : *rings)
      for (auto& p : ring) p += off_mm;
  return plate;
}

/// Drawings in a country's coordinates have their origin kilometres away.
TEST(Locator, AFarOriginChangesNothing) {
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  const Eigen::Vector2d off_mm(11.0e6, -4.0e6);
  const Eigen::Translation3d off(1e-3 * off_mm.x(), 1e-3 * off_mm.y(), 0.0);
  for (const sim::Plate& plate : {bracketPlate(), wheelPlate(15, true)}) {
    const auto here =
        Locator().locate(image, makeCamera(kPinhole), requestFor({makePart("part", plate)}));
    const auto far = Locator().locate(image, makeCamera(kPinhole),
                                      requestFor({makePart("part", movedBy(plate, off_mm))}));
    ASSERT_FALSE(here.detections.empty());
    ASSERT_EQ(far.detections.size(), here.detections.size());
    // At 11 km a coordinate is rounded to 2 nm, and a rounding may shift by one step where an
    // iteration ends. Before, centres were up to 234 mm off.
    for (std::size_t i = 0; i < far.detections.size(); ++i) {
      EXPECT_EQ(far.detections[i].face, here.detections[i].face);
      EXPECT_TRUE(isometryNear(far.detections[i].T_camera_part * off,
                               here.detections[i].T_camera_part, 1e-6, 1e-5));
    }
  }
}

TEST(Locator, TheReportNamesTheStages) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  const auto start = std::chrono::steady_clock::now();
  const auto report = Locator().locate(image, makeCamera(kPinhole), requestFor(parts)).report;
  const std::chrono::duration<double> all = std::chrono::steady_clock::now() - start;
  ASSERT_EQ(report.stages.size(), 5u);
  double sum = 0.0;
  const char* const names[] = {"edges", "hough", "refine", "score", "rank"};
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(report.stages[i].name, names[i]);
    sum += report.stages[i].seconds;
  }
  EXPECT_NEAR(report.seconds, sum, 1e-9);
  EXPECT_LT(report.seconds, all.count());  // each second counts once
  EXPECT_GT(report.seconds, 0.5 * all.count());
  EXPECT_EQ(report.stages[4].out, 2u);
}

TEST(Locator, TheSameAnswerOnAnyNumberOfThreads) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, threeKinds());
  std::vector<LocateResult> results;
  for (const int threads : {1, 2, 2, 3}) {
    LocatorParams params;
    params.threads = threads;
    results.push_back(Locator(params).locate(image, makeCamera(kPinhole), requestFor(parts)));
  }
  for (const auto& other : results) {
    ASSERT_EQ(other.detections.size(), results[0].detections.size());
    for (std::size_t i = 0; i < other.detections.size(); ++i) {
      EXPECT_EQ(other.detections[i].T_camera_part.matrix(),
                results[0].detections[i].T_camera_part.matrix());
      EXPECT_EQ(other.detections[i].score, results[0].detections[i].score);
    }
  }
}

TEST(Locator, SixteenBitsSayTheSame) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  cv::Mat image = sim::takeImage(kPinhole, threeKinds()), deep;
  image.convertTo(deep, CV_16U, 256.0);
  const Locator locator;
  const auto a = locator.locate(image, makeCamera(kPinhole), requestFor(parts));
  const auto b = locator.locate(deep, makeCamera(kPinhole), requestFor(parts));
  ASSERT_EQ(a.detections.size(), b.detections.size());
  for (std::size_t i = 0; i < a.detections.size(); ++i) {
    EXPECT_TRUE(isometryNear(a.detections[i].T_camera_part, b.detections[i].T_camera_part, 1e-4,
                             0.1 * kDegrees));
  }
}

TEST(Locator, AnEmptyPictureIsAnAnswer) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const Camera camera = makeCamera(kPinhole);
  EXPECT_TRUE(
      Locator().locate(sim::takeImage(kPinhole, {}), camera, requestFor(parts)).detections.empty());
  const cv::Mat flat(kPinhole.height, kPinhole.width, CV_8U, cv::Scalar(90));
  EXPECT_TRUE(Locator().locate(flat, camera, requestFor(parts)).detections.empty());
}

TEST(Locator, RefusesBadInput) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, {});
  const Camera camera = makeCamera(kPinhole);
  const Locator locator;
  const auto with = [&](const cv::Mat& picture, LocateRequest request) {
    return [&locator, &camera, picture, request] { locator.locate(picture, camera, request); };
  };
  EXPECT_TRUE(refuses(with({}, requestFor(parts)), {"image is empty"}));
  EXPECT_TRUE(refuses(with(image(cv::Rect(0, 0, 600, 500)), requestFor(parts)),
                      {"600 x 500", "1200 x 1000"}));
  EXPECT_TRUE(refuses(with(cv::Mat(1000, 1200, CV_8UC3), requestFor(parts)), {"3 channels"}));
  EXPECT_TRUE(refuses(with(image, requestFor({})), {"no part"}));
  LocateRequest far = requestFor(parts);
  far.distance_max = 0.2;
  EXPECT_TRUE(refuses(with(image, far), {"0.55", "0.2"}));
  far.distance_max = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refuses(with(image, far), {"distances"}));
  LocatorParams params;
  params.score.threshold = 2.0;
  EXPECT_TRUE(refuses([&] { Locator{params}; }, {"score/threshold"}));
}

TEST(Locator, TheImageMayDifferFromTheCameraByTwoColumnsOrRows) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const Camera camera = makeCamera(kPinhole);
  const auto locate = [&](int width, int height) {
    return Locator()
        .locate(cv::Mat(height, width, CV_8U, cv::Scalar(90)), camera, requestFor(parts))
        .report.stages.size();
  };
  for (const int off : {-2, 2}) {
    EXPECT_EQ(locate(kPinhole.width + off, kPinhole.height), 5u);
    EXPECT_EQ(locate(kPinhole.width, kPinhole.height + off), 5u);
  }
  for (const int off : {-3, 3}) {
    EXPECT_TRUE(refuses([&] { locate(kPinhole.width + off, kPinhole.height); }, {"one size"}));
    EXPECT_TRUE(refuses([&] { locate(kPinhole.width, kPinhole.height + off); }, {"one size"}));
  }
}

TEST(Locator, TheSmallestImage) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const auto locate = [&](int width, int height) {
    sim::PinholeCamera small;
    small.width = width;
    small.height = height;
    small.fx = small.fy = 90.0;
    small.cx = 0.5 * width;
    small.cy = 0.5 * height;
    small.lens = {};
    LocateRequest request = requestFor(parts);
    request.distance_min = 0.12;
    request.distance_max = 0.13;
    return Locator()
        .locate(cv::Mat(height, width, CV_8U, cv::Scalar(90)), makeCamera(small), request)
        .report.stages.size();
  };
  EXPECT_EQ(locate(64, 64), 5u);
  EXPECT_TRUE(refuses([&] { locate(63, 64); }, {"64 x 64"}));
  EXPECT_TRUE(refuses([&] { locate(64, 63); }, {"64 x 64"}));
}

TEST(Locator, OtherDepthsAreRefused) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  for (const int type : {CV_8UC2, CV_16UC3, CV_16SC1, CV_32FC1, CV_8SC1}) {
    const cv::Mat image(kPinhole.height, kPinhole.width, type, cv::Scalar::all(9));
    EXPECT_TRUE(refuses([&] { Locator().locate(image, makeCamera(kPinhole), requestFor(parts)); },
                        {"8 or 16 bit"}))
        << type;
  }
}

/// A bracket on the floor at 610 mm and one that lies 20 mm above it.
sim::Scene onAndOffTheFloor() {
  sim::Scene scene;
  scene.plates.push_back({bracketPlate(), sim::poseOf({-70, 0, 610, 20})});
  scene.plates.push_back({bracketPlate(), sim::poseOf({70, 0, 590, 120})});
  return scene;
}

TEST(Locator, OnAKnownPlaneOnlyWhatLiesOnItIsFound) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, onAndOffTheFloor());
  const auto on = [&](double params_plane, std::optional<double> request_plane) {
    LocatorParams params;
    params.plane.distance = params_plane;
    LocateRequest request = requestFor(parts);
    if (request_plane) request.plane = Plane{-Eigen::Vector3d::UnitZ(), *request_plane};
    const auto result = Locator(params).locate(image, makeCamera(kPinhole), request);
    std::vector<std::string> names;
    for (const auto& stage : result.report.stages) names.push_back(stage.name);
    const bool plane = std::find(names.begin(), names.end(), "plane") != names.end();
    EXPECT_EQ(plane, params_plane > 0.0 || request_plane);
    for (const Detection& d : result.detections) {
      // The plane says the depth, a hundred times as well as the picture.
      EXPECT_EQ(std::sqrt(d.covariance(2, 2)) < 0.55e-3, plane);
    }
    std::vector<double> depths;
    for (const Detection& d : result.detections)
      depths.push_back(std::round(1e3 * d.T_camera_part.translation().z()));
    std::sort(depths.begin(), depths.end());
    return depths;
  };
  EXPECT_EQ(on(0.0, {}), (std::vector<double>{590, 610}));
  EXPECT_EQ(on(0.610, {}), std::vector<double>{610});
  EXPECT_EQ(on(0.590, {}), std::vector<double>{590});
  // The request's own comes first.
  EXPECT_EQ(on(0.610, 0.590), std::vector<double>{590});
}

TEST(Locator, APlaneOutsideOfTheDistancesIsRefused) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  const cv::Mat image = sim::takeImage(kPinhole, {});
  for (const double distance : {0.40, 0.80}) {
    LocateRequest request = requestFor(parts);
    request.plane = Plane{-Eigen::Vector3d::UnitZ(), distance};
    EXPECT_TRUE(refuses([&] { Locator().locate(image, makeCamera(kPinhole), request); },
                        {"plane", std::to_string(distance), "bracket", "0.55", "0.65"}));
  }
}

TEST(Locator, AsManyThreadsAsTheMachineHasUnlessTold) {
  EXPECT_GE(Locator().params().threads, 1);
  LocatorParams params;
  params.threads = 3;
  EXPECT_EQ(Locator(params).params().threads, 3);
}

/// Parts that lie alike tell one another's tilt where no plane is known.
TEST(Locator, PartsTellOneAnotherHowTheyLie) {
  const Parts parts = {makePart("bracket", bracketPlate())};
  sim::Scene one, many;
  for (int i = 0; i < 8; ++i) {
    // Far away, where a picture of one part tells little of its tilt.
    const sim::Lying lying{bracketPlate(), sim::poseOf({150.0 * (i % 4) - 225,
                                                        200.0 * (i / 4) - 100, 1500, 40.0 * i})};
    if (i < 1) one.plates.push_back(lying);
    many.plates.push_back(lying);
  }
  const auto turnOf = [&](const sim::Scene& scene) {
    LocateRequest request = requestFor(parts);
    request.distance_min = 1.4;
    request.distance_max = 1.6;
    const auto result =
        Locator().locate(sim::takeImage(kPinhole, scene), makeCamera(kPinhole), request);
    EXPECT_EQ(result.detections.size(), scene.plates.size());
    for (const Detection& d : result.detections) {
      const Eigen::Vector3d off =
          d.T_camera_part.translation() - one.plates[0].T_camera_part.translation();
      if (off.norm() < 0.03) return std::sqrt(d.covariance(3, 3));
    }
    return 0.0;
  };
  const double alone = turnOf(one), among = turnOf(many);
  EXPECT_GT(among, 0.0);
  EXPECT_LT(among, 0.6 * alone);
}

/// Far away and tilted either way; without the floor the answer says that it may be the other.
TEST(Locator, ABinsFloorTellsATiltThatThePictureLeavesOpen) {
  const auto tilted = [](double deg) { return sim::poseOf({0, 0, 1500, 40, deg, 70}); };
  const Parts parts = {makePart("bracket", bracketPlate())};
  LocateRequest request = requestFor(parts);
  request.distance_min = 1.4, request.distance_max = 1.6;
  const cv::Mat image = sim::takeImage(kPinhole, {{{bracketPlate(), tilted(6.0)}}});
  const auto locate = [&](std::optional<double> floor_deg) {
    if (floor_deg) request.floor_normal = tilted(*floor_deg).linear().col(2);
    return Locator().locate(image, makeCamera(kPinhole), request).detections.at(0);
  };
  const auto lies = [&](const Detection& d, double deg) {
    return d.T_camera_part.linear().col(2).dot(tilted(deg).linear().col(2)) > 0.99;
  };
  const Detection alone = locate({}), flat = locate(6.0), other = locate(-6.0);
  EXPECT_TRUE(lies(flat, 6.0) && !lies(flat, -6.0));
  EXPECT_TRUE(lies(other, -6.0) && !lies(other, 6.0));
  for (const Detection& d : {flat, other})
    EXPECT_GT(alone.covariance.trace(), 2.0 * d.covariance.trace());
}

/// The scene anew: the ends of the distances, the place by half a cell of the vote, a turn of a
/// degree, noise of up to two per cent of the grey levels. No draw may differ; LOCATOR_DRAWS sets
/// how many are made.
TEST(Locator, SmallChangesLeaveTheAnswer) {
  const char* const wanted = std::getenv("LOCATOR_DRAWS");
  const int draws = wanted != nullptr ? std::atoi(wanted) : 12;
  const Parts parts = {makePart("bracket", bracketPlate()),
                       makePart("wheel", wheelPlate(15, true))};
  const sim::Scene scene = threeKinds();
  constexpr std::size_t kAsked = 3;  // of its plates, the first ones
  const Locator locator;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int draw = 0; draw < draws; ++draw) {
    const Eigen::Isometry3d change =
        Eigen::Translation3d(1.7e-3 * any(random), 1.7e-3 * any(random), 5e-3 * any(random)) *
        Eigen::AngleAxisd(1.0 * kDegrees * any(random), Eigen::Vector3d::UnitZ());
    sim::Scene changed = scene;
    for (auto& lying : changed.plates) lying.T_camera_part = change * lying.T_camera_part;
    changed.seed = draw;
    changed.noise = 2.6 + 2.5 * any(random);
    LocateRequest request = requestFor(parts);
    request.distance_min *= 1.0 + 0.03 * any(random);
    request.distance_max *= 1.0 + 0.03 * any(random);
    const auto found =
        locator.locate(sim::takeImage(kPinhole, changed), makeCamera(kPinhole), request);
    ASSERT_EQ(found.detections.size(), kAsked) << draw;
    for (std::size_t i = 0; i < kAsked; ++i) {
      const Eigen::Isometry3d& truth = changed.plates[i].T_camera_part;
      EXPECT_TRUE(std::any_of(found.detections.begin(), found.detections.end(), [&](const auto& d) {
        return isometryNear(d.T_camera_part, truth, 0.8e-3, 0.8 * kDegrees);
      })) << draw;
    }
  }
}

}  // namespace
}  // namespace planar_bin_picking
