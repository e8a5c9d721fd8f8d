#include "full_covariance.hpp"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/output_file.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles::app {
namespace {

constexpr double kGigabyte = 1e9;

// NumPy's format 1.0: magic, version, length of the text, text padded to 64 bytes.
std::string npy_header(std::uintmax_t count) {
  std::string text =
      fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", count);
  while ((10 + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 255);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

std::string row_names(const std::vector<std::string>& names,
                      const std::vector<RunLandmark>& landmarks) {
  std::string text = "row,of,component\n";
  int row = 0;
  const auto append = [&](const std::string& of, const std::string& component) {
    text += fmt::format("{},{},{}\n", row++, of, component);
  };
  for (const RunLandmark& l : landmarks) {
    for (const char* axis : {"x", "y", "z"}) append(fmt::format("{}", l.id), axis);
  }
  for (const char* part : {"rx", "ry", "rz", "x", "y", "z"}) append("pose", part);
  for (const std::string& name : names) append("additive", name);
  return text;
}

// `opened`: the file itself, or its part.
void check_room(const std::filesystem::path& opened, const std::filesystem::path& file,
                std::uintmax_t bytes) {
  std::error_code error;
  const auto space = std::filesystem::space(opened, error);
  if (error || !std::filesystem::is_regular_file(opened, error) || space.available >= bytes) return;
  throw UsageError(fmt::format("{}: the covariance takes {:.2f} GB, the disk has {:.2f} GB left",
                               file.string(), static_cast<double>(bytes) / kGigabyte,
                               static_cast<double>(space.available) / kGigabyte));
}

[[noreturn]] void reject(const std::filesystem::path& file) {
  throw UsageError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
}

std::ofstream opened(const std::filesystem::path& file) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  if (!stream) reject(file);
  return stream;
}

void write_triangle(const Ekf& filter, std::uintmax_t rows, std::ofstream& stream,
                    const std::filesystem::path& opened, const std::filesystem::path& file) {
  const std::uintmax_t count = rows * (rows + 1) / 2;
  check_room(opened, file, 8 * count + 128);
  const std::string header = npy_header(count);
  stream.write(header.data(), static_cast<std::streamsize>(header.size()));
  Eigen::VectorXd values;
  filter.visit_map_covariance([&](Eigen::Index first, const Eigen::MatrixXd& block) {
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
      const Eigen::Index width = first + i + 1;
      values = block.row(i).head(width);
      stream.write(
          reinterpret_cast<const char*>(values.data()),
          static_cast<std::streamsize>(width) * static_cast<std::streamsize>(sizeof(double)));
    }
    if (!stream) reject(file);
  });
  stream.close();
  if (!stream) reject(file);
}

}  // namespace

void check_full_covariance(const std::filesystem::path& file) {
  reject_pipe(file);
  const bool there = std::filesystem::exists(file);
  if (!std::ofstream(file, std::ios::binary | std::ios::app)) reject(file);
  if (!there) remove_file(file);
}

void write_full_covariance(const Ekf& filter, const std::vector<std::string>& additive_names,
                           const std::vector<RunLandmark>& landmarks,
                           const std::filesystem::path& file) {
  const auto rows =
      static_cast<std::uintmax_t>(3 * filter.map_size() + filter.core_covariance().rows());
  std::filesystem::path names = file;
  names.replace_extension(".csv");
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) {
    std::ofstream stream = opened(file);  // a device
    write_triangle(filter, rows, stream, file, file);
  } else {
    PartFile part(followed(file));
    std::ofstream stream = opened(part.path());
    write_triangle(filter, rows, stream, part.path(), file);
    sync_to_disk(part.path());
    part.move_over();
  }
  replace_file(names, row_names(additive_names, landmarks));
}

}  // namespace chasles::app
