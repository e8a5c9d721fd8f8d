#include <nlohmann/json.hpp>

#include <chasles/live/viewer_message.hpp>

namespace chasles {
namespace {

constexpr std::size_t kLongestRun = 64;

/// Reads an optional entry; false if it has the wrong type or value.
template <typename Value, typename Is>
bool take(const nlohmann::json& json, const char* key, Value& value, const Is& is) {
  const auto found = json.find(key);
  if (found == json.end()) return true;
  if (!is(*found)) return false;
  value = found->get<Value>();
  return true;
}

std::optional<LiveCursor> cursor_of(const nlohmann::json& json) {
  const auto whole = [](const nlohmann::json& v) { return v.is_number_unsigned(); };
  const auto yes_or_no = [](const nlohmann::json& v) { return v.is_boolean(); };
  const auto name = [](const nlohmann::json& v) {
    return v.is_string() && v.get_ref<const std::string&>().size() <= kLongestRun;
  };
  LiveCursor cursor;
  const bool sound =
      json.is_object() && take(json, "run", cursor.run, name) &&
      take(json, "rows", cursor.rows, whole) && take(json, "landmarks", cursor.landmarks, whole) &&
      take(json, "truth", cursor.truth, yes_or_no) &&
      take(json, "map", cursor.prior_map, yes_or_no) && take(json, "all", cursor.all, yes_or_no);
  return sound ? std::optional(cursor) : std::nullopt;
}

}  // namespace

std::optional<ViewerMessage> parse_viewer_message(std::string_view text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object() || json.size() != 1) return std::nullopt;
  if (const auto join = json.find("join"); join != json.end()) {
    const std::optional<LiveCursor> cursor = cursor_of(*join);
    return cursor ? std::optional(ViewerMessage{.join = cursor}) : std::nullopt;
  }
  if (json.contains("stop") && json["stop"] == true) return ViewerMessage{.join = {}, .stop = true};
  return std::nullopt;
}

}  // namespace chasles
