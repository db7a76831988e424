// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planar_bin_picking/calibrate/board/board_print.h"

#include "calibrate/board/markers.h"
#include "planar_bin_picking/calibrate/board/board_file.h"

#include <algorithm>
#include <array>
#include <iomanip>
#include <locale>
#include <sstream>
#include <vector>

namespace planar_bin_picking {
namespace {

/// Millimetres: the least white about the board, which holds the rulers, too.
constexpr double kRim = 20.0;
constexpr double kRulerMost = 100.0, kRulerStep = 10.0;

std::ostringstream classicText() {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  return text;
}

std::string millimetres(double value) {
  std::ostringstream text = classicText();
  text << std::setprecision(6) << value << " mm";
  return text.str();
}

/// Operators of a PDF page; millimetres from its lower left corner.
class Page {
 public:
  Page() {
    out_ << std::fixed << std::setprecision(4) << kPoints << " 0 0 " << kPoints << " 0 0 cm\n";
  }

  void setGrey(int level) { out_ << level << " g\n"; }
  void fill(double x, double y, double width, double height) {
    out_ << x << " " << y << " " << width << " " << height << " re f\n";
  }
  void write(double x, double y, const std::string& text) {
    constexpr double kLetters = 3.0;
    out_ << "BT /F1 " << kLetters << " Tf " << x << " " << y << " Td (" << text << ") Tj ET\n";
  }
  std::string str() const { return out_.str(); }

  static constexpr double kPoints = 72.0 / 25.4;  // of a PDF, in a millimetre

 private:
  std::ostringstream out_ = classicText();
};

struct Size {
  double width = 0.0, height = 0.0;
};

Size paperFor(const Size& content) {
  constexpr std::array<Size, 5> kPapers{
      {{210.0, 297.0}, {297.0, 420.0}, {420.0, 594.0}, {594.0, 841.0}, {841.0, 1189.0}}};
  for (const Size& paper : kPapers) {
    for (const Size& turned : {paper, Size{paper.height, paper.width}}) {
      if (content.width <= turned.width && content.height <= turned.height) return turned;
    }
  }
  return content;
}

/// @param x, y  the board's upper left corner
void drawBoard(const Board& board, double x, double y, Page* page) {
  const double square = 1e3 * board.square;
  page->setGrey(0);
  for (int row = 0; row <= board.rows; ++row) {
    for (int col = 0; col <= board.cols; ++col) {
      if ((col + row) % 2 != 0) continue;
      page->fill(x + col * square, y - (row + 1) * square, square, square);
    }
  }
  if (board.kind != Board::Kind::kCharuco) return;
  const double marker = 1e3 * board.marker, rim = 0.5 * (square - marker);
  const std::vector<MarkerSquare> squares = markerSquares(board, true);
  for (std::size_t i = 0; i < squares.size(); ++i) {
    const cv::Mat_<unsigned char> modules = markerModules(board, static_cast<int>(i));
    const double left = x + squares[i].col * square + rim, top = y - squares[i].row * square - rim;
    const double module = marker / modules.rows;
    page->setGrey(0);
    page->fill(left, top - marker, marker, marker);
    page->setGrey(1);
    for (int row = 0; row < modules.rows; ++row) {
      for (int col = 0; col < modules.cols; ++col) {
        if (modules(row, col) == 0) continue;
        page->fill(left + col * module, top - (row + 1) * module, module, module);
      }
    }
  }
}

/// Along x or, turned, along y; a long tick each centimetre.
void drawRuler(double x, double y, double length, bool is_upright, Page* page) {
  constexpr double kThin = 0.2, kShort = 2.0, kLong = 4.0;
  page->setGrey(0);
  const auto bar = [&](double along, double across, double long_side, double short_side) {
    if (is_upright) {
      page->fill(x + across, y + along, short_side, long_side);
    } else {
      page->fill(x + along, y + across, long_side, short_side);
    }
  };
  bar(0.0, 0.0, length, kThin);
  for (int mm = 0; mm <= static_cast<int>(length); ++mm) {
    const double tick = mm % 10 == 0 ? kLong : mm % 5 == 0 ? 0.5 * (kShort + kLong) : kShort;
    bar(mm - 0.5 * kThin, 0.0, kThin, tick);
  }
}

std::string wordsFor(const Board& board, double ruler) {
  std::ostringstream text = classicText();
  text << nameOf(board.kind) << ", " << board.cols << "x" << board.rows << " inner corners, square "
       << millimetres(1e3 * board.square);
  if (board.kind == Board::Kind::kCharuco) {
    text << ", marker " << millimetres(1e3 * board.marker) << ", " << board.dictionary;
  }
  text << ". Print at 100 %; each ruler must be " << millimetres(ruler) << " long.";
  return text.str();
}

/// The file about the operators of its one page.
std::string pdfOf(const Size& paper, const std::string& operators) {
  std::ostringstream page = classicText();
  page << "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 " << paper.width * Page::kPoints << " "
       << paper.height * Page::kPoints
       << "] /Contents 4 0 R /Resources << /Font << /F1 5 0 R >> >> >>";
  const std::array<std::string, 5> objects{
      // Viewers would fit the page to the printer's paper otherwise.
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>", page.str(),
      "<< /Length " + std::to_string(operators.size()) + " >>\nstream\n" + operators + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::ostringstream out = classicText(), table = classicText();
  out << "%PDF-1.4\n";
  table << "0000000000 65535 f \n";
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table << std::setw(10) << std::setfill('0') << out.tellp() << " 00000 n \n";
    out << i + 1 << " 0 obj\n" << objects[i] << "\nendobj\n";
  }
  const auto at = out.tellp();
  out << "xref\n0 " << objects.size() + 1 << "\n"
      << table.str() << "trailer\n<< /Size " << objects.size() + 1 << " /Root 1 0 R >>\nstartxref\n"
      << at << "\n%%EOF\n";
  return out.str();
}

}  // namespace

std::string boardPdf(const Board& board) {
  validate(board);
  if (board.kind == Board::Kind::kCharuco) checkDictionary(board);
  const double width = 1e3 * board.square * (board.cols + 1);
  const double height = 1e3 * board.square * (board.rows + 1);
  const Size paper = paperFor({width + 2.0 * kRim, height + 2.0 * kRim});
  const double left = 0.5 * (paper.width - width), bottom = 0.5 * (paper.height - height);
  Page page;
  drawBoard(board, left, bottom + height, &page);
  // Whole centimetres that the paper holds.
  const double most = std::min({kRulerMost, paper.width - kRim, paper.height - kRim});
  const double ruler = kRulerStep * static_cast<int>(most / kRulerStep);
  constexpr double kOff = 9.0;  // from the board
  drawRuler(left, bottom - kOff, ruler, false, &page);
  drawRuler(left - kOff, bottom, ruler, true, &page);
  page.write(left, bottom - kOff - 5.0, wordsFor(board, ruler));
  return pdfOf(paper, page.str());
}

}  // namespace planar_bin_picking
