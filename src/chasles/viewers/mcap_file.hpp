#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// The schema of a channel's messages; `data` in the given encoding.
struct McapSchema {
  std::string name, encoding, data;
};

/// A stream of messages of one schema.
struct McapChannel {
  std::string topic, message_encoding;
  std::size_t schema = 0;  ///< index into McapFile::schemas
};

struct McapMessage {
  Time time{};
  std::size_t channel = 0;  ///< index into McapFile::channels
  std::string data;
};

/// An MCAP file in memory (mcap.dev/spec, version 0).
struct McapFile {
  std::string library;  ///< the writing program
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<McapMessage> messages;  ///< in any order
};

/// The file's bytes: messages in order of time (in the given order at equal times), in uncompressed
/// chunks, with CRC-32, message and chunk indices, and a complete summary, so that a reader finds
/// any time without reading the rest. Throws InputError for a time before 1970, which MCAP cannot
/// represent, and std::invalid_argument for an invalid index.
std::string mcap_bytes(const McapFile& file);

}  // namespace chasles
