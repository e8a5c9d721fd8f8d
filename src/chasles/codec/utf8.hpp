#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

// Names come from folders and recordings and may contain any bytes. All output is UTF-8.
namespace chasles {

/// The text with U+FFFD in place of each byte that is not part of a UTF-8 character (RFC 3629).
std::string valid_utf8(std::string_view text);

/// valid_utf8() with `\u001b` in place of control characters, which would command a terminal; line
/// ends and tabs stay. JSON stays the same JSON.
std::string printable(std::string_view text);

/// JSON as text, strings as by valid_utf8(). `indent`: blanks per level; -1: all in one line.
std::string json_text(const nlohmann::ordered_json& json, int indent = -1);

}  // namespace chasles
