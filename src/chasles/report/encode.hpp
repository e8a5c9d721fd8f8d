#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace chasles {

/// Base64 of RFC 4648 with padding.
std::string base64(const std::vector<std::uint8_t>& bytes);

/// A column of the page: "f32:", "f64:" or "i32:" and the base64 of a zlib stream (RFC 1950). The
/// stream has the numbers' little-endian bytes in planes: the first bytes of all numbers, then the
/// second bytes, and so on. Neighbouring numbers differ least in their high bytes, and deflate
/// compresses equal bytes only if they are adjacent.
std::string float_column(const std::vector<double>& values);
std::string double_column(const std::vector<double>& values);
std::string int_column(const std::vector<int>& values);

/// JSON text for use inside <script>. It contains no <, > or &, so that no name can end the element
/// or start another. Invalid UTF-8 becomes U+FFFD.
std::string json_for_html(const nlohmann::ordered_json& json);

/// A page of page_template.hpp with this JSON inserted.
std::string with_data(std::string_view page, const nlohmann::ordered_json& data);

}  // namespace chasles
