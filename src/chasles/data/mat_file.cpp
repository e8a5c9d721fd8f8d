#include <algorithm>
#include <array>
#include <fstream>
#include <matio.h>
#include <string_view>

#include <fmt/format.h>

#include <chasles/data/bytes.hpp>
#include <chasles/data/mat_file.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

// MATLAB compresses with deflate. It also stores doubles as bytes if they fit, which saves another
// 8 : 1.
constexpr std::size_t kMostMatInflation = kMostInflation * 8;

using Variable = std::unique_ptr<matvar_t, decltype(&Mat_VarFree)>;

// Rejects, before memory is allocated, an array that a file of this size cannot hold.
void check_shape(const matvar_t& variable, std::size_t file_size, const std::string& where) {
  std::size_t bytes = sizeof(double);
  for (int axis = 0; axis < variable.rank; ++axis) {
    const std::size_t size = variable.dims[axis];
    if (size != 0 && bytes > file_size * kMostMatInflation / size) {
      throw InputError(fmt::format(
          "{}: claims more numbers than a file of {} bytes can hold: the file is damaged", where,
          file_size));
    }
    bytes *= size;
  }
}

template <typename T>
std::vector<double> converted(const matvar_t& variable, std::size_t count) {
  const T* data = static_cast<const T*>(variable.data);
  return {data, data + count};
}

std::vector<double> to_doubles(const matvar_t& variable, std::size_t count,
                               const std::string& where) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return converted<double>(variable, count);
    case MAT_C_SINGLE:
      return converted<float>(variable, count);
    case MAT_C_INT8:
      return converted<mat_int8_t>(variable, count);
    case MAT_C_INT16:
      return converted<mat_int16_t>(variable, count);
    case MAT_C_INT32:
      return converted<mat_int32_t>(variable, count);
    case MAT_C_UINT8:
      return converted<mat_uint8_t>(variable, count);
    case MAT_C_UINT16:
      return converted<mat_uint16_t>(variable, count);
    case MAT_C_UINT32:
      return converted<mat_uint32_t>(variable, count);
    default:
      throw InputError(where + ": is not a numeric array, expected real numbers");
  }
}

InputError not_a_mat_file(const std::filesystem::path& file) {
  return InputError(
      fmt::format("{}: cannot be opened as a MATLAB .mat file (version 5 or 7.3)", file.string()));
}

std::size_t number_at(const unsigned char* bytes, bool big_endian) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | bytes[big_endian ? i : 3 - i];
  return value;
}

// libmatio allocates memory for any size in an array's header: its flags (8 bytes), the sizes of
// two to 32 dimensions, and its name, in a tag of its own or, up to four bytes, within the tag.
// Cells and structs hold an element of at least a tag for each of their numbers. Compressed
// elements cannot be checked in this way.
bool is_plausible_array(std::istream& stream, std::size_t size, bool big_endian) {
  constexpr std::size_t kHead = 24, kTag = 8, kMostDimensions = 32, kLongestName = 256, kText = 1;
  if (size == 0) return true;
  std::array<unsigned char, kHead + 4 * kMostDimensions + kTag> head{};
  stream.read(reinterpret_cast<char*>(head.data()),
              static_cast<std::streamsize>(std::min(size, head.size())));
  const auto number = [&](std::size_t at) { return number_at(head.data() + at, big_endian); };
  const std::size_t sizes = number(20), padded = (sizes + 7) / 8 * 8;
  if (size < kHead || !stream || number(0) != 6 || number(4) != 8 || number(16) != 5) return false;
  if (sizes % 4 != 0 || sizes < 8 || sizes > 4 * kMostDimensions) return false;
  if (size < kHead + padded + kTag) return false;
  const std::size_t name = number(kHead + padded), length = number(kHead + padded + 4);
  const bool apart = name == kText && length <= std::min(kLongestName, size);
  const bool within = (name & 0xffff) == kText && name >> 16 >= 1 && name >> 16 <= 4;
  const std::size_t type = number(8) & 0xff;
  const bool container = type < 4 || type > 15;  // not text, sparse or numbers
  std::size_t held = kTag;
  for (std::size_t at = kHead; container && at < kHead + sizes; at += 4) {
    const std::size_t count = number(at);
    if (count != 0 && held > size / count) return false;
    held *= count;
  }
  return apart || within;
}

