#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

// The recordings of a batch, and the part of them that one process runs.
namespace chasles {

/// One recording of a batch. What is not given here is that of the whole batch.
struct BatchItem {
  std::filesystem::path recording;
  std::string name = {};             ///< its folder in the batch; empty: by name_items()
  std::string source = {};           ///< what the record says of where it is from; empty: the path
  std::filesystem::path truth = {};  ///< empty: that of the recording, if any
  std::string cameras = {};          ///< as RecordingInput::cameras
  std::optional<double> start = {}, stop = {};  ///< [s]
  std::vector<std::string> sets = {};           ///< KEY=VALUE, after those of the batch

  /// Of the record: `source`, or the absolute path, as valid UTF-8.
  std::string said_source() const;
  /// What differs from the batch, of the record.
  nlohmann::ordered_json options_json() const;
};

/// Reads a list of recordings: a path on each line, or a JSON object with `recording` and, where
/// they differ from the batch, `name`, `source`, `truth`, `cameras`, `start`, `stop` [s] and `set`,
/// an object of settings. Empty lines and those that begin with # do not count. Relative paths
/// begin at the folder of the list. Throws InputError with file and line.
std::vector<BatchItem> read_batch_list(const std::filesystem::path& file);

/// Gives each item without a name the last part of its path, without the extension of a file. Items
/// that would have the same name get parts of their folders before it. Throws UsageError for an
/// item that is there twice, and for a name that no folder can have.
void name_items(std::vector<BatchItem>& items);

/// The i-th of n parts of a list: i, i + n, i + 2 n, ...
struct Shard {
  std::uint64_t part = 1, parts = 1;  ///< from 1 on

  bool is_whole() const { return parts == 1; }
  bool has(std::size_t index) const { return index % parts == part - 1; }
};

/// Of `I/N`; the whole of an empty text. Throws UsageError that names --shard.
Shard shard_from(const std::string& text);

}  // namespace chasles
