// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Puts a drawing, or what a STEP file shows of a flat part, into a parts folder, with a part file
/// to begin with and a picture to look at. Exit status: 0; 2, with one line on stderr, where it is
/// refused: the folder is as it was.

#include "command_line.h"
#include "step_file.h"
#include "write_picture.h"

#include "base/yaml_text.h"
#include "planar_bin_picking/part/part_summary.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>

namespace planar_bin_picking {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string drawing, folder, name, units;
  std::optional<double> thickness_mm;
};

/// What is set, and what else can be, to be filled in.
std::string partText(const Options& options, const PartModel& part) {
  const Eigen::Vector2d center_mm = 1e3 * part.center();
  const std::string at = yamlNumber(center_mm.x(), 1) + ", " + yamlNumber(center_mm.y(), 1);
  const std::string thickness = yamlNumber(options.thickness_mm.value_or(0.0), 3);
  return "drawing: " + yamlText(options.name + ".dxf") + "\n" +
         (options.thickness_mm.value_or(0.0) > 0.0 ? "" : "# 0: unknown\n") +
         "thickness_mm: " + thickness + "\n" +
         (options.units.empty() ? "" : "units: " + options.units + "\n") +
         "# Where the tool goes, the preferred one first; this is the middle of the outline. z "
         "points into the part.\n"
         "# pick_poses:\n"
         "#   - {name: suction, face: front, position_mm: [" +
         at +
         ", 0], rpy_deg: [180, 0, 0]}\n"
         "#   - {name: suction_back, face: back, position_mm: [" +
         at + ", -" + thickness +
         "]}\n"
         "# tool_radius_mm: 8\n"
         "# doc/parts.md explains these and the other keys, such as keep_layers, skip_layers and "
         "print_layers.\n";
}

void writeText(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  if (!file) throw std::runtime_error(path.string() + ": cannot be written; check the disk");
}

/// A folder of its own, gone at the end.
class Scratch {
 public:
  explicit Scratch(const fs::path& beside)
      : path_(beside / (".add_part_" + std::to_string(getpid()))) {
    std::error_code error;
    fs::create_directory(path_, error);
    if (error)
      throw std::runtime_error(beside.string() + ": cannot be written to (" + error.message() +
                               "); check its permissions, or give another folder");
  }
  ~Scratch() {
    std::error_code ignored;  // nothing is lost by it
    fs::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// What a file's name cannot hold, or what hides it.
void checkName(const std::string& name) {
  const bool is_odd = std::any_of(name.begin(), name.end(), [](const unsigned char c) {
    return c == '/' || std::iscntrl(c) != 0;
  });
  if (is_odd || name.front() == '.')
    throw std::invalid_argument("--name is \"" + name +
                                "\", must have no slash, no line break and no dot in front");
}

void checkDrawing(const std::string& drawing) {
  constexpr char kRemedy[] = "; give a drawing (.dxf), or a STEP file (.step, .stp) of a flat part";
  const fs::path path(drawing);
  if (!fs::exists(path)) throw std::invalid_argument(drawing + ": does not exist" + kRemedy);
  std::string kind = path.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](const unsigned char c) { return std::tolower(c); });
  if (kind == ".yaml" || kind == ".yml")
    throw std::invalid_argument(drawing + ": is a part file; give the drawing that it names");
  if (kind != ".dxf" && !isStep(drawing))
    throw std::invalid_argument(drawing + ": is neither a drawing nor a STEP file" + kRemedy);
}

void checkThickness(const std::optional<double>& thickness_mm) {
  constexpr double kMost = 1000.0;  // as a part file's
  if (!thickness_mm || (*thickness_mm >= 0.0 && *thickness_mm <= kMost)) return;
  throw std::invalid_argument("--thickness-mm is " + yamlNumber(*thickness_mm) +
                              ", must be between 0 (unknown) and 1000");
}

void checkFree(const Options& options) {
  if (!fs::is_directory(options.folder))
    throw std::runtime_error(options.folder + ": is no folder; give the parts folder");
  for (const char* extension : {".dxf", ".DXF", ".yaml", ".yml"}) {
    const fs::path path = fs::path(options.folder) / (options.name + extension);
    if (fs::exists(path))
      throw std::runtime_error(path.string() + ": is there already; give another --name");
  }
}

/// The drawing as the folder gets it.
/// @return  what is read of it
PartFile takeDrawing(Options* options, const fs::path& dxf) {
  if (!isStep(options->drawing)) {
    PartFile alone = loadPartFile(options->drawing);
    fs::copy_file(options->drawing, dxf);
    return alone;
  }
  const StepPart step = readStep(options->drawing);
  if (!options->thickness_mm) options->thickness_mm = step.thickness_mm;
  writeText(dxf, step.dxf);
  try {
    return loadPartFile(dxf.string());
  } catch (const std::exception& error) {  // it names a file that nobody knows
    throw std::runtime_error(options->drawing +
                             ": the contours of its largest flat face: " + error.what());
  }
}

int run(Options options) {
  const fs::path drawing(options.drawing);
  if (options.name.empty()) options.name = drawing.stem().string();
  checkDrawing(options.drawing);
  checkName(options.name);
  checkThickness(options.thickness_mm);
  if (isStep(options.drawing) && !options.units.empty())
    throw std::invalid_argument("--units is for drawings; a STEP file says its own");
  checkFree(options);
  // In a folder of its own first: a file of the parts folder is read by a locator that runs.
  const Scratch scratch(options.folder);
  const fs::path dxf = scratch.path() / (options.name + ".dxf");
  const fs::path yaml = scratch.path() / (options.name + ".yaml");
  const fs::path png = scratch.path() / (options.name + ".png");
  PartFile alone = takeDrawing(&options, dxf);
  alone.thickness = 0.0;
  writeText(yaml, partText(options, PartModel(std::move(alone))));
  PartModel part(loadPartFile(yaml.string()));
  if (!options.units.empty()) {  // the middle of the outline has moved with the unit
    writeText(yaml, partText(options, part));
    part = PartModel(loadPartFile(yaml.string()));
  }
  writePartPicture(png.string(), part);
  for (const fs::path& path : {png, yaml, dxf})
    fs::rename(path, fs::path(options.folder) / path.filename());
  std::fputs(toYaml(describePart(part)).c_str(), stdout);
  return kDone;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  Options options;
  CLI::App app("Puts a drawing into a parts folder, with a part file and a picture.", "add_part");
  app.add_option("DRAWING", options.drawing,
                 "a .dxf file, which is copied; or a .step or .stp file of one flat part")
      ->required();
  app.add_option("FOLDER", options.folder, "the parts folder")->required();
  app.add_option("--name", options.name, "of the part; default: as the drawing is called");
  app.add_option("--thickness-mm", options.thickness_mm,
                 "of the part; default: the STEP file's, or 0: unknown");
  app.add_option("--units", options.units, "of the drawing, in place of what it says of itself")
      ->check(CLI::IsMember({"mm", "cm", "m", "inch"}));
  app.footer(
      "It prints what was read, as describe_part does. A locator that runs takes the part in by\n"
      "itself. Exit status: 0; 2, with one line on stderr, where it is refused.");
  return runTool(&app, argc, argv, [&] { return run(options); });
}
