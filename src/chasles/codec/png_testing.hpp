#pragma once

#include <array>
#include <cstdint>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>
#include <zlib.h>

// A plain writer of PNG files of every kind, by the formulas of the specification, with zlib: the
// reader uses neither. OpenCV's reader (libpng) decides on both.
namespace chasles::test {

struct PngKind {
  std::uint32_t width = 8, height = 6;
  int depth = 8, colour = 0;
  bool interlaced = false;
  int filter = -1;  // of all rows; -1: a random one for each
};

inline std::string png_chunk(const std::string& name, const std::string& content) {
  const auto number = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
    return bytes;
  };
  const std::string body = name + content;
  const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(body.data()), body.size());
  return number(static_cast<std::uint32_t>(content.size())) + body +
         number(static_cast<std::uint32_t>(sum));
}

inline std::string zlib_bytes(const std::string& content) {
  uLongf size = compressBound(static_cast<uLong>(content.size()));
  std::string bytes(size, '\0');
  compress(reinterpret_cast<Bytef*>(bytes.data()), &size,
           reinterpret_cast<const Bytef*>(content.data()), static_cast<uLong>(content.size()));
  bytes.resize(size);
  return bytes;
}

inline int png_prediction(int filter, int a, int b, int c) {
  const int p = a + b - c;
  const int pa = std::abs(p - a), pb = std::abs(p - b), pc = std::abs(p - c);
  const int paeth = pa <= pb && pa <= pc ? a : pb <= pc ? b : c;
  return std::array{0, a, b, (a + b) / 2, paeth}[static_cast<std::size_t>(filter)];
}

// A row's filter and its filtered bytes. `above` is empty for the first row.
inline std::string png_row(const std::string& row, const std::string& above, std::size_t pixel,
                           int filter) {
  std::string out(1, static_cast<char>(filter));
  const auto at = [](const std::string& bytes, std::size_t i, std::size_t back) {
    return i < back || bytes.empty() ? 0 : static_cast<unsigned char>(bytes[i - back]);
  };
  for (std::size_t i = 0; i < row.size(); ++i) {
    const int guess =
        png_prediction(filter, at(row, i, pixel), at(above, i, 0), at(above, i, pixel));
    out += static_cast<char>(static_cast<unsigned char>(row[i]) - guess);
  }
  return out;
}

/// Filtered rows of random pixels, which vary slowly so that all predictions matter.
inline std::string random_png_rows(const PngKind& kind, std::mt19937& random) {
  const int channels = std::array{1, 0, 3, 1, 2, 0, 4}[static_cast<std::size_t>(kind.colour)];
  const std::size_t bits = static_cast<std::size_t>(channels * kind.depth);
  struct Pass {
    std::uint32_t x, y, dx, dy;
  };
  std::vector<Pass> passes{{0, 0, 1, 1}};
  if (kind.interlaced) {
    passes = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
              {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
  }
  std::string rows;
  for (const auto& [x, y, dx, dy] : passes) {
    const std::size_t width = (kind.width + dx - 1 - x) / dx;
    std::string above;
    for (std::uint32_t v = y; width > 0 && v < kind.height; v += dy) {
      std::string row((width * bits + 7) / 8, '\0');
      int value = static_cast<int>(random() % 256);
      for (char& byte : row)
        byte = static_cast<char>(value += static_cast<int>(random() % 41) - 20);
      const int filter = kind.filter < 0 ? static_cast<int>(random() % 5) : kind.filter;
      rows += png_row(row, above, std::max<std::size_t>(1, bits / 8), filter);
      above = row;
    }
  }
  return rows;
}

/// A PNG of rows, in two parts, as writers with small buffers make them.
inline std::string png_of(const std::string& header, const std::string& palette,
                          const std::string& rows) {
  const std::string deflated = zlib_bytes(rows);
  const std::size_t half = deflated.size() / 2;
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) +
         (palette.empty() ? "" : png_chunk("PLTE", palette)) +
         png_chunk("IDAT", deflated.substr(0, half)) + png_chunk("IDAT", deflated.substr(half)) +
         png_chunk("IEND", "");
}

inline std::string png_header_of(const PngKind& kind) {
  std::string header;
  for (const std::uint32_t side : {kind.width, kind.height}) {
    for (int shift = 24; shift >= 0; shift -= 8) header += static_cast<char>(side >> shift & 255);
  }
  for (const int byte : {kind.depth, kind.colour, 0, 0, kind.interlaced ? 1 : 0}) {
    header += static_cast<char>(byte);
  }
  return header;
}

inline std::string random_png(const PngKind& kind, unsigned seed) {
  std::mt19937 random(seed);
  const std::string rows = random_png_rows(kind, random);
  std::string palette;
  if (kind.colour == 3) {
    for (int i = 0; i < 3 << kind.depth; ++i) palette += static_cast<char>(random());
  }
  return png_of(png_header_of(kind), palette, rows);
}

}  // namespace chasles::test
