#include <bzlib.h>
#include <zlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include <lz4frame.h>

#include <chasles/bags/unpackers.hpp>

namespace chasles {
namespace {

constexpr const char* kDamaged = "it is damaged";

class Bz2Unpacker : public Unpacker {
 public:
  Bz2Unpacker() { BZ2_bzDecompressInit(&stream_, 0, 0); }
  ~Bz2Unpacker() override { BZ2_bzDecompressEnd(&stream_); }
  Bz2Unpacker(const Bz2Unpacker&) = delete;
  Bz2Unpacker& operator=(const Bz2Unpacker&) = delete;
  UnpackStep step(std::string_view in, char* out, std::size_t space) override {
    // The library's input is not const, and is not written to. A chunk has less than 4 GB.
    stream_.next_in = const_cast<char*>(in.data());
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = out;
    stream_.avail_out = static_cast<unsigned>(space);
    const int result = BZ2_bzDecompress(&stream_);
    return {.taken = in.size() - stream_.avail_in,
            .made = space - stream_.avail_out,
            .ended = result == BZ_STREAM_END,
            .failure = result != BZ_OK && result != BZ_STREAM_END ? kDamaged : nullptr};
  }

 private:
  bz_stream stream_{};
};

class GzipUnpacker : public Unpacker {
 public:
  GzipUnpacker() { inflateInit2(&stream_, MAX_WBITS + 16); }
  ~GzipUnpacker() override { inflateEnd(&stream_); }
  GzipUnpacker(const GzipUnpacker&) = delete;
  GzipUnpacker& operator=(const GzipUnpacker&) = delete;
  UnpackStep step(std::string_view in, char* out, std::size_t space) override {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(in.data()));
    stream_.avail_in = static_cast<unsigned>(in.size());
    stream_.next_out = reinterpret_cast<Bytef*>(out);
    stream_.avail_out = static_cast<unsigned>(space);
    const int result = inflate(&stream_, Z_NO_FLUSH);
    // Z_BUF_ERROR: it needs more bytes.
    const bool good = result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR;
    return {.taken = in.size() - stream_.avail_in,
            .made = space - stream_.avail_out,
            .ended = result == Z_STREAM_END,
            .failure = good ? nullptr : kDamaged};
  }

 private:
  z_stream stream_{};
};

class Lz4Unpacker : public Unpacker {
 public:
  Lz4Unpacker() { LZ4F_createDecompressionContext(&context_, LZ4F_VERSION); }
  ~Lz4Unpacker() override { LZ4F_freeDecompressionContext(context_); }
  Lz4Unpacker(const Lz4Unpacker&) = delete;
  Lz4Unpacker& operator=(const Lz4Unpacker&) = delete;
  UnpackStep step(std::string_view in, char* out, std::size_t space) override {
    UnpackStep step{.taken = in.size(), .made = space};
    const std::size_t result =
        LZ4F_decompress(context_, out, &step.made, in.data(), &step.taken, nullptr);
    if (LZ4F_isError(result) != 0) step.failure = kDamaged;
    step.ended = result == 0;
    return step;
  }

 private:
  LZ4F_dctx* context_ = nullptr;
};

class ZstdUnpacker : public Unpacker {
 public:
  ZstdUnpacker() : context_(ZSTD_createDCtx(), &ZSTD_freeDCtx) {}
  UnpackStep step(std::string_view in, char* out, std::size_t space) override {
    ZSTD_inBuffer from{.src = in.data(), .size = in.size(), .pos = 0};
    ZSTD_outBuffer to{.dst = out, .size = space, .pos = 0};
    const std::size_t result = ZSTD_decompressStream(context_.get(), &to, &from);
    return {.taken = from.pos, .made = to.pos, .ended = result == 0, .failure = failure(result)};
  }

 private:
  static const char* failure(std::size_t result) {
    if (ZSTD_isError(result) == 0) return nullptr;
    return ZSTD_getErrorCode(result) == ZSTD_error_frameParameter_windowTooLarge
               ? "it takes more than 128 MiB of memory: unpack it with `zstd -d --long=31`"
               : kDamaged;
  }

  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context_;
};

}  // namespace

std::unique_ptr<Unpacker> make_unpacker(std::string_view compression) {
  if (compression == "bz2") return std::make_unique<Bz2Unpacker>();
  if (compression == "lz4") return std::make_unique<Lz4Unpacker>();
  if (compression == "zstd") return std::make_unique<ZstdUnpacker>();
  if (compression == "gz") return std::make_unique<GzipUnpacker>();
  return nullptr;
}

}  // namespace chasles
