#include <algorithm>

#include <fmt/format.h>

#include <chasles/bags/chunked_bag.hpp>
#include <chasles/bags/decompress.hpp>

namespace chasles {

std::string ChunkedBag::read(const MessagePlace& place) const {
  if (place.chunk == MessagePlace::kNoChunk) return file_.read(place.at, place.size);
  auto kept = std::find_if(chunks_.begin(), chunks_.end(),
                           [&](const auto& chunk) { return chunk.first == place.chunk; });
  if (kept == chunks_.end()) {
    if (chunks_.size() == kKeptChunks) chunks_.pop_front();
    unpacked_ = 0;  // the limit is one for a scan
    kept = chunks_.emplace(chunks_.end(), place.chunk, unpack_chunk(place.chunk));
  }
  const std::string& content = kept->second;
  if (place.at > content.size() || place.size > content.size() - place.at) {
    file_.fail(place.chunk, "a message is no longer there (was the bag changed?)");
  }
  return content.substr(place.at, place.size);
}

std::string ChunkedBag::unpack(std::string_view packed, std::string_view compression,
                               std::uint64_t size, std::uint64_t at) const {
  const std::string where = fmt::format("{}: the chunk at byte {}", file_.name(), at);
  std::string content = decompress(packed, compression, std::min(size, largest_piece()), where);
  if (content.size() != size) {
    file_.fail(at, fmt::format("a chunk has {} bytes, expected {}", content.size(), size));
  }
  unpacked_ += content.size();
  if (unpacked_ > most_unpacked(file_.size())) {
    file_.fail(at, fmt::format("{} bytes were unpacked from {}", unpacked_, file_.size()));
  }
  return content;
}

}  // namespace chasles
