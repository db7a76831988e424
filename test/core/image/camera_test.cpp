// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/image/camera.h"
#include "planar_bin_picking/image/camera_file.h"
#include "support/matchers.h"
#include "support/temp_dir.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <locale>
#include <utility>

namespace planar_bin_picking {
namespace {

Camera::Model plumbBob() {
  Camera::Model model;
  model.width = 2448;
  model.height = 2048;
  model.fx = 3475.4;
  model.fy = 3474.8;
  model.cx = 1199.1;
  model.cy = 1007.0;
  model.distortion = {-0.105, 0.065, -5.1e-4, -4.4e-4, 0.01};
  return model;
}

Camera::Model wideAngle() {
  Camera::Model model;
  model.width = 1280;
  model.height = 960;
  model.fx = 640.0;
  model.fy = 645.0;
  model.cx = 655.0;
  model.cy = 470.0;
  model.distortion_model = "rational_polynomial";
  model.distortion = {5.2, 3.1, 1e-3, -8e-4, 0.2, 5.5, 4.6, 0.9};
  return model;
}

std::vector<Camera> cameras() { return {Camera(plumbBob()), Camera(wideAngle())}; }

TEST(Camera, ProjectsWithoutDistortion) {
  Camera::Model model = plumbBob();
  model.distortion.clear();
  const Eigen::Vector2d p = Camera(model).project({0.1, -0.2, 2.0});
  EXPECT_NEAR(p.x(), 3475.4 * 0.05 + 1199.1, 1e-9);
  EXPECT_NEAR(p.y(), 3474.8 * -0.10 + 1007.0, 1e-9);
}

// Values from cv::projectPoints of OpenCV 4.6 with the same numbers.
TEST(Camera, AgreesWithOpenCv) {
  const Eigen::Vector2d a = Camera(plumbBob()).project({0.3, 0.25, 1.0});
  EXPECT_NEAR(a.x(), 2225.863788502, 1e-6);
  EXPECT_NEAR(a.y(), 1862.412818289, 1e-6);
  const Eigen::Vector2d b = Camera(wideAngle()).project({0.6, -0.5, 1.0});
  EXPECT_NEAR(b.x(), 982.821463252, 1e-6);
  EXPECT_NEAR(b.y(), 194.812342972, 1e-6);
}

TEST(Camera, UndistortInvertsDistortAllOverTheImage) {
  for (const Camera& camera : cameras()) {
    for (double u = -0.5; u <= camera.model().width; u += camera.model().width / 20.0) {
      for (double v = -0.5; v <= camera.model().height; v += camera.model().height / 20.0) {
        const Eigen::Vector2d p_image(u, v);
        EXPECT_LT((camera.distort(camera.undistort(p_image)) - p_image).norm(), 1e-9);
      }
    }
  }
}

TEST(Camera, JacobianEqualsDifferences) {
  for (const Camera& camera : cameras()) {
    for (const Eigen::Vector2d& p :
         {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.3, -0.2), Eigen::Vector2d(-0.1, 0.25)}) {
      Eigen::Matrix2d jacobian;
      camera.distort(p, &jacobian);
      const auto numeric =
          numericJacobian([&](const Eigen::Vector2d& x) { return camera.distort(x); }, p, 1e-5);
      // Differences of thousands of pixels over 2e-5: good to some 1e-6 relative.
      EXPECT_LT((jacobian - numeric).norm(), 1e-5 * jacobian.norm());
    }
  }
}

TEST(Camera, RefusesWrongModels) {
  const auto refused = [](auto change, const std::vector<std::string>& words) {
    Camera::Model model = plumbBob();
    change(&model);
    return refuses([&] { Camera camera(model); }, words);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](auto* m) { m->width = 0; }, {"width", "0"}));
  EXPECT_TRUE(refused([](auto* m) { m->height = -3; }, {"height", "-3"}));
  EXPECT_TRUE(refused([](auto* m) { m->fx = 0.0; }, {"fx", "calibrated"}));
  EXPECT_TRUE(refused([nan](auto* m) { m->fy = nan; }, {"fy", "nan"}));
  EXPECT_TRUE(refused([](auto* m) { m->cx = 5000.0; }, {"cx", "5000"}));
  EXPECT_TRUE(refused([nan](auto* m) { m->cy = nan; }, {"cy"}));
  EXPECT_TRUE(
      refused([](auto* m) { m->distortion_model = "equidistant"; }, {"equidistant", "plumb_bob"}));
  EXPECT_TRUE(refused([nan](auto* m) { m->distortion[1] = nan; }, {"coefficient 2"}));
  EXPECT_TRUE(
      refused([](auto* m) { m->distortion.resize(6, 0.1); }, {"coefficient 6", "5 coefficients"}));
}

testing::AssertionResult refusedWith(const Camera::Model& model,
                                     const std::vector<std::string>& words) {
  return refuses([&] { Camera camera(model); }, words);
}

/// Without distortion: what a focal length and a principal point alone say.
Camera::Model pinhole(double fx, double fy) {
  Camera::Model model = plumbBob();
  model.distortion.clear();
  model.fx = fx;
  model.fy = fy;
  return model;
}

