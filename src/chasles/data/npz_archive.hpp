#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <chasles/data/npy.hpp>
#include <chasles/data/numbers.hpp>

struct zip;

namespace chasles {

/// A numpy .npz file: a zip archive of .npy arrays. Nothing in it is believed: sizes are held
/// against the file's own size before memory is taken, and every entry is read to its check sum.
class NpzArchive {
 public:
  /// Throws InputError if the file is missing, no zip archive, or truncated.
  explicit NpzArchive(const std::filesystem::path& file);
  ~NpzArchive();
  NpzArchive(const NpzArchive&) = delete;
  NpzArchive& operator=(const NpzArchive&) = delete;

  const std::vector<std::string>& fields() const { return fields_; }
  bool has(const std::string& field) const;

  /// "FILE: field 'NAME'".
  std::string where(const std::string& field) const;

  /// A field of at most ten million numbers. Throws InputError, for a missing field with those
  /// that are present and the one most like it.
  NumberArray read(const std::string& field) const;

  /// Gives the numbers of a field piece by piece in the order of the file, never all at once:
  /// first the header (which may refuse by throwing), then the values.
  void stream(const std::string& field, const std::function<void(const NpyHeader&)>& begin,
              const std::function<void(std::span<const double>)>& values) const;

 private:
  std::filesystem::path file_;
  std::unique_ptr<zip, void (*)(zip*)> archive_;
  std::vector<std::string> fields_;
};

}  // namespace chasles
