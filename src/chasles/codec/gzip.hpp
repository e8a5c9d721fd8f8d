#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace chasles {

/// Whether the bytes start as a gzip file does.
bool is_gzip(std::string_view bytes);

/// The content of a gzip file of one member (RFC 1952), checked against its check sum and length.
/// Throws InputError, starting with `where`, for anything else or for more than a gigabyte.
std::string gunzip(std::string_view bytes, const std::string& where);

/// The bytes of a file, decompressed if it is a gzip file, whatever its name.
std::string read_plain_or_gzip(const std::filesystem::path& file);

}  // namespace chasles
