#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <chasles/codec/npy.hpp>
#include <chasles/codec/numbers.hpp>

struct zip;

namespace chasles {

/// A numpy .npz file: a zip archive of .npy arrays. The reader trusts nothing in it: it checks
/// sizes against the file's own size before it allocates memory, and it verifies the check sum of
/// every entry.
class NpzArchive {
 public:
  /// Throws InputError if the file is missing, not a zip archive, or truncated.
  explicit NpzArchive(const std::filesystem::path& file);
  ~NpzArchive();
  NpzArchive(const NpzArchive&) = delete;
  NpzArchive& operator=(const NpzArchive&) = delete;

  const std::vector<std::string>& fields() const { return fields_; }
  bool has(const std::string& field) const;

  /// "FILE: field 'NAME'".
  std::string where(const std::string& field) const;

  /// A field of at most ten million numbers. Throws InputError; for a missing field it lists those
  /// present and the most similar name.
  NumberArray read(const std::string& field) const;

  /// Passes a field to the callbacks piece by piece in the order of the file, never all at once:
  /// first the header to `begin`, which may throw to reject it, then the values.
  void stream(const std::string& field, const std::function<void(const NpyHeader&)>& begin,
              const std::function<void(std::span<const double>)>& values) const;

 private:
  std::filesystem::path file_;
  std::unique_ptr<zip, void (*)(zip*)> archive_;
  std::vector<std::string> fields_;
};

}  // namespace chasles