// libmatio reads a truncated version 5 file as complete, with zeros for the rest. So the elements
// of the file are checked first: after a header of 128 bytes each has a tag (type, size) and its
// bytes.
void check_complete(const std::filesystem::path& file) {
  constexpr std::size_t kHeader = 128, kTag = 8;
  std::ifstream stream(file, std::ios::binary);
  std::array<char, kHeader> header{};
  stream.read(header.data(), header.size());
  const std::size_t got = static_cast<std::size_t>(stream.gcount());
  const std::string_view text(header.data(), got);
  const bool big_endian = header[126] == 'M';
  // libmatio uses this number and not the text.
  const char version = header[big_endian ? 124 : 125];
  if (text.starts_with("MATLAB 7.3") && version == 2) return;  // HDF5, which has its own checks
  if (!text.starts_with("MATLAB 5.0") || version != 1) throw not_a_mat_file(file);
  const std::size_t file_size = std::filesystem::file_size(file);
  std::size_t position = kHeader;
  while (position + kTag <= file_size) {
    std::array<unsigned char, kTag> tag{};
    stream.seekg(static_cast<std::streamoff>(position));
    stream.read(reinterpret_cast<char*>(tag.data()), tag.size());
    const std::size_t type = number_at(tag.data(), big_endian);
    const std::size_t size = number_at(tag.data() + 4, big_endian);
    constexpr std::size_t kArray = 14;
    if (type == kArray && !is_plausible_array(stream, size, big_endian)) {
      throw InputError(fmt::format(
          "{}: the header of the array at byte {} is not one: the file is damaged, copy it again",
          file.string(), position));
    }
    position += kTag + size;
  }
  if (position == file_size) return;
  throw InputError(
      fmt::format("{}: ends within a variable: it has {} bytes, expected {} or more; "
                  "the file is truncated or damaged",
                  file.string(), file_size, position));
}

mat_t* open_mat(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    throw InputError(fmt::format("{}: no such file", file.string()));
  }
  check_complete(file);
  if (mat_t* mat = Mat_Open(file.c_str(), MAT_ACC_RDONLY)) return mat;
  throw not_a_mat_file(file);
}

}  // namespace

MatFile::MatFile(const std::filesystem::path& file)
    : file_(file), mat_(open_mat(file), [](mat_t* mat) { Mat_Close(mat); }) {
  while (const Variable variable{Mat_VarReadNextInfo(mat_.get()), &Mat_VarFree}) {
    if (variable->name) fields_.emplace_back(variable->name);
  }
}

bool MatFile::has(const std::string& field) const {
  return std::find(fields_.begin(), fields_.end(), field) != fields_.end();
}

std::string MatFile::where(const std::string& field) const {
  return fmt::format("{}: field '{}'", file_.string(), field);
}

void MatFile::visit(const std::string& field,
                    const std::function<void(const std::vector<std::size_t>&)>& begin,
                    const std::function<void(std::span<const double>)>& values) const {
  if (!has(field)) {
    throw InputError(
        fmt::format("{}: is missing (or the file is truncated before it); the file "
                    "holds {}{}",
                    where(field), quoted_list(fields_), did_you_mean(field, fields_)));
  }
  Mat_Rewind(mat_.get());
  const Variable variable(Mat_VarReadInfo(mat_.get(), field.c_str()), &Mat_VarFree);
  if (!variable || variable->rank < 1 || !variable->dims) {
    throw InputError(where(field) + ": cannot be read: the file is damaged");
  }
  if (variable->isComplex) throw InputError(where(field) + ": is complex, expected real numbers");
  check_shape(*variable, std::filesystem::file_size(file_), where(field));
  const std::vector<std::size_t> shape(variable->dims, variable->dims + variable->rank);
  begin(shape);
  std::size_t count = 1;
  for (const std::size_t size : shape) count *= size;
  if (count == 0) return;
  const int failed = Mat_VarReadDataAll(mat_.get(), variable.get());
  if (failed || !variable->data || variable->nbytes < count * variable->data_size) {
    throw InputError(where(field) + ": ends early or is damaged (is the file truncated?)");
  }
  if (variable->class_type == MAT_C_DOUBLE) {
    values({static_cast<const double*>(variable->data), count});
  } else {
    values(to_doubles(*variable, count, where(field)));
  }
}

NumberArray MatFile::read(const std::string& field) const {
  NumberArray array{.where = where(field), .shape = {}, .values = {}};
  visit(
      field,
      [&](const std::vector<std::size_t>& shape) {
        std::size_t count = 1;
        for (const std::size_t size : shape) count *= size;
        if (shape.size() > 2 || count > kLargestField) {
          throw InputError(fmt::format("{}: has shape {}, expected a matrix of at most {} numbers",
                                       where(field), shape_text(shape), kLargestField));
        }
        array.shape = shape;
      },
      [&](std::span<const double> values) { array.values.assign(values.begin(), values.end()); });
  if (array.values.empty()) return array;
  const std::size_t rows = array.shape[0];
  std::vector<double> row_major(array.values.size());
  const std::size_t cols = row_major.size() / rows;
  for (std::size_t i = 0; i < row_major.size(); ++i) {
    row_major[(i % rows) * cols + i / rows] = array.values[i];
  }
  array.values = std::move(row_major);
  return array;
}

}  // namespace chasles
