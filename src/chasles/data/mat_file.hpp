#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <chasles/data/numbers.hpp>

struct _mat_t;

namespace chasles {

/// A MATLAB .mat file with real numeric variables.
class MatFile {
 public:
  /// Throws InputError if the file is missing or no .mat file.
  explicit MatFile(const std::filesystem::path& file);

  const std::vector<std::string>& fields() const { return fields_; }
  bool has(const std::string& field) const;

  /// "FILE: field 'NAME'".
  std::string where(const std::string& field) const;

  /// A variable of at most ten million numbers, last index fastest. Throws InputError, for a
  /// missing one with those that are present and the one most like it.
  NumberArray read(const std::string& field) const;

  /// Gives a variable's shape (which may be refused by throwing) and then its numbers in the order
  /// of the file, first index fastest.
  void visit(const std::string& field,
             const std::function<void(const std::vector<std::size_t>&)>& begin,
             const std::function<void(std::span<const double>)>& values) const;

 private:
  std::filesystem::path file_;
  std::unique_ptr<_mat_t, void (*)(_mat_t*)> mat_;
  std::vector<std::string> fields_;
};

}  // namespace chasles
