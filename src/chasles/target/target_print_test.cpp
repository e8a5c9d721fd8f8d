#include <algorithm>
#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/target/tag_layout.hpp>
#include <chasles/target/target_detector.hpp>
#include <chasles/target/target_print.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

const std::vector<Target> kPrints = {
    {.kind = TargetKind::april_grid, .columns = 4, .rows = 3, .tag_size = 0.04, .tag_spacing = 0.3},
    {.kind = TargetKind::checkerboard,
     .columns = 6,
     .rows = 5,
     .column_spacing = 0.03,
     .row_spacing = 0.025},
    {.kind = TargetKind::charuco,
     .columns = 5,
     .rows = 6,
     .tag_size = 0.03,
     .column_spacing = 0.04,
     .row_spacing = 0.04,
     .dictionary = "DICT_4X4_50",
     .legacy_pattern = true}};

// A black rectangle, in mm from the upper left of the sheet.
struct Box {
  double x, y, width, height;
};

// The lines `x y w h re` of a PDF, in points from its lower left.
std::vector<Box> boxes_of_pdf(const std::string& pdf, const Sheet& sheet) {
  std::vector<Box> boxes;
  std::istringstream lines(pdf);
  for (std::string line; std::getline(lines, line);) {
    if (!line.ends_with(" re")) continue;
    Box b{};
    std::istringstream(line) >> b.x >> b.y >> b.width >> b.height;
    const double mm = 25.4 / 72;
    boxes.push_back({b.x * mm, sheet.height - (b.y + b.height) * mm, b.width * mm, b.height * mm});
  }
  return boxes;
}

// The lines `Mx yhwvhh-wz` of an SVG, in mm.
std::vector<Box> boxes_of_svg(std::string svg) {
  std::vector<Box> boxes;
  std::ranges::replace_if(
      svg, [](char c) { return c == 'h' || c == 'v'; }, ' ');
  std::istringstream lines(svg);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('M')) continue;
    Box b{};
    std::istringstream(line.substr(1)) >> b.x >> b.y >> b.width >> b.height;
    boxes.push_back(b);
  }
  return boxes;
}

// The part of [a, a + 1) that is in [low, high).
double overlap(double a, double low, double high) {
  return std::max(0.0, std::min(a + 1, high) - std::max(a, low));
}

// Four pixels for a millimetre, each with the part of it that is white.
constexpr double kPixels = 4;
GrayImage rasterised(const std::vector<Box>& boxes, const Sheet& sheet) {
  const int width = static_cast<int>(kPixels * sheet.width);
  const int height = static_cast<int>(kPixels * sheet.height);
  std::vector<double> black(static_cast<std::size_t>(width) * height);
  for (const Box& b : boxes) {
    const double right = kPixels * (b.x + b.width), bottom = kPixels * (b.y + b.height);
    for (int y = static_cast<int>(kPixels * b.y); y < bottom; ++y) {
      for (int x = static_cast<int>(kPixels * b.x); x < right; ++x) {
        black[static_cast<std::size_t>(y) * width + x] +=
            overlap(x, kPixels * b.x, right) * overlap(y, kPixels * b.y, bottom);
      }
    }
  }
  GrayImage image{width, height, {}};
  for (const double part : black) {
    image.pixels.push_back(static_cast<std::uint8_t>(std::lround(255 * (1 - std::min(1.0, part)))));
  }
  return image;
}

// The distances of the corners in the print are those of the target.
void expect_true_size(const Target& target, const GrayImage& image) {
  const TargetDetection found = TargetDetector(target).detect(image);
  const auto corners = target.corners();
  ASSERT_EQ(found.view.ids.size(), corners.size()) << found.lack;
  const Vector2d first = found.view.pixels[0], p = corners[0].head<2>();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector2d mm = (found.view.pixels[k] - first) / kPixels;
    const Vector2d expected = 1e3 * (corners[k].head<2>() - p);
    EXPECT_NEAR(mm.x(), expected.x(), 0.02);
    EXPECT_NEAR(-mm.y(), expected.y(), 0.02);
  }
}

