#include <algorithm>
#include <cstdint>
#include <memory>
#include <zip.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

constexpr std::size_t kGzipHeader = 10, kGzipTrailer = 8;

enum Flag : unsigned { kHeaderSum = 2, kExtra = 4, kName = 8, kComment = 16, kUnknown = 0xe0 };

// The parts of a gzip file.
struct Member {
  std::string_view deflated;
  std::uint32_t check_sum = 0;
  std::uint32_t size = 0;  // of the content
};

std::uint32_t number_at(std::string_view bytes, std::size_t i) {
  return byte_at(bytes, i) | byte_at(bytes, i + 1) << 8 | byte_at(bytes, i + 2) << 16 |
         byte_at(bytes, i + 3) << 24;
}

[[noreturn]] void fail_short(const std::string& where) {
  throw InputError(where + ": ends within its gzip header (is the file truncated?)");
}

// The bytes after the header's optional fields.
std::string_view after_header(std::string_view bytes, const std::string& where) {
  const unsigned flags = byte_at(bytes, 3);
  if (byte_at(bytes, 2) != 8 || (flags & kUnknown) != 0) {
    throw InputError(where + ": is a gzip file of an unknown kind, expected one of deflate");
  }
  std::string_view rest = bytes.substr(kGzipHeader);
  const auto skip = [&](std::size_t size) {
    if (rest.size() < size) fail_short(where);
    rest.remove_prefix(size);
  };
  if (flags & kExtra) {
    if (rest.size() < 2) fail_short(where);
    skip(2 + (byte_at(rest, 0) | byte_at(rest, 1) << 8));
  }
  for (const unsigned text : {kName, kComment}) {
    if (flags & text) skip(std::min(rest.find('\0'), rest.size()) + 1);
  }
  if (flags & kHeaderSum) skip(2);
  return rest;
}

Member parse_member(std::string_view bytes, const std::string& where) {
  if (bytes.size() < kGzipHeader + kGzipTrailer) fail_short(where);
  const std::string_view rest = after_header(bytes, where);
  if (rest.size() < kGzipTrailer) fail_short(where);
  const std::size_t end = rest.size() - kGzipTrailer;
  Member member{.deflated = rest.substr(0, end),
                .check_sum = number_at(rest, end),
                .size = number_at(rest, end + 4)};
  const std::string claim =
      fmt::format("{}: claims {} bytes from {} compressed ones", where, member.size, end);
  if (member.size / kMostInflation > end) {
    throw InputError(claim + ": the file is damaged or truncated");
  }
  check_memory(claim, member.size);
  return member;
}

void append_number(std::string& bytes, std::size_t value, int size) {
  for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
}

// The fields that the two headers of a zip entry share, from the version to the length of the name.
std::string entry_fields(const Member& member) {
  std::string bytes;
  append_number(bytes, 20, 2);  // version that can extract it
  append_number(bytes, 0, 2);   // flags
  append_number(bytes, 8, 2);   // deflate
  append_number(bytes, 0, 2);   // time
  append_number(bytes, 33, 2);  // 1980-01-01
  append_number(bytes, member.check_sum, 4);
  append_number(bytes, member.deflated.size(), 4);
  append_number(bytes, member.size, 4);
  append_number(bytes, 1, 2);  // length of the name
  append_number(bytes, 0, 2);  // length of extra fields
  return bytes;
}

// The same deflated bytes as a zip archive of one entry. libzip, which the .npz files need anyway,
// then decompresses and checks them.
std::string as_zip(const Member& member) {
  const std::string fields = entry_fields(member);
  std::string bytes = "PK\x03\x04" + fields + "x";
  bytes.append(member.deflated);
  const std::size_t directory = bytes.size();
  bytes += "PK\x01\x02";
  append_number(bytes, 20, 2);  // version that made it
  bytes += fields;
  bytes.append(14, '\0');  // comment, disk, attributes, offset of the entry
  bytes += "x";
  const std::size_t size = bytes.size() - directory;
  bytes += "PK\x05\x06";
  append_number(bytes, 0, 4);  // disks
  append_number(bytes, 1, 2);
  append_number(bytes, 1, 2);
  append_number(bytes, size, 4);
  append_number(bytes, directory, 4);
  append_number(bytes, 0, 2);
  return bytes;
}

using Archive = std::unique_ptr<zip_t, decltype(&zip_discard)>;
using Entry = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

Archive open_bytes(const std::string& bytes, const std::string& where) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  zip_t* archive = source ? zip_open_from_source(source, ZIP_RDONLY, &error) : nullptr;
  if (archive == nullptr) {
    const std::string reason = zip_error_strerror(&error);
    if (source) zip_source_free(source);
    zip_error_fini(&error);
    throw InputError(fmt::format("{}: cannot be decompressed: {}", where, reason));
  }
  zip_error_fini(&error);
  return {archive, &zip_discard};
}

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzip(std::string_view bytes, const std::string& where) {
  if (!is_gzip(bytes)) throw InputError(where + ": is no gzip file");
  const Member member = parse_member(bytes, where);
  const std::string zipped = as_zip(member);
  const Archive archive = open_bytes(zipped, where);
  const Entry entry(zip_fopen_index(archive.get(), 0, 0), &zip_fclose);
  // One byte more than expected: libzip compares the check sum at the end.
  std::string content(std::size_t{member.size} + 1, '\0');
  std::size_t done = 0;
  for (zip_int64_t got = 1; entry && done < content.size() && got > 0;) {
    got = zip_fread(entry.get(), content.data() + done, content.size() - done);
    if (got < 0) done = content.size();
    if (got > 0) done += static_cast<std::size_t>(got);
  }
  if (!entry || done != member.size) {
    throw InputError(where +
                     ": its compressed content does not match its check sum or length (is the "
                     "file damaged, truncated, or of several members?)");
  }
  content.resize(done);
  return content;
}

std::string read_plain_or_gzip(const std::filesystem::path& file) {
  std::string bytes = read_file(file);
  return is_gzip(bytes) ? gunzip(bytes, file.string()) : bytes;
}

}  // namespace chasles
