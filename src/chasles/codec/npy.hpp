#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace chasles {

/// How an .npy file stores a number.
enum class NpyType {
  kFloat64,
  kFloat32,
  kInt8,
  kInt16,
  kInt32,
  kInt64,
  kUint8,
  kUint16,
  kUint32,
  kUint64
};

/// The bytes of one number.
std::size_t npy_size(NpyType type);

/// The header of an .npy file (numpy's format, versions 1.0 to 3.0).
struct NpyHeader {
  NpyType type = NpyType::kFloat64;
  bool fortran_order = false;      ///< first index fastest
  std::vector<std::size_t> shape;  ///< empty: a single number
  std::size_t count = 1;           ///< the product of the shape
};

/// The length of the preamble before the header text: 10 bytes (version 1) or 12 (versions 2, 3).
inline constexpr std::size_t kNpyPreamble = 12;

/// The length of preamble and text together, from the first kNpyPreamble bytes.
/// `where` names the field in messages. Throws InputError.
std::size_t npy_header_size(std::string_view preamble, const std::string& where);

/// Reads preamble and text: little-endian real numbers only. Throws InputError with what was found.
NpyHeader parse_npy_header(std::string_view header, const std::string& where);

/// Converts numbers of the type to doubles. `bytes` holds a whole number of them.
void npy_to_double(NpyType type, std::string_view bytes, double* values);

}  // namespace chasles
