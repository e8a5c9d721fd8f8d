#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <chasles/codec/numbers.hpp>

struct _mat_t;

namespace chasles {

/// A MATLAB .mat file with real numeric variables.
class MatFile {
 public:
  /// Throws InputError if the file is missing or not a .mat file.
  explicit MatFile(const std::filesystem::path& file);

  const std::vector<std::string>& fields() const { return fields_; }
  bool has(const std::string& field) const;

  /// "FILE: field 'NAME'".
  std::string where(const std::string& field) const;

  /// A variable of at most ten million numbers, last index fastest. Throws InputError; for a
  /// missing variable it lists those present and the most similar name.
  NumberArray read(const std::string& field) const;

  /// Passes a variable's shape to `begin`, which may throw to reject it, and then its numbers to
  /// `values` in the order of the file, first index fastest.
  void visit(const std::string& field,
             const std::function<void(const std::vector<std::size_t>&)>& begin,
             const std::function<void(std::span<const double>)>& values) const;

 private:
  std::filesystem::path file_;
  std::unique_ptr<_mat_t, void (*)(_mat_t*)> mat_;
  std::vector<std::string> fields_;
};

}  // namespace chasles
