#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_print.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

constexpr double kMargin = 12;  // [mm] white around the board; printers leave 5 mm out
constexpr double kFooter = 16;  // [mm] for the ruler and two lines of text
constexpr double kRuler = 100;  // [mm]
constexpr double kTextSize = 3.2;
constexpr double kPointsOfMm = 72 / 25.4;

const std::array<std::pair<const char*, Sheet>, 6> kSheets = {{{"A4", {210, 297}},
                                                               {"letter", {215.9, 279.4}},
                                                               {"A3", {297, 420}},
                                                               {"A2", {420, 594}},
                                                               {"A1", {594, 841}},
                                                               {"A0", {841, 1189}}}};

// What is black on a sheet, and the text: in mm from its upper left corner, y down.
struct Text {
  Vector2d at;  // of the left end of the line on which the letters stand
  std::string words;
};
struct Drawing {
  Sheet sheet;
  std::vector<PrintedRectangle> black;  // lower_left has the smaller numbers
  std::vector<Text> texts;
};

Vector2d size_of_board(const Target& target) {
  const PrintedRectangle outline = board_outline(target);
  return 1e3 * (outline.upper_right - outline.lower_left);
}

Vector2d needed(const Target& target) {
  return size_of_board(target).cwiseMax(Vector2d(kRuler, 0)) +
         Vector2d(2 * kMargin, 2 * kMargin + kFooter);
}

bool fits_on(const Vector2d& size, const Sheet& sheet) {
  return size.x() <= sheet.width + 1e-6 && size.y() <= sheet.height + 1e-6;
}

Sheet lying(const Sheet& sheet) { return {sheet.height, sheet.width}; }

std::string fitting_sheets(const Vector2d& size) {
  std::string names;
  for (const auto& [name, sheet] : kSheets) {
    if (fits_on(size, sheet) || fits_on(size, lying(sheet))) names += std::string(name) + ", ";
  }
  return names + "auto";
}

[[noreturn]] void reject_sheet(const Vector2d& size, const Sheet& sheet, const std::string& name) {
  throw UsageError(fmt::format(
      "the target needs a sheet of {:.0f} x {:.0f} mm with its margins, and {} has {:.0f} x {:.0f} "
      "mm: take one of {}, or a smaller target",
      size.x(), size.y(), name, sheet.width, sheet.height, fitting_sheets(size)));
}

std::string sizes_text(const Target& target) {
  if (target.kind == TargetKind::april_grid) {
    return fmt::format(
        "AprilGrid, {} x {} tags of the family 36h11, {:.6g} mm with their border, "
        "{:.6g} mm apart ({:.6g})",
        target.columns, target.rows, 1e3 * target.tag_size,
        1e3 * target.tag_size * target.tag_spacing, target.tag_spacing);
  }
  if (target.kind == TargetKind::checkerboard) {
    return fmt::format("Checkerboard, {} x {} inner corners, {:.6g} x {:.6g} mm apart",
                       target.columns, target.rows, 1e3 * target.column_spacing,
                       1e3 * target.row_spacing);
  }
  return fmt::format(
      "ChArUco, {} x {} squares of {:.6g} mm, markers of {:.6g} mm, {}, "
      "legacy_pattern {}",
      target.columns, target.rows, 1e3 * target.column_spacing, 1e3 * target.tag_size,
      target.dictionary, target.legacy_pattern);
}

void add_ruler(const Vector2d& at, Drawing& drawing) {
  constexpr double kLine = 0.25;
  drawing.black.push_back({at, at + Vector2d(kRuler, kLine)});
  for (int mm = 0; mm <= kRuler; mm += 10) {
    const double half = kLine / 2, height = mm % 50 == 0 ? 4 : 2.5;
    // The outer edges of the first and the last line are 100 mm apart.
    const double x = at.x() + std::clamp(mm + 0.0, half, kRuler - half);
    drawing.black.push_back({Vector2d(x - half, at.y() - height), Vector2d(x + half, at.y())});
  }
}

Drawing drawing_of(const Target& target, const Sheet& sheet, const std::string& file) {
  validate(target);
  const Vector2d size = needed(target), board = size_of_board(target);
  if (!fits_on(size, sheet)) reject_sheet(size, sheet, "the one chosen");
  Drawing drawing{sheet, {}, {}};
  const Vector2d origin((sheet.width - board.x()) / 2,
                        (sheet.height - kFooter - board.y()) / 2 + board.y());
  const PrintedRectangle outline = board_outline(target);
  for (const PrintedRectangle& r : black_rectangles(target)) {
    const Vector2d low = 1e3 * (r.lower_left - outline.lower_left);
    const Vector2d high = 1e3 * (r.upper_right - outline.lower_left);
    drawing.black.push_back({{origin.x() + low.x(), origin.y() - high.y()},
                             {origin.x() + high.x(), origin.y() - low.y()}});
  }
  const Vector2d footer(kMargin, sheet.height - kMargin / 2);
  add_ruler(footer + Vector2d(0, -11), drawing);
  drawing.texts = {
      {footer + Vector2d(0, -5.5), sizes_text(target)},
      {footer,
       fmt::format("Print without scaling: the ruler must be 100 mm long. Measure the print "
                   "and correct {}.",
                   file)}};
  return drawing;
}

