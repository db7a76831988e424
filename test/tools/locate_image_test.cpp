// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

// Runs the program itself, as a user does: its exit status, what it prints and what it writes.

#include "support/dxf_writer.h"
#include "support/tool_test.h"

#include <sys/stat.h>

#include <yaml-cpp/yaml.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <cmath>
#include <cstdint>

namespace planar_bin_picking {
namespace {

class LocateImage : public ToolTest {
 protected:
  LocateImage() : ToolTest(LOCATE_IMAGE) {
    const std::string package = PACKAGE_DIR, scene = package + "/test/data/bin_bracket_00";
    part_ = "--part " + package + "/config/parts/bracket.yaml";
    camera_ = "--camera " + scene + "/camera_info.yaml";
    image_ = "--image " + scene + "/image.png";
  }

  std::string part_, camera_, image_;
  const std::string distances_ = "--distance-min 0.785 --distance-max 0.98";
};

TEST_F(LocateImage, WritesTableResultAndOverlay) {
  const std::string result = dir_.path("result.yaml"), overlay = dir_.path("overlay.png");
  ASSERT_EQ(run(part_ + " " + camera_ + " " + image_ + " " + distances_ + " --output " + result +
                " --overlay " + overlay),
            0)
      << error_;
  const YAML::Node root = YAML::LoadFile(result);
  EXPECT_GT(root["seconds"].as<double>(), 0.0);
  const double threshold = root["threshold"].as<double>();
  ASSERT_GT(root["detections"].size(), 0u);
  double before = 1.0;
  for (const YAML::Node& detection : root["detections"]) {
    EXPECT_EQ(detection.size(), 6u);
    EXPECT_EQ(detection["part"].as<std::string>(), "bracket");
    const auto face = detection["face"].as<std::string>();
    EXPECT_TRUE(face == "front" || face == "back") << face;
    const auto p = detection["position"].as<std::vector<double>>();
    ASSERT_EQ(p.size(), 3u);
    EXPECT_GT(p[2], 0.75);
    EXPECT_LT(p[2], 1.0);
    double norm2 = 0.0;
    for (const double q : detection["orientation"].as<std::vector<double>>()) norm2 += q * q;
    EXPECT_NEAR(norm2, 1.0, 1e-6);
    EXPECT_GE(detection["score"].as<double>(), threshold);
    EXPECT_LE(detection["visible_fraction"].as<double>(), 1.0);
    before = detection["score"].as<double>();
  }
  EXPECT_LE(before, 1.0);
  EXPECT_NE(out_.find("bracket"), std::string::npos);
  EXPECT_NE(out_.find("locate"), std::string::npos);
  const cv::Mat picture = cv::imread(overlay);
  EXPECT_EQ(picture.size(), cv::Size(2448, 2048));
  // The lower left corner, where nothing is found: the legend's green patch.
  cv::Mat green;
  cv::inRange(picture(cv::Rect(0, 1748, 400, 300)), cv::Scalar(80, 220, 60),
              cv::Scalar(80, 220, 60), green);
  EXPECT_GT(cv::countNonZero(green), 100);
}

TEST_F(LocateImage, FindsNothingInAnEmptyBinAndSaysSo) {
  const std::string empty = dir_.path("empty.png"), result = dir_.path("result.yaml");
  cv::imwrite(empty, cv::Mat(2048, 2448, CV_16UC3, cv::Scalar(900, 1000, 1100)));
  ASSERT_EQ(
      run(part_ + " " + camera_ + " --image " + empty + " " + distances_ + " --output " + result),
      0)
      << error_;
  EXPECT_TRUE(YAML::LoadFile(result)["detections"].IsSequence());
  EXPECT_EQ(YAML::LoadFile(result)["detections"].size(), 0u);
  EXPECT_NE(out_.find("no part found"), std::string::npos);
}

TEST_F(LocateImage, PrintsItsUsage) {
  EXPECT_TRUE(printsItsVersion(""));
  EXPECT_TRUE(printsItsVersion("--image a"));
  EXPECT_EQ(run("--help"), 0);
  for (const char* option :
       {"--part", "--camera", "--image", "--distance-min", "--distance-max", "--face",
        "--max-parts", "--params", "--output", "--overlay", "--view"}) {
    EXPECT_NE(out_.find(option), std::string::npos) << option;
  }
}

TEST_F(LocateImage, RefusesWrongArguments) {
  EXPECT_TRUE(refused("", {"--part is required"}));
  EXPECT_TRUE(refused(camera_ + " " + image_ + " " + distances_, {"--part is required"}));
  EXPECT_TRUE(refused(part_ + " " + image_ + " " + distances_, {"--camera is required"}));
  EXPECT_TRUE(refused(part_ + " " + camera_ + " " + distances_, {"--image is required"}));
  EXPECT_TRUE(refused(part_ + " " + camera_ + " " + image_ + " --distance-max 1",
                      {"--distance-min is required"}));
  EXPECT_TRUE(refused(part_ + " " + camera_ + " " + image_ + " " + distances_ + " --parts x",
                      {"not expected", "--parts", "see --help"}));
  EXPECT_TRUE(refused("--part", {"--part", "missing"}));
  EXPECT_TRUE(refused("--image ''", {"--image", "needs a value"}));
  EXPECT_TRUE(refused("--distance-min 0,8", {"--distance-min", "0,8", "metres"}));
  EXPECT_TRUE(refused("--distance-max -1", {"--distance-max", "-1"}));
  EXPECT_TRUE(refused(part_ + " " + camera_ + " " + image_ + " --distance-min 2 --distance-max 1",
                      {"--distance-min is 2", "--distance-max, which is 1"}));
  EXPECT_TRUE(refused("--face up", {"--face", "up", "front", "back", "any"}));
  for (const char* count : {"-1", "1.5", "many", "1x", "99999999999999999999"})
    EXPECT_TRUE(refused(std::string("--max-parts ") + count, {"--max-parts", count, "whole"}));
  EXPECT_TRUE(refused("--image a --image b", {"--image", "At Most 1"}));
  EXPECT_TRUE(refused("--distance-min 1 --distance-min 2", {"--distance-min", "At Most 1"}));
  EXPECT_EQ(run("--image a --help"), 0);
}

TEST_F(LocateImage, RefusesWrongFiles) {
  const std::string rest = " " + camera_ + " " + image_ + " " + distances_;
  EXPECT_TRUE(refused("--part none.yaml" + rest, {"none.yaml", "does not exist"}));
  EXPECT_TRUE(
      refused("--part " + dir_.write("open.dxf", DxfWriter().line(0, 0, 9, 9).text()) + rest,
              {"open.dxf", "open contour"}));
  EXPECT_TRUE(refused(part_ + " " + part_ + rest, {"bracket", "twice"}));
  const std::string others = part_ + " " + image_ + " " + distances_;
  EXPECT_TRUE(refused(others + " --camera " + dir_.write("c.yaml", "image_width: 3\n"),
                      {"c.yaml", "image_height"}));
  EXPECT_TRUE(refused(part_ + rest + " --params " + dir_.write("p.yaml", "score: {treshold: 1}\n"),
                      {"p.yaml", "score/treshold"}));
  const std::string no_image = part_ + " " + camera_ + " " + distances_;
  EXPECT_TRUE(refused(no_image + " --image " + dir_.write("i.png", "no picture"),
                      {"i.png", "cannot be read"}));
  cv::imwrite(dir_.path("small.png"), cv::Mat(20, 30, CV_8U, cv::Scalar(9)));
  EXPECT_TRUE(refused(no_image + " --image " + dir_.path("small.png"), {"30 x 20", "2448 x 2048"}));
}

TEST_F(LocateImage, AnswersNoMorePartsThanAskedFor) {
  const std::string all = part_ + " " + camera_ + " " + image_ + " " + distances_ + " --output ";
  const std::string result = dir_.path("result.yaml"), best = dir_.path("best.yaml");
  ASSERT_EQ(run(all + result + " --face any --max-parts 0"), 0) << error_;
  ASSERT_EQ(run(all + best + " --max-parts 2"), 0) << error_;
  const YAML::Node detections = YAML::LoadFile(result)["detections"];
  const YAML::Node first = YAML::LoadFile(best)["detections"];
  ASSERT_GT(detections.size(), 2u);
  ASSERT_EQ(first.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(first[i]["position"][0].as<double>(), detections[i]["position"][0].as<double>(),
                1e-6);
  }
}

TEST_F(LocateImage, AnswersOnlyTheFaceAskedFor) {
  const std::string result = dir_.path("result.yaml");
  for (const std::string face : {"front", "back"}) {
    ASSERT_EQ(run(part_ + " " + camera_ + " " + image_ + " " + distances_ + " --face " + face +
                  " --output " + result),
              0)
        << error_;
    const YAML::Node detections = YAML::LoadFile(result)["detections"];
    EXPECT_GT(detections.size(), 2u) << face;
    for (const YAML::Node& detection : detections)
      EXPECT_EQ(detection["face"].as<std::string>(), face);
  }
}

TEST_F(LocateImage, RefusesDistancesAndSizesThatMakeNoSense) {
  const std::string all = part_ + " " + camera_ + " " + image_;
  for (const auto& [least, most] : {std::pair{"1e-12", "1e-11"},
                                    {"1e-300", "1"},
                                    {"0.3", "1e300"},
                                    {"1e-5", "1"},
                                    {"200", "300"}}) {
    EXPECT_TRUE(refused(all + " --distance-min " + least + " --distance-max " + most,
                        {"distances", "0.01", "100"}));
  }
  // Inches taken for millimetres.
  const std::string small = dir_.write("small.dxf", DxfWriter().rectangle(0, 0, 4.7, 3.1).text());
  EXPECT_TRUE(refused("--part " + small + " " + camera_ + " " + image_ + " " + distances_,
                      {"small", "4.7 x 3.1 mm", "pixels", "units: inch"}));
}

/// A pipe without a writer would hold the program up for ever.
TEST_F(LocateImage, RefusesWhatIsNoRegularFile) {
  ASSERT_EQ(mkfifo(dir_.path("pipe.yaml").c_str(), 0600), 0);
  std::filesystem::create_directory(dir_.path("folder.yaml"));
  for (const char* name : {"pipe.yaml", "folder.yaml"}) {
    const std::string path = dir_.path(name);
    const std::vector<std::string> words = {name, "no regular file"};
    EXPECT_TRUE(refused("--part " + path + " " + camera_ + " " + image_ + " " + distances_, words));
    EXPECT_TRUE(refused(part_ + " --camera " + path + " " + image_ + " " + distances_, words));
    EXPECT_TRUE(refused(part_ + " " + camera_ + " --image " + path + " " + distances_, words));
    EXPECT_TRUE(refused(
        part_ + " " + camera_ + " " + image_ + " " + distances_ + " --params " + path, words));
  }
  EXPECT_TRUE(refused(part_ + " " + camera_ + " " + image_ + " " + distances_ + " --params " +
                          dir_.write("self.yaml", "score: &it {threshold: *it}\n"),
                      {"self.yaml", "alias"}));
}

/// Also what libraries have to say about it is part of the one line.
TEST_F(LocateImage, RefusesPicturesThatAreNotWhole) {
  const std::string rest = part_ + " " + camera_ + " " + distances_ + " --image ";
  const std::string picture =
      read(std::string(PACKAGE_DIR) + "/test/data/bin_bracket_00/image.png");
  EXPECT_TRUE(refused(rest + dir_.write("half.png", picture.substr(0, picture.size() / 2)),
                      {"half.png", "whole"}));
  std::string damaged = picture;
  for (int i = 0; i < 100; ++i) damaged[20000 + i] = 'x';
  EXPECT_TRUE(refused(rest + dir_.write("damaged.png", damaged), {"damaged.png", "whole"}));
  EXPECT_TRUE(refused(rest + dir_.write("empty.png", ""), {"empty.png", "whole"}));
  cv::Mat noise(2048, 2448, CV_8U);
  cv::randu(noise, 0, 255);
  cv::imwrite(dir_.path("whole.jpg"), noise);
  const std::string jpeg = read(dir_.path("whole.jpg"));
  EXPECT_TRUE(refused(rest + dir_.write("half.jpg", jpeg.substr(0, jpeg.size() / 2)),
                      {"half.jpg", "whole"}));
}

/// A JPEG whose EXIF data say that it has to be turned by a quarter to the right to be shown.
std::string turnedJpeg(const cv::Mat& as_stored) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", as_stored, bytes, {cv::IMWRITE_JPEG_QUALITY, 98});
  const std::string exif(
      "\xFF\xE1\x00\x22"
      "Exif\0\0MM\0*\0\0\0\x08"                   // big end first, the directory after this
      "\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0"  // one entry: orientation, a short, 6
      "\0\0\0\0",                                 // no further directory
      36);
  return std::string(bytes.begin(), bytes.begin() + 2) + exif +
         std::string(bytes.begin() + 2, bytes.end());
}

TEST_F(LocateImage, TakesPicturesAsTheyAreShown) {
  const std::string scene = std::string(PACKAGE_DIR) + "/test/data/bin_bracket_00/image.png";
  const cv::Mat shown = cv::imread(scene, cv::IMREAD_GRAYSCALE);
  cv::Mat stored;
  cv::rotate(shown, stored, cv::ROTATE_90_COUNTERCLOCKWISE);
  const std::string jpeg = dir_.write("turned.jpg", turnedJpeg(stored));
  const std::string all = part_ + " " + camera_ + " " + distances_ + " --max-parts 1 --output ";
  const std::string of_png = dir_.path("png.yaml"), of_jpeg = dir_.path("jpeg.yaml");
  ASSERT_EQ(run(all + of_png + " " + image_), 0) << error_;
  ASSERT_EQ(run(all + of_jpeg + " --image " + jpeg), 0) << error_;
  const YAML::Node png = YAML::LoadFile(of_png)["detections"];
  const YAML::Node turned = YAML::LoadFile(of_jpeg)["detections"];
  ASSERT_EQ(turned.size(), 1u);
  for (int i = 0; i < 3; ++i)  // JPEG costs a tenth of a pixel, some 0.05 mm; more along the axis
    EXPECT_NEAR(turned[0]["position"][i].as<double>(), png[0]["position"][i].as<double>(), 1e-3);

  cv::imwrite(dir_.path("upright.jpg"), stored);  // says nothing: it is shown as it is stored
  EXPECT_TRUE(refused(all + of_jpeg + " --image " + dir_.path("upright.jpg"),
                      {"2048 x 2448", "2448 x 2048", "same way up"}));
}

TEST_F(LocateImage, RefusesWhereItCannotWriteBeforeItWorks) {
  const std::string all = part_ + " " + camera_ + " " + image_ + " " + distances_;
  EXPECT_TRUE(refused(all + " --output " + dir_.path("no/such/result.yaml"),
                      {"no/such/result.yaml", "no folder"}));
  EXPECT_TRUE(
      refused(all + " --overlay " + dir_.path("no/overlay.png"), {"no/overlay.png", "no folder"}));
  EXPECT_TRUE(
      refused(all + " --overlay " + dir_.path("overlay.unknown"), {"overlay.unknown", ".png"}));
  ASSERT_EQ(mkfifo(dir_.path("pipe.png").c_str(), 0600), 0);
  for (const char* option : {" --output ", " --overlay "}) {
    EXPECT_TRUE(refused(all + option + dir_.path("pipe.png"), {"pipe.png", "no regular file"}));
    EXPECT_TRUE(refused(all + option + dir_.path(""), {"a folder"}));
  }
  // What it reads must not be written over.
  const std::string own = dir_.write("own.yaml", "drawing: own.dxf\n");
  EXPECT_TRUE(refused("--part " + own + " " + camera_ + " " + image_ + " " + distances_ +
                          " --output " + dir_.path("./own.yaml"),
                      {"own.yaml", "what is read"}));
  EXPECT_EQ(read(own), "drawing: own.dxf\n");
  EXPECT_TRUE(refused(all + " --output " + dir_.path("a.png") + " --overlay " + dir_.path("a.png"),
                      {"one file"}));
  // A disk that is full is found out only then.
  EXPECT_TRUE(refused(all + " --output /dev/full", {"/dev/full", "cannot be written"}));
}

}  // namespace
}  // namespace planar_bin_picking
