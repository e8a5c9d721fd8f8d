#include <algorithm>
#include <array>
#include <fstream>
#include <functional>
#include <memory>

#include <fmt/format.h>

#include <chasles/bags/file_bytes.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/bags/unpackers.hpp>
#include <chasles/base/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kPackedPiece = 1 << 17;  // [bytes]

/// Gives the content of a packed file piece by piece to `take`, which may return false: enough.
class PackedFile {
 public:
  using Take = std::function<bool(std::string_view)>;

  explicit PackedFile(const fs::path& file)
      : name_(file.string()), compression_(packed_as_file(file)), stream_(file, std::ios::binary) {
    if (!stream_ || compression_.empty()) throw InputError(name_ + ": cannot be read");
  }

  void unpack(const Take& take) {
    std::string out(kPackedPiece, '\0');
    std::unique_ptr<Unpacker> unpacker;  // of the stream that is read; none between two
    bool full = false;                   // more may come without further bytes
    bool started = false;                // not at the first stream any more
    while (full || !rest_.empty() || read_piece()) {
      if (!unpacker && started && skip_padding()) continue;
      started = true;
      if (!unpacker) unpacker = make_unpacker(compression_);
      const UnpackStep step = unpacker->step(rest_, out.data(), out.size());
      if (step.failure != nullptr) fail(step.failure);
      rest_.remove_prefix(step.taken);
      if (step.made > 0 && !take(std::string_view(out).substr(0, step.made))) return;
      full = !step.ended && step.made == out.size();
      if (step.ended) unpacker.reset();
      if (!step.ended && step.taken == 0 && step.made == 0 && !rest_.empty()) fail("it is damaged");
    }
    if (unpacker) fail("it is truncated (a copy that broke off?)");
  }

 private:
  // Whether zeros stand behind the last stream, as tapes and copies in blocks add them: they are
  // skipped, and must reach to the end of the file.
  bool skip_padding() {
    const std::size_t zeros = std::min(rest_.find_first_not_of('\0'), rest_.size());
    padded_ = padded_ || zeros > 0;
    rest_.remove_prefix(zeros);
    if (padded_ && !rest_.empty()) fail("further bytes come after zeros, so it is damaged");
    return padded_;
  }
  bool read_piece() {
    piece_.resize(kPackedPiece);
    stream_.read(piece_.data(), static_cast<std::streamsize>(piece_.size()));
    piece_.resize(static_cast<std::size_t>(stream_.gcount()));
    rest_ = piece_;
    return !rest_.empty();
  }
  [[noreturn]] void fail(const char* how) const {
    throw InputError(fmt::format("{}: is compressed as a whole ({}) and cannot be unpacked: {}",
                                 name_, compression_, how));
  }

  std::string name_;
  std::string_view compression_;
  std::ifstream stream_;
  std::string piece_;
  std::string_view rest_;
  bool padded_ = false;
};

}  // namespace

std::string_view packed_as(std::string_view bytes) {
  if (bytes.starts_with("\x28\xb5\x2f\xfd")) return "zstd";
  // A frame that pzstd writes before the first one.
  if (bytes.size() > 4 && (bytes[0] & '\xf0') == '\x50' && bytes.substr(1, 3) == "\x2a\x4d\x18") {
    return "zstd";
  }
  if (bytes.starts_with("\x1f\x8b")) return "gz";
  if (bytes.starts_with("BZh")) return "bz2";
  if (bytes.starts_with("\x04\x22\x4d\x18")) return "lz4";
  return {};
}

std::string_view packed_as_file(const fs::path& file) {
  std::array<char, 8> begin{};
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), begin.size());
  return packed_as({begin.data(), static_cast<std::size_t>(stream.gcount())});
}

fs::path unpacked_name(const fs::path& file) {
  constexpr std::array kEndings{".zstd", ".zst", ".gz", ".bz2", ".lz4"};
  const std::string ending = file.extension().string();
  const bool packed = std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
  return packed ? file.parent_path() / file.stem() : file;
}

std::string first_unpacked(const fs::path& file, std::size_t count) {
  std::string content;
  try {
    PackedFile(file).unpack([&](std::string_view bytes) {
      content.append(bytes.substr(0, count - content.size()));
      return content.size() < count;
    });
  } catch (const InputError&) {
  }
  return content;
}

TemporaryFile unpack_file(const fs::path& file) {
  TemporaryFile content(file.string());
  const std::uint64_t most = most_unpacked(fs::file_size(file));
  std::uint64_t size = 0;
  PackedFile(file).unpack([&](std::string_view bytes) {
    size += bytes.size();
    if (size > most) {
      throw InputError(fmt::format(
          "{}: {} bytes and more come out of it, expected at most {}: it is damaged; if it is "
          "right, unpack it first",
          file.string(), size, most));
    }
    content.write(bytes);
    return true;
  });
  return content;
}

}  // namespace chasles
