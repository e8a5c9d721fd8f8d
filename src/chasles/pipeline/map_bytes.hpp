#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

#include <Eigen/Core>
#include <fmt/format.h>

#include <chasles/base/error.hpp>

// The bytes of a map's file (docs/formats.md, "Maps"). Included by map_file.cpp.
namespace chasles {

static_assert(std::endian::native == std::endian::little, "the file is little-endian");

/// Appends numbers as they are in memory.
class MapWriter {
 public:
  template <typename T>
  void put(T value) {
    static_assert(std::is_arithmetic_v<T> || std::is_same_v<T, Eigen::half>);
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }
  void put(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    bytes_.append(text);
  }
  template <typename Derived>
  void put_all(const Eigen::MatrixBase<Derived>& values) {  // row by row
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      for (Eigen::Index j = 0; j < values.cols(); ++j) put(values(i, j));
    }
  }
  void append(std::string_view bytes) { bytes_.append(bytes); }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads what MapWriter wrote, and throws InputError where that cannot be.
class MapReader {
 public:
  /// Of a part of the file that begins at byte `first`.
  MapReader(std::string_view bytes, std::size_t first, const std::string& name)
      : bytes_(bytes), first_(first), name_(name) {}

  template <typename T>
  T get() {
    need(sizeof(T));
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string get_text() {
    const auto size = get<std::uint32_t>();
    need(size);
    std::string text(bytes_.substr(at_, size));
    at_ += size;
    return text;
  }
  template <typename T>
  void get_all(T& values) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      for (Eigen::Index j = 0; j < values.cols(); ++j) values(i, j) = get<typename T::Scalar>();
    }
    check(values.allFinite(), "a number that is not finite");
  }
  // A count of things of at least so many bytes each.
  std::size_t get_count(std::size_t least) {
    const auto count = get<std::uint32_t>();
    need(count * least);
    return count;
  }
  void check(bool right, const char* found) const {
    if (!right) {
      throw InputError(
          fmt::format("{}: a damaged map: found {} near byte {}; make it again, or use "
                      "a copy",
                      name_, found, first_ + at_));
    }
  }
  void check_end() const { check(at_ == bytes_.size(), "bytes behind its end"); }

 private:
  void need(std::size_t size) const {
    check(size <= bytes_.size() - at_, "its end where more was expected");
  }

  std::string_view bytes_;
  std::size_t first_;
  const std::string& name_;
  std::size_t at_ = 0;
};

}  // namespace chasles
