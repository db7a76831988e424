// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause

/// Draws a calibration board as a PDF file, to print.
/// Exit status: 0; 2, with one line on stderr, on bad input.

#include "base/atomic_file.h"
#include "command_line.h"

#include "planar_bin_picking/calibrate/board/board_file.h"
#include "planar_bin_picking/calibrate/board/board_print.h"

#include <filesystem>

namespace planar_bin_picking {
namespace {

struct Options {
  std::string board_file, board, output;
  double square = 0.0;
};

void addOptions(CLI::App* app, Options* options) {
  auto* const file =
      app->add_option("--board-file", options->board_file,
                      "the board as YAML: kind, corners, square, and for charuco marker and "
                      "dictionary; config/board.yaml is an example")
          ->type_name("F")
          ->check(wrongPath);
  auto* const board =
      app->add_option("--board", options->board, "in its place, inner corners of a checkerboard")
          ->type_name("CxR");
  auto* const square = app->add_option("--square", options->square, "side of a square, metres")
                           ->type_name("M")
                           ->check(wrongMetres);
  board->excludes(file)->needs(square);
  square->excludes(file)->needs(board);
  app->add_option("--output", options->output, "the PDF file, at true size")
      ->required()
      ->type_name("F")
      ->check(wrongPath);
  app->footer(
      "Print at 100 %, without fitting to the page, and measure both rulers. Exit status: 0; 2, "
      "with one "
      "line on stderr, on bad input.");
}

int run(const Options& options) {
  if (options.board_file.empty() && options.board.empty()) {
    throw std::invalid_argument("give --board-file, or --board and --square");
  }
  const Board board = options.board_file.empty() ? parseBoard(options.board, options.square)
                                                 : loadBoard(options.board_file);
  writeTogether({{options.output, boardPdf(board)}});
  std::printf("written to %s\n",
              std::filesystem::absolute(options.output).lexically_normal().c_str());
  return kDone;
}

}  // namespace
}  // namespace planar_bin_picking

int main(int argc, char** argv) {
  using namespace planar_bin_picking;
  Options options;
  CLI::App app("Draws a calibration board as a PDF file, to print.", "draw_board");
  addOptions(&app, &options);
  return runTool(&app, argc, argv, [&] { return run(options); });
}
