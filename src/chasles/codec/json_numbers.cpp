#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/json_numbers.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

std::string text_of(const nlohmann::ordered_json& value) {
  return value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

JsonFile::JsonFile(const std::filesystem::path& file)
    : file_(file.string()),
      json_(std::make_shared<const nlohmann::ordered_json>(
          parse_json_object(read_text(file), file.string()))) {}

bool JsonPlace::has(const std::string& key) const {
  return value_->is_object() && value_->contains(key) && !value_->at(key).is_null();
}

bool JsonPlace::is_list() const { return value_->is_array(); }

std::size_t JsonPlace::size() const { return value_->is_array() ? value_->size() : 0; }

JsonPlace JsonPlace::at(const std::string& key) const {
  if (!has(key)) throw InputError(fmt::format("{} '{}' is missing", where_, key));
  return {fmt::format("{}{}{}", where_, where_.ends_with(':') ? " " : ".", key), value_->at(key)};
}

JsonPlace JsonPlace::at(std::size_t index) const {
  if (index < size()) return {fmt::format("{}[{}]", where_, index), value_->at(index)};
  throw InputError(
      fmt::format("{}: is a list of {} values, expected at least {}", where_, size(), index + 1));
}

double JsonPlace::value() const {
  if (value_->is_number() && std::isfinite(value_->get<double>())) return value_->get<double>();
  throw InputError(
      fmt::format("{}: found '{:.40}', expected a finite number", where_, text_of(*value_)));
}

std::string JsonPlace::text(const std::string& key) const {
  const JsonPlace place = at(key);
  if (place.value_->is_string()) return place.value_->get<std::string>();
  throw InputError(
      fmt::format("{}: found '{:.40}', expected a text", place.where_, text_of(*place.value_)));
}

}  // namespace chasles