TEST(TargetPrint, TheDetectorFindsThePrintInItsTrueSize) {
  for (const Target& target : kPrints) {
    const Sheet sheet = sheet_for(target, "auto");
    expect_true_size(target,
                     rasterised(boxes_of_pdf(target_pdf(target, sheet, "b.yaml"), sheet), sheet));
    expect_true_size(target, rasterised(boxes_of_svg(target_svg(target, sheet, "b.yaml")), sheet));
  }
}

TEST(TargetPrint, TheRulerIsAHundredMillimetresLongAndOutsideOfTheBoard) {
  for (const Target& target : kPrints) {
    const Sheet sheet = sheet_for(target, "A3");
    const auto boxes = boxes_of_svg(target_svg(target, sheet, "b.yaml"));
    const std::size_t printed = black_rectangles(target).size();
    ASSERT_EQ(boxes.size(), printed + 12);  // a line and its eleven marks
    const Box line = boxes[printed], first = boxes[printed + 1], last = boxes.back();
    EXPECT_NEAR(line.width, 100, 1e-4);
    EXPECT_NEAR(last.x + last.width - first.x, 100, 1e-4);
    for (std::size_t k = 0; k < printed; ++k) {
      EXPECT_GE(boxes[k].x, 5);
      EXPECT_LE(boxes[k].x + boxes[k].width, sheet.width - 5);
      EXPECT_LT(boxes[k].y + boxes[k].height + 5, first.y) << "white between board and ruler";
    }
  }
}

TEST(TargetPrint, ThePdfHasItsObjectsWhereTheTableSays) {
  const Sheet sheet = sheet_for(kPrints[0], "A4");
  const std::string pdf = target_pdf(kPrints[0], sheet, "name(1)\\.yaml");
  EXPECT_NE(pdf.find("name\\(1\\)\\\\.yaml"), std::string::npos);
  EXPECT_NE(pdf.find("4 x 3 tags"), std::string::npos);
  const std::size_t table = std::stoul(pdf.substr(pdf.find("startxref") + 10));
  ASSERT_EQ(pdf.substr(table, 9), "xref\n0 6\n");
  for (std::size_t k = 1; k <= 5; ++k) {
    const std::size_t place = std::stoul(pdf.substr(table + 9 + 20 * k, 10));
    EXPECT_EQ(pdf.substr(place, 7), std::to_string(k) + " 0 obj");
  }
  const std::size_t stream = pdf.find("stream\n") + 7;
  const std::size_t length = std::stoul(pdf.substr(pdf.find("/Length ") + 8));
  EXPECT_EQ(pdf.substr(stream + length, 9), "endstream");
}

TEST(TargetPrint, TextOfAnSvgIsEscaped) {
  const std::string svg = target_svg(kPrints[0], sheet_for(kPrints[0], "A4"), "a<b>&.yaml");
  EXPECT_NE(svg.find("a&lt;b&gt;&amp;.yaml"), std::string::npos);
}

TEST(TargetPrint, SheetsLieOrStand) {
  const Sheet standing = sheet_for(kPrints[2], "A3");  // 200 x 240 mm
  EXPECT_EQ(standing.width, 297);
  Target wide = kPrints[0];
  wide.columns = 7;
  EXPECT_EQ(sheet_for(wide, "A3").width, 420);
  EXPECT_EQ(sheet_names().front(), "auto");
}

void expect_usage_error(const auto& call, const std::string& part) {
  try {
    call();
    ADD_FAILURE() << "no error, expected " << part;
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(TargetPrint, SheetsThatDoNotFitAreNamed) {
  Target large = kPrints[0];
  large.columns = large.rows = 6;
  large.tag_size = 0.088;
  expect_usage_error([&] { sheet_for(large, "A4"); }, "take one of A0, auto, or a smaller target");
  expect_usage_error([&] { target_pdf(large, {210, 297}, "b.yaml"); }, "210 x 297");
  expect_usage_error([&] { sheet_for(large, "A5"); }, "found 'A5', expected one of 'auto', 'A4'");
  large.tag_size = -1;
  expect_usage_error([&] { sheet_for(large, "auto"); }, "tag_size: found -1");
}

}  // namespace
}  // namespace chasles
