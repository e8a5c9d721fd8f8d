#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <zlib.h>

#include <gtest/gtest.h>

#include <chasles/base/processor_time.hpp>

// Generators of files that claim or nest more than a reader may take, shared by tests and fuzzers.
namespace chasles::test {

/// Fails unless the rest of the scope takes less than two seconds of the processor, many times what
/// it takes; the faults that it is for took a minute or the whole memory.
class BombStopwatch {
 public:
  BombStopwatch() : started_(processor_seconds()) {}
  BombStopwatch(const BombStopwatch&) = delete;
  BombStopwatch& operator=(const BombStopwatch&) = delete;
  ~BombStopwatch() { EXPECT_LT(processor_seconds() - started_, 2); }

 private:
  double started_;
};

inline std::string little_endian(std::uint32_t number) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(number >> (8 * i) & 255);
  return bytes;
}

/// A gzip file of these bytes.
inline std::string gzipped(const std::string& bytes) {
  z_stream stream{};
  deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// A gzip file of zeros in `compressed` bytes, between header and trailer, that claims a length.
inline std::string gzip_claiming(std::uint32_t claimed, std::size_t compressed) {
  return std::string("\x1f\x8b\x08\0\0\0\0\0\x02\xff", 10) + std::string(compressed, '\0') +
         little_endian(0) + little_endian(claimed);
}

/// An element of a version 5 MATLAB file: its tag, and its data padded to eight bytes.
inline std::string mat_element(std::uint32_t type, const std::string& data) {
  std::string bytes = little_endian(type) + little_endian(static_cast<std::uint32_t>(data.size()));
  bytes += data;
  while (bytes.size() % 8 != 0) bytes += '\0';
  return bytes;
}

/// Flags, sizes and name of an array of one element: of class 1 a cell, 2 a struct, 6 a number.
inline std::string mat_array_head(char kind, const std::string& name = "") {
  return mat_element(6, std::string(1, kind) + std::string(7, '\0')) +
         mat_element(5, little_endian(1) + little_endian(1)) + mat_element(1, name);
}

/// The length of the names of a struct's fields, within its tag as MATLAB writes it.
inline std::string mat_name_length(std::uint32_t length) {
  return little_endian(4 << 16 | 5) + little_endian(length);
}

/// A struct whose names of fields, of one byte each, claim `size` bytes.
inline std::string mat_struct_claiming(std::uint32_t size) {
  return mat_element(
      14, mat_array_head(2) + mat_name_length(1) + little_endian(1) + little_endian(size));
}

/// A struct without fields, whose length of a name is beside its tag. A reader that expects it
/// within takes the zeros behind it, here `size`, for the size of the names.
inline std::string mat_struct_beside(std::uint32_t size) {
  const std::string length = little_endian(5) + little_endian(4) + little_endian(1);
  return mat_element(14, mat_array_head(2) + length + little_endian(size) + mat_element(1, ""));
}

/// Cells of one cell each, and in the innermost an empty array.
inline std::string nested_mat_cells(std::size_t depth) {
  const std::string head = mat_array_head(1);
  std::string bytes;
  for (std::size_t left = depth; left > 0; --left) {
    bytes += little_endian(14);
    bytes += little_endian(static_cast<std::uint32_t>(left * (head.size() + 8)));
    bytes += head;
  }
  return bytes + little_endian(14) + little_endian(0);
}

/// The same element, compressed.
inline std::string mat_compressed(const std::string& element) {
  uLongf size = compressBound(element.size());
  std::string data(size, '\0');
  compress(reinterpret_cast<Bytef*>(data.data()), &size,
           reinterpret_cast<const Bytef*>(element.data()), element.size());
  data.resize(size);
  return little_endian(15) + little_endian(static_cast<std::uint32_t>(size)) + data;
}

/// A version 5 MATLAB file of these elements.
inline std::string mat_file(const std::string& elements) {
  std::string header = "MATLAB 5.0 MAT-file";
  header.resize(124, ' ');
  return header + std::string("\0\x01IM", 4) + elements;
}

}  // namespace chasles::test
