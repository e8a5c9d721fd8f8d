#include <algorithm>
#include <array>
#include <bzlib.h>
#include <memory>
#include <zstd.h>

#include <fmt/format.h>
#include <lz4frame.h>

#include <chasles/data/bags/decompress.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

/// The result of one call of a library: what it took and made, and whether the end is reached.
struct UnpackStep {
  std::size_t taken = 0, made = 0;
  bool ended = false, failed = false;
};

class Bz2Unpacker {
 public:
  Bz2Unpacker() { BZ2_bzDecompressInit(&stream_, 0, 0); }
  ~Bz2Unpacker() { BZ2_bzDecompressEnd(&stream_); }
  Bz2Unpacker(const Bz2Unpacker&) = delete;
  Bz2Unpacker& operator=(const Bz2Unpacker&) = delete;
  UnpackStep step(std::string_view in, char* out, std::size_t space) {
    // The library's input is not const, and is not written to. A chunk has less than 4 GB.
    stream_.next_in = const_cast<char*>(in.data());
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = out;
    stream_.avail_out = static_cast<unsigned>(space);
    const int result = BZ2_bzDecompress(&stream_);
    return {.taken = in.size() - stream_.avail_in,
            .made = space - stream_.avail_out,
            .ended = result == BZ_STREAM_END,
            .failed = result != BZ_OK && result != BZ_STREAM_END};
  }

 private:
  bz_stream stream_{};
};

class Lz4Unpacker {
 public:
  Lz4Unpacker() { LZ4F_createDecompressionContext(&context_, LZ4F_VERSION); }
  ~Lz4Unpacker() { LZ4F_freeDecompressionContext(context_); }
  Lz4Unpacker(const Lz4Unpacker&) = delete;
  Lz4Unpacker& operator=(const Lz4Unpacker&) = delete;
  UnpackStep step(std::string_view in, char* out, std::size_t space) {
    UnpackStep step{.taken = in.size(), .made = space};
    const std::size_t result =
        LZ4F_decompress(context_, out, &step.made, in.data(), &step.taken, nullptr);
    step.failed = LZ4F_isError(result) != 0;
    step.ended = result == 0;
    return step;
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class ZstdUnpacker {
 public:
  ZstdUnpacker() : context_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {}
  UnpackStep step(std::string_view in, char* out, std::size_t space) {
    ZSTD_inBuffer from{.src = in.data(), .size = in.size(), .pos = 0};
    ZSTD_outBuffer to{.dst = out, .size = space, .pos = 0};
    const std::size_t result = ZSTD_decompressStream(context_.get(), &to, &from);
    return {.taken = from.pos,
            .made = to.pos,
            .ended = result == 0,
            .failed = ZSTD_isError(result) != 0};
  }

 private:
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context_;
};

template <typename Unpacker>
std::string unpack(std::string_view packed, std::uint64_t most, const std::string& where) {
  constexpr std::size_t kStep = 1 << 16;
  Unpacker unpacker;
  std::string content;
  std::array<char, kStep> out;
  for (;;) {
    const UnpackStep step = unpacker.step(packed, out.data(), out.size());
    if (step.failed) throw InputError(where + ": cannot be decompressed: it is damaged");
    content.append(out.data(), step.made);
    packed.remove_prefix(step.taken);
    if (content.size() > most) {
      throw InputError(fmt::format("{}: decompresses to more than {} bytes, expected at most that",
                                   where, most));
    }
    if (step.ended) return content;
    if (step.taken == 0 && step.made == 0) {
      throw InputError(where + ": cannot be decompressed: it is truncated");
    }
  }
}

}  // namespace

bool is_known_compression(std::string_view compression) {
  constexpr std::array<std::string_view, 5> kKnown{"", "none", "bz2", "lz4", "zstd"};
  return std::find(kKnown.begin(), kKnown.end(), compression) != kKnown.end();
}

std::string decompress(std::string_view packed, std::string_view compression, std::uint64_t most,
                       const std::string& where) {
  if (compression == "bz2") return unpack<Bz2Unpacker>(packed, most, where);
  if (compression == "lz4") return unpack<Lz4Unpacker>(packed, most, where);
  if (compression == "zstd") return unpack<ZstdUnpacker>(packed, most, where);
  if (is_known_compression(compression)) return std::string(packed);
  throw InputError(fmt::format("{}: its compression is '{:.20}', expected none, bz2, lz4 or zstd",
                               where, compression));
}

}  // namespace chasles
