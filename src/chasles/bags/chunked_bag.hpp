#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/file_bytes.hpp>

namespace chasles {

/// Shared by the formats whose messages are in chunks of the file. The messages of an uncompressed
/// chunk are read from the file; of the compressed chunks the last few stay in memory.
class ChunkedBag : public BagFile {
 public:
  ChunkedBag(const std::filesystem::path& file, const std::string& name) : file_(file, name) {}
  std::string read(const MessagePlace& place) const override;

 protected:
  /// The content of the chunk whose record begins at this offset.
  virtual std::string unpack_chunk(std::uint64_t at) const = 0;
  /// Decompresses and compares the size with the one that the file states. All chunks together may
  /// not exceed most_unpacked(): such a file is made to fill the machine.
  std::string unpack(std::string_view packed, std::string_view compression, std::uint64_t size,
                     std::uint64_t at) const;

  FileBytes file_;

 private:
  static constexpr std::size_t kKeptChunks = 4;
  mutable std::deque<std::pair<std::uint64_t, std::string>> chunks_;  // the latest last
  mutable std::uint64_t unpacked_ = 0;                                // during scans [bytes]
};

}  // namespace chasles
