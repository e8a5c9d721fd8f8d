#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <chasles/time.hpp>

namespace chasles {

/// What the messages of a channel are made of; `data` as the encoding has it.
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
  std::string library;  ///< who wrote it
  std::vector<McapSchema> schemas;
  std::vector<McapChannel> channels;
  std::vector<McapMessage> messages;  ///< in any order
};

/// The file's bytes: messages in order of time (those of one time as they are given), in chunks
/// that are not compressed, with CRC-32, message and chunk indices, and a summary that is complete:
/// a reader finds any time without reading the rest. Throws InputError for a time before 1970,
/// which MCAP cannot write, and std::invalid_argument for an index that is none.
std::string mcap_bytes(const McapFile& file);

}  // namespace chasles