std::string escaped(const std::string& words,
                    std::initializer_list<std::pair<char, const char*>> by) {
  std::string result;
  for (const char c : words) {
    const auto* const found = std::ranges::find(by, c, &std::pair<char, const char*>::first);
    result += found == by.end() ? std::string(1, c) : found->second;
  }
  return result;
}

// The objects of a PDF file, with the table of where they are (ISO 32000-1, 7.5).
class PdfFile {
 public:
  void add(const std::string& object) {
    places_.push_back(text_.size());
    text_ += fmt::format("{} 0 obj\n{}\nendobj\n", places_.size(), object);
  }

  std::string finished() const {
    std::string text = text_;
    text += fmt::format("xref\n0 {}\n0000000000 65535 f \n", places_.size() + 1);
    for (const std::size_t place : places_) text += fmt::format("{:010} 00000 n \n", place);
    return text + fmt::format("trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n",
                              places_.size() + 1, text_.size());
  }

 private:
  std::string text_ = "%PDF-1.4\n";
  std::vector<std::size_t> places_;
};

}  // namespace

std::vector<std::string> sheet_names() {
  std::vector<std::string> names = {"auto"};
  for (const auto& [name, sheet] : kSheets) names.emplace_back(name);
  return names;
}

Sheet sheet_for(const Target& target, const std::string& name) {
  validate(target);
  const Vector2d size = needed(target);
  if (name == "auto") return {std::ceil(size.x()), std::ceil(size.y())};
  for (const auto& [known, sheet] : kSheets) {
    if (name != known) continue;
    if (fits_on(size, sheet)) return sheet;
    if (fits_on(size, lying(sheet))) return lying(sheet);
    reject_sheet(size, sheet, name);
  }
  throw UsageError(fmt::format("paper: found '{}', expected one of {}{}", name,
                               quoted_list(sheet_names()), did_you_mean(name, sheet_names())));
}

std::string target_svg(const Target& target, const Sheet& sheet, const std::string& file) {
  const Drawing drawing = drawing_of(target, sheet, file);
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.6g}mm\" height=\"{1:.6g}mm\" "
      "viewBox=\"0 0 {0:.6g} {1:.6g}\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<path fill=\"black\" d=\"\n",
      sheet.width, sheet.height);
  for (const PrintedRectangle& r : drawing.black) {  // one path, so that no line is between them
    const Vector2d size = r.upper_right - r.lower_left;
    text += fmt::format("M{:.5f} {:.5f}h{:.5f}v{:.5f}h{:.5f}z\n", r.lower_left.x(),
                        r.lower_left.y(), size.x(), size.y(), -size.x());
  }
  text += "\"/>\n";
  for (const Text& t : drawing.texts) {
    text += fmt::format(
        "<text x=\"{:.3f}\" y=\"{:.3f}\" font-family=\"sans-serif\" font-size=\"{}\">{}</text>\n",
        t.at.x(), t.at.y(), kTextSize,
        escaped(t.words, {{'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}}));
  }
  return text + "</svg>\n";
}

std::string target_pdf(const Target& target, const Sheet& sheet, const std::string& file) {
  const Drawing drawing = drawing_of(target, sheet, file);
  std::string page;
  for (const PrintedRectangle& r : drawing.black) {  // one path, as above
    const Vector2d size = kPointsOfMm * (r.upper_right - r.lower_left);
    page += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", kPointsOfMm * r.lower_left.x(),
                        kPointsOfMm * (sheet.height - r.upper_right.y()), size.x(), size.y());
  }
  page += "f\n";
  for (const Text& t : drawing.texts) {
    page += fmt::format("BT /F1 {:.3f} Tf {:.3f} {:.3f} Td ({}) Tj ET\n", kPointsOfMm * kTextSize,
                        kPointsOfMm * t.at.x(), kPointsOfMm * (sheet.height - t.at.y()),
                        escaped(t.words, {{'\\', "\\\\"}, {'(', "\\("}, {')', "\\)"}}));
  }
  PdfFile pdf;
  pdf.add("<< /Type /Catalog /Pages 2 0 R >>");
  pdf.add("<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
  pdf.add(
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R "
                  "/Resources << /Font << /F1 5 0 R >> >> >>",
                  kPointsOfMm * sheet.width, kPointsOfMm * sheet.height));
  pdf.add(fmt::format("<< /Length {} >>\nstream\n{}endstream", page.size(), page));
  pdf.add("<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>");
  return pdf.finished();
}

}  // namespace chasles