TEST(Camera, RefusesTheIdentity) {
  EXPECT_TRUE(refusedWith(pinhole(1.0, 1.0), {"fx is 1,", "no calibration"}));
}

TEST(Camera, RefusesFocalLengthsFarApart) {
  EXPECT_TRUE(refusedWith(pinhole(1.7, 1737.0), {"fx and fy", "1.7", "1737", "20 %"}));
  EXPECT_TRUE(refusedWith(pinhole(3000.0, 2490.0), {"fx and fy"}));
  EXPECT_TRUE(refusedWith(pinhole(2490.0, 3000.0), {"fx and fy"}));
  EXPECT_NO_THROW(Camera(pinhole(3000.0, 2510.0)));
  EXPECT_NO_THROW(Camera(pinhole(2510.0, 3000.0)));
}

TEST(Camera, RefusesFieldsOfViewThatNoLensHas) {
  // 2448 pixels wide: 150 degrees at 328 pixels, 2 degrees at 70123.
  EXPECT_TRUE(refusedWith(pinhole(320.0, 320.0), {"field of view", "320", "150 degrees"}));
  EXPECT_NO_THROW(Camera(pinhole(336.0, 336.0)));
  EXPECT_TRUE(refusedWith(pinhole(71000.0, 71000.0), {"field of view", "2 to 150"}));
  EXPECT_NO_THROW(Camera(pinhole(69000.0, 69000.0)));
  // The longer side counts, whichever it is.
  Camera::Model tall = pinhole(71000.0, 71000.0);
  std::swap(tall.width, tall.height);
  std::swap(tall.cx, tall.cy);
  EXPECT_TRUE(refusedWith(tall, {"field of view"}));
  tall.fx = tall.fy = 69000.0;
  EXPECT_NO_THROW(Camera{tall});
}

TEST(Camera, RefusesAPrincipalPointOutsideOfTheImage) {
  for (const double off : {-200.0, 0.0, 2447.0, 3000.0}) {
    Camera::Model model = plumbBob();
    model.cx = off;
    EXPECT_TRUE(refusedWith(model, {"cx", "inside the image", "2447"})) << off;
  }
  for (const double off : {-200.0, 0.0, 2047.0, 3000.0}) {
    Camera::Model model = plumbBob();
    model.cy = off;
    EXPECT_TRUE(refusedWith(model, {"cy", "inside the image", "2047"})) << off;
  }
  Camera::Model shifted = pinhole(3475.0, 3475.0);
  shifted.cx = 300.0;
  shifted.cy = 1900.0;
  EXPECT_NO_THROW(Camera{shifted});
}

TEST(Camera, RefusesASkew) {
  std::array<double, 9> K = {600.0, 0.0, 320.0, 0.0, 601.0, 240.0, 0.0, 0.0, 1.0};
  const Camera::Model model = pinholeModel(640, 480, K);
  EXPECT_EQ(model.width, 640);
  EXPECT_EQ(model.height, 480);
  EXPECT_EQ(model.fx, 600.0);
  EXPECT_EQ(model.fy, 601.0);
  EXPECT_EQ(model.cx, 320.0);
  EXPECT_EQ(model.cy, 240.0);
  for (const std::size_t i : {1, 3, 6, 7, 8}) {
    auto other = K;
    other[i] += 500.0;
    EXPECT_TRUE(refuses([&] { pinholeModel(640, 480, other); },
                        {i == 1 ? "skew" : "pinhole", i == 8 ? "501" : "500"}));
  }
}

/// Radial factor 1 all over but in a narrow ring, where it falls to nothing and comes back.
TEST(Camera, RefusesAFoldHoweverNarrow) {
  Camera::Model model = wideAngle();
  const double ring2 = 0.5;  // radius squared, inside the image
  model.distortion = {-2.0 / ring2, 1.0 / (ring2 * ring2),    0.0, 0.0, 0.0,
                      -2.0 / ring2, 1.0001 / (ring2 * ring2), 0.0};
  EXPECT_TRUE(refusedWith(model, {"folds over"}));
}

TEST(Camera, RefusesAFoldByTangentialTerms) {
  Camera::Model model = wideAngle();
  model.distortion = {0.0, 0.0, 0.0, -0.2};
  EXPECT_TRUE(refusedWith(model, {"folds over"}));
}

TEST(Camera, RefusesABendThatNoLensHas) {
  Camera::Model model = plumbBob();
  model.distortion_model = "rational_polynomial";
  // Beyond a fifth of the way to the corner directions are pressed together more and more.
  model.distortion = {0.0, 0.0, 0.0, 0.0, 0.0, 40.0, 0.0, 0.0};
  EXPECT_TRUE(refuses([&] { Camera camera(model); }, {"lens model"}));
}

TEST(Camera, AcceptsWhatLensesDo) {
  Camera::Model barrel = plumbBob();
  barrel.fx = barrel.fy = 2000.0;
  barrel.distortion = {-0.29, 0.09, 0.0, 0.0, -0.012};
  EXPECT_NO_THROW(Camera{barrel});
}

