#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/sim/texture_materials.hpp>

namespace chasles {
namespace {

constexpr Material kAll[] = {Material::kWall, Material::kFloor, Material::kCeiling, Material::kBox};

Canvas painted(Material material, std::uint64_t seed, std::uint64_t number) {
  return paint_surface({.material = material,
                        .width_m = 4,
                        .height_m = 2.8,
                        .texel = 0.01,
                        .seed = seed,
                        .number = number,
                        .lamps = {}});
}

// Shades minus the mean of their row, because skirting boards and dados are the same on many walls.
std::vector<double> without_rows(const Canvas& canvas) {
  std::vector<double> result;
  for (int y = 0; y < canvas.height; ++y) {
    const std::uint8_t* row = canvas.pixels.data() + static_cast<std::size_t>(y * canvas.width);
    double mean = 0;
    for (int x = 0; x < canvas.width; ++x) mean += double{1} * row[x] / canvas.width;
    for (int x = 0; x < canvas.width; ++x) result.push_back(row[x] - mean);
  }
  return result;
}

double correlation(const Canvas& a, const Canvas& b) {
  const std::vector<double> p = without_rows(a), q = without_rows(b);
  double pp = 0, qq = 0, pq = 0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    pp += p[i] * p[i];
    qq += q[i] * q[i];
    pq += p[i] * q[i];
  }
  return pq / std::sqrt(pp * qq);
}

TEST(PaintSurface, NoTwoSurfacesAreAlike) {
  for (const Material material : kAll) {
    const Canvas first = painted(material, 1, 1);
    EXPECT_NEAR(correlation(first, first), 1, 1e-9);
    for (std::uint64_t number = 2; number < 6; ++number) {
      EXPECT_LT(std::abs(correlation(first, painted(material, 1, number))), 0.45);
    }
    EXPECT_LT(std::abs(correlation(first, painted(material, 2, 1))), 0.45);
  }
}

// A repetition in a picture would give a high correlation at some shift.
TEST(PaintSurface, NoSurfaceRepeatsItself) {
  for (const Material material : {Material::kWall, Material::kFloor}) {
    const Canvas canvas = painted(material, 3, 9);
    const std::vector<double> shades = without_rows(canvas);
    for (int shift = 25; shift < canvas.width / 2; shift += 5) {
      double pp = 0, pq = 0;
      for (int y = 0; y < canvas.height; ++y) {
        for (int x = 0; x + shift < canvas.width; ++x) {
          const auto i = static_cast<std::size_t>(y * canvas.width + x);
          pp += shades[i] * shades[i];
          pq += shades[i] * shades[i + static_cast<std::size_t>(shift)];
        }
      }
      EXPECT_LT(pq / pp, 0.6) << "at a shift of " << shift;
    }
  }
}

TEST(PaintSurface, TheSameSurfaceIsTheSamePicture) {
  for (const Material material : kAll) {
    EXPECT_EQ(painted(material, 5, 2).pixels, painted(material, 5, 2).pixels);
  }
}

TEST(PaintSurface, AChessboardHasItsCornersWhereTheyBelong) {
  const Canvas canvas = painted(Material::kChessboard, 0, 0);
  const auto at = [&](double x, double y) {
    const auto i = static_cast<int>(x / 0.01), j = static_cast<int>(y / 0.01);
    return canvas.pixels[static_cast<std::size_t>(j * canvas.width + i)];
  };
  EXPECT_EQ(at(0.245, 0.245), 40);
  EXPECT_EQ(at(0.255, 0.245), 210);
  EXPECT_EQ(at(0.245, 0.255), 210);
  EXPECT_EQ(at(0.255, 0.255), 40);
}

TEST(PaintSurface, ASpeckIsACanvasToo) {
  for (const Material material : kAll) {
    const Canvas canvas = paint_surface({.material = material,
                                         .width_m = 0.001,
                                         .height_m = 0.02,
                                         .texel = 0.01,
                                         .seed = 1,
                                         .number = 1,
                                         .lamps = {}});
    EXPECT_EQ(canvas.width, 2);
    EXPECT_EQ(canvas.pixels.size(), 4U);
  }
}

}  // namespace
}  // namespace chasles
