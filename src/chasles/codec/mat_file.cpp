#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/mat_file.hpp>
#include <chasles/codec/mat_structure.hpp>
#include <chasles/codec/matio_library.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

// MATLAB compresses with deflate. It also stores doubles as bytes if they fit, which saves another
// 8 : 1.
constexpr std::size_t kMostMatInflation = kMostInflation * 8;

using Variable = std::unique_ptr<matvar_t, decltype(MatioLibrary::free)>;

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

// Before the data are read, which of a cell or a sparse array may be anything.
void check_numeric(const matvar_t& variable, const std::string& where) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
    case MAT_C_SINGLE:
    case MAT_C_INT8:
    case MAT_C_INT16:
    case MAT_C_INT32:
    case MAT_C_UINT8:
    case MAT_C_UINT16:
    case MAT_C_UINT32:
      return;
    default:
      throw InputError(where + ": is not a numeric array, expected real numbers");
  }
}

template <typename T>
std::vector<double> converted(const matvar_t& variable, std::size_t count) {
  const T* data = static_cast<const T*>(variable.data);
  return {data, data + count};
}

// Of an array that check_numeric() accepts.
std::vector<double> to_doubles(const matvar_t& variable, std::size_t count) {
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
    default:
      return converted<mat_uint32_t>(variable, count);
  }
}

InputError not_a_mat_file(const std::filesystem::path& file) {
  return InputError(
      fmt::format("{}: cannot be opened as a MATLAB .mat file (version 5 or 7.3)", file.string()));
}

// libmatio reads a truncated version 5 file as complete, with zeros for the rest, so the arrays of
// the file are checked first.
void check_complete(const std::filesystem::path& file) {
  constexpr std::size_t kHeader = 128;
  const std::string bytes = read_file(file);
  if (bytes.size() < kHeader) throw not_a_mat_file(file);
  const bool big_endian = bytes[126] == 'M';
  // libmatio uses this number and not the text.
  const char version = bytes[big_endian ? 124 : 125];
  if (bytes.starts_with("MATLAB 7.3") && version == 2) return;  // HDF5, which has its own checks
  if (!bytes.starts_with("MATLAB 5.0") || version != 1) throw not_a_mat_file(file);
  check_mat_structure(bytes, big_endian, file.string());
}

mat_t* open_mat(const std::filesystem::path& file) {
  check_complete(file);
  if (mat_t* mat = matio().open(file.c_str(), MAT_ACC_RDONLY)) return mat;
  throw not_a_mat_file(file);
}

}  // namespace

MatFile::MatFile(const std::filesystem::path& file)
    : file_(file), mat_(open_mat(file), [](mat_t* mat) { matio().close(mat); }) {
  while (const Variable variable{matio().read_next_info(mat_.get()), matio().free}) {
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
  matio().rewind(mat_.get());
  const Variable variable(matio().read_info(mat_.get(), field.c_str()), matio().free);
  if (!variable || variable->rank < 1 || !variable->dims) {
    throw InputError(where(field) + ": cannot be read: the file is damaged");
  }
  if (variable->isComplex) throw InputError(where(field) + ": is complex, expected real numbers");
  check_numeric(*variable, where(field));
  check_shape(*variable, std::filesystem::file_size(file_), where(field));
  const std::vector<std::size_t> shape(variable->dims, variable->dims + variable->rank);
  begin(shape);
  std::size_t count = 1;
  for (const std::size_t size : shape) count *= size;
  if (count == 0) return;
  check_memory(fmt::format("{}: has {} numbers", where(field), count), count * sizeof(double));
  const int failed = matio().read_data(mat_.get(), variable.get());
  if (failed || !variable->data || variable->nbytes < count * variable->data_size) {
    throw InputError(where(field) + ": ends early or is damaged (is the file truncated?)");
  }
  if (variable->class_type == MAT_C_DOUBLE) {
    values({static_cast<const double*>(variable->data), count});
  } else {
    values(to_doubles(*variable, count));
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
