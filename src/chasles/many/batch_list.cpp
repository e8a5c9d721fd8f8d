#include <algorithm>
#include <charconv>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/many/batch_list.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kFields = "recording, name, source, truth, cameras, start, stop or set";

std::string text_of(const Json& value, const std::string& where, const std::string& field) {
  if (value.is_string() && !value.get<std::string>().empty()) return value.get<std::string>();
  throw InputError(fmt::format("{}: {}: found {}, expected a text", where, field, value.dump()));
}

double seconds_of(const Json& value, const std::string& where, const std::string& field) {
  if (value.is_number() && value.get<double>() >= 0) return value.get<double>();
  throw InputError(
      fmt::format("{}: {}: found {}, expected seconds from 0 on", where, field, value.dump()));
}

std::vector<std::string> sets_of(const Json& value, const std::string& where) {
  if (!value.is_object()) {
    throw InputError(
        fmt::format("{}: set: found {}, expected an object of settings", where, value.dump()));
  }
  std::vector<std::string> sets;
  for (const auto& [key, setting] : value.items()) {
    sets.push_back(key + "=" + (setting.is_string() ? setting.get<std::string>() : setting.dump()));
  }
  return sets;
}

std::string trimmed(const std::string& line) {
  constexpr const char* kBlanks = " \t\r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string::npos) return "";
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

BatchItem item_from(const std::string& line, const fs::path& folder, const std::string& where) {
  if (line.front() != '{') return {.recording = folder / line};
  const Json object = Json::parse(line, nullptr, false);
  if (!object.is_object()) {
    throw InputError(fmt::format("{}: found '{}', expected a path or a JSON object", where, line));
  }
  BatchItem item;
  for (const auto& [field, value] : object.items()) {
    if (field == "recording") {
      item.recording = folder / text_of(value, where, field);
    } else if (field == "name") {
      item.name = text_of(value, where, field);
    } else if (field == "source") {
      item.source = text_of(value, where, field);
    } else if (field == "truth") {
      item.truth = folder / text_of(value, where, field);
    } else if (field == "cameras") {
      item.cameras = text_of(value, where, field);
    } else if (field == "start") {
      item.start = seconds_of(value, where, field);
    } else if (field == "stop") {
      item.stop = seconds_of(value, where, field);
    } else if (field == "set") {
      item.sets = sets_of(value, where);
    } else {
      throw InputError(fmt::format("{}: unknown field '{}', expected {}", where, field, kFields));
    }
  }
  if (item.recording.empty()) {
    throw InputError(fmt::format("{}: found no field 'recording', expected a path", where));
  }
  return item;
}

// The parts of a path, the last one first and without the extension of a file: "walk", "monday".
std::vector<std::string> parts_of(const fs::path& recording) {
  fs::path path = fs::absolute(recording).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  if (!fs::is_directory(path)) path.replace_extension();
  std::vector<std::string> parts;
  for (; path.has_filename(); path = path.parent_path()) parts.push_back(path.filename().string());
  return parts;
}

std::string name_from(const std::vector<std::string>& parts, std::size_t count) {
  std::string name;
  for (std::size_t i = std::min(count, parts.size()); i-- > 0;) {
    name += parts[i];
    if (i > 0) name += "_";
  }
  return name;
}

// Without a name of its own a recording may be there once.
void reject_repeated(const std::vector<BatchItem>& items) {
  std::set<fs::path> seen;
  for (const BatchItem& item : items) {
    if (!item.name.empty()) continue;
    if (!seen.insert(fs::absolute(item.recording).lexically_normal()).second) {
      throw UsageError(
          fmt::format("{}: found twice; expected each recording once, or names in the "
                      "list of --manifest",
                      item.recording.string()));
    }
  }
}

// Files beside the folder have longer names.
constexpr std::size_t kLongestName = 200;

void check_name(const BatchItem& item) {
  const std::string& name = item.name;
  const bool is_printable = std::ranges::none_of(
      name, [](char c) { return c == '/' || (c >= 0 && c < ' ') || c == '\x7f'; });
  if (!name.empty() && name != "." && name != ".." && is_printable && name.size() <= kLongestName) {
    return;
  }
  throw UsageError(
      fmt::format("{}: found the name '{}', expected at most {} bytes without a "
                  "slash and control characters; the list of --manifest gives names",
                  item.recording.string(), name, kLongestName));
}

}  // namespace

std::string BatchItem::said_source() const {
  if (!source.empty()) return valid_utf8(source);
  return valid_utf8(fs::absolute(recording).lexically_normal().string());
}

Json BatchItem::options_json() const {
  Json options = Json::object();
  if (!truth.empty()) options["truth"] = valid_utf8(truth.string());
  if (!cameras.empty()) options["cameras"] = cameras;
  if (start) options["start"] = *start;
  if (stop) options["stop"] = *stop;
  if (!sets.empty()) options["set"] = sets;
  return options;
}

std::vector<BatchItem> read_batch_list(const fs::path& file) {
  std::istringstream lines(read_text(file));
  std::vector<BatchItem> items;
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    items.push_back(
        item_from(line, file.parent_path(), fmt::format("{}:{}", file.string(), number)));
  }
  if (items.empty()) {
    throw InputError(
        fmt::format("{}: found no recording, expected a path on each line", file.string()));
  }
  return items;
}

void name_items(std::vector<BatchItem>& items) {
  reject_repeated(items);
  std::vector<std::vector<std::string>> parts;
  std::size_t deepest = 1;
  for (const BatchItem& item : items) {
    parts.push_back(parts_of(item.recording));
    deepest = std::max(deepest, parts.back().size());
  }
  std::vector<std::size_t> counts(items.size(), 1);
  const auto name = [&](std::size_t i) {
    return items[i].name.empty() ? name_from(parts[i], counts[i]) : items[i].name;
  };
  for (std::size_t round = 0; round < deepest; ++round) {
    std::map<std::string, std::size_t> users;
    for (std::size_t i = 0; i < items.size(); ++i) ++users[name(i)];
    for (std::size_t i = 0; i < items.size(); ++i) {
      if (users.at(name(i)) > 1) ++counts[i];
    }
  }
  std::map<std::string, std::size_t> used;
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].name = name(i);
    check_name(items[i]);
    if (const auto [other, is_new] = used.emplace(items[i].name, i); !is_new) {
      throw UsageError(fmt::format(
          "{} and {} have the same name '{}': expected each recording "
          "once, or names in the list of --manifest",
          items[other->second].recording.string(), items[i].recording.string(), items[i].name));
    }
  }
}

Shard shard_from(const std::string& text) {
  if (text.empty()) return {};
  Shard shard;
  const char* end = text.data() + text.size();
  const auto part = std::from_chars(text.data(), end, shard.part);
  const bool slash = part.ec == std::errc{} && part.ptr != end && *part.ptr == '/';
  const auto parts = slash ? std::from_chars(part.ptr + 1, end, shard.parts) : part;
  if (slash && parts.ec == std::errc{} && parts.ptr == end && shard.part >= 1 &&
      shard.part <= shard.parts) {
    return shard;
  }
  throw UsageError(fmt::format("--shard: found '{}', expected I/N with I from 1 to N", text));
}

}  // namespace chasles
