// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/board_file.h"

#include "base/yaml_file.h"
#include "calibrate/board/markers.h"

#include <stdexcept>

namespace planar_bin_picking {

Board::Kind parseKind(const std::string& text) {
  if (text == "checkerboard") return Board::Kind::kCheckerboard;
  if (text == "charuco") return Board::Kind::kCharuco;
  throw std::invalid_argument("board: kind is \"" + text + "\", must be checkerboard or charuco");
}

std::string nameOf(Board::Kind kind) {
  return kind == Board::Kind::kCharuco ? "charuco" : "checkerboard";
}

Board loadBoard(const std::string& path) {
  const YAML::Node root = loadYamlMap(path);
  refuseUnknownKeys(root, path, {"kind", "corners", "square", "marker", "dictionary"});
  const auto text = [&](const char* key, const char* expected) {
    return valueAs<std::string>(root[key], path, key, expected);
  };
  try {
    const Board::Kind kind = parseKind(text("kind", "checkerboard or charuco"));
    Board board = parseBoard(text("corners", "inner corners as COLSxROWS, such as 9x6"),
                             valueAs<double>(root["square"], path, "square", "metres"), "corners");
    board.kind = kind;
    const bool has_markers = kind == Board::Kind::kCharuco;
    for (const char* key : {"marker", "dictionary"}) {
      if (has_markers || !root[key].IsDefined()) continue;
      throwBadValue(path, key, root[key], "left out: a checkerboard has no markers");
    }
    if (!has_markers) return board;
    board.marker = valueAs<double>(root["marker"], path, "marker", "metres");
    board.dictionary = text("dictionary", "one of OpenCV's, such as DICT_4X4_50");
    validate(board);
    checkDictionary(board);
    return board;
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
}

}  // namespace planar_bin_picking
