#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

// Names come from folders and recordings, whose bytes may be anything. What is written is UTF-8.
namespace chasles {

/// The text with U+FFFD in place of each byte that is no part of a character of UTF-8 (RFC 3629).
std::string valid_utf8(std::string_view text);

/// Json as text, strings as by valid_utf8(). `indent`: blanks a level; -1: all in one line.
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace chasles