TEST(Camera, RefusesALensThatFoldsOver) {
  Camera::Model model = plumbBob();
  model.distortion = {-3.5, 0.0, 0.0, 0.0, 0.0};
  EXPECT_TRUE(refuses([&] { Camera camera(model); }, {"folds over"}));
  // The polynomial turns back before the corner, though it comes forward again there.
  model.distortion = {-6.0, 12.0, 0.0, 0.0, 0.0};
  EXPECT_TRUE(refuses([&] { Camera camera(model); }, {"folds over"}));
}

TEST(Camera, AcceptsZerosBeyondTheModel) {
  Camera::Model model = plumbBob();
  model.distortion.resize(14, 0.0);
  EXPECT_NO_THROW(Camera camera(model));
}

class LoadCamera : public testing::Test {
 protected:
  static std::string yaml() {
    return "image_width: 640\nimage_height: 480\ncamera_name: left\n"
           "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [600.5, 0, 320, 0, 601.25, 240, 0, 0, "
           "1]\n"
           "distortion_model: plumb_bob\n"
           "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, "
           "0]\n"
           "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
  }

  /// The error of the file after one replacement in it.
  testing::AssertionResult refused(const std::string& what, const std::string& by,
                                   const std::vector<std::string>& words) {
    std::string text = yaml();
    text.replace(text.find(what), what.size(), by);
    const std::string path = dir_.write("camera_info.yaml", text);
    std::vector<std::string> all = words;
    all.push_back("camera_info.yaml");
    return refuses([&] { loadCamera(path); }, all);
  }

  TempDir dir_;
};

TEST_F(LoadCamera, ReadsTheRosFormat) {
  const Camera camera = loadCamera(dir_.write("camera_info.yaml", yaml()));
  EXPECT_EQ(camera.model().width, 640);
  EXPECT_EQ(camera.model().height, 480);
  EXPECT_EQ(camera.model().fx, 600.5);
  EXPECT_EQ(camera.model().fy, 601.25);
  EXPECT_EQ(camera.model().cx, 320.0);
  EXPECT_EQ(camera.model().cy, 240.0);
  EXPECT_EQ(camera.model().distortion, (std::vector<double>{-0.1, 0.02, 0.001, -0.002, 0.0}));
}

TEST_F(LoadCamera, NamesFileAndKeyOfWhatIsWrong) {
  EXPECT_TRUE(refused("image_width: 640\n", "", {"image_width", "missing"}));
  EXPECT_TRUE(refused("image_width: 640", "image_width: wide", {"image_width", "wide"}));
  EXPECT_TRUE(refused("image_height: 480", "image_height: 0", {"height", "0"}));
  EXPECT_TRUE(refused("camera_matrix", "matrix", {"camera_matrix/data", "missing"}));
  EXPECT_TRUE(refused("600.5, 0, 320", "600.5, 0.3, 320", {"camera_matrix/data", "0.3"}));
  EXPECT_TRUE(refused("240, 0, 0, 1]", "240]", {"camera_matrix/data"}));
  EXPECT_TRUE(refused("600.5, 0, 320, 0, 601.25, 240", "1, 0, 0, 0, 1, 0", {"no calibration"}));
  EXPECT_TRUE(refused("600.5", ".nan", {"fx", "nan"}));
  EXPECT_TRUE(refused("600.5", "0.0", {"fx", "calibrated"}));
  EXPECT_TRUE(refused("plumb_bob", "fisheye", {"distortion_model", "fisheye"}));
  EXPECT_TRUE(
      refused("data: [-0.1, 0.02", "data: [-0.1, much", {"distortion_coefficients/data", "much"}));
  EXPECT_TRUE(
      refused("camera_matrix:", "image_width: 1\ncamera_matrix:", {"image_width", "twice"}));
  EXPECT_TRUE(refused("image_width: 640", "image_width: [640", {"not valid YAML"}));
}

TEST_F(LoadCamera, RefusesOtherFiles) {
  EXPECT_TRUE(
      refuses([&] { loadCamera(dir_.path("absent.yaml")); }, {"absent.yaml", "cannot be read"}));
  EXPECT_TRUE(refuses([&] { loadCamera(dir_.write("a.yaml", "just words")); }, {"a.yaml"}));
  EXPECT_TRUE(refuses([&] { loadCamera(dir_.write("b.yaml", "")); }, {"b.yaml"}));
  const std::string printed = "height: 480\nwidth: 640\nK: [1, 0, 1, 0, 1, 1, 0, 0, 1]\n";
  EXPECT_TRUE(
      refuses([&] { loadCamera(dir_.write("c.yaml", printed)); }, {"c.yaml", "camera_matrix"}));
}

struct DecimalComma : std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
};

TEST_F(LoadCamera, ReadsPointsWhereTheLocaleHasCommas) {
  const std::string path = dir_.write("camera_info.yaml", yaml());
  const std::locale before =
      std::locale::global(std::locale(std::locale::classic(), new DecimalComma));
  const Camera camera = loadCamera(path);
  std::locale::global(before);
  EXPECT_EQ(camera.model().fx, 600.5);
}

}  // namespace
}  // namespace planar_bin_picking
