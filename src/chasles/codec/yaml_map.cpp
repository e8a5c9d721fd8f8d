#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/read_budget.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {
namespace {

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// OpenCV's first line, %YAML:1.0, is no directive of YAML.
std::string without_header(std::string text) {
  if (text.starts_with("%YAML:")) text.front() = '#';
  return text;
}

std::string key_of(const YAML::Node& node) { return node.IsScalar() ? node.Scalar() : ""; }

}  // namespace

std::string read_yaml_file(const std::filesystem::path& file) {
  constexpr std::size_t kBytesOfText = 200;  // of yaml-cpp's nodes, for a byte of the file
  std::string text = read_text(file);
  check_memory(fmt::format("{}: has {} bytes of YAML", file.string(), text.size()),
               text.size() * kBytesOfText);
  return without_header(std::move(text));
}

YamlMap YamlMap::read(const std::filesystem::path& file, const Keys& keys) {
  const std::string name = file.string();
  YAML::Node root;
  try {
    root = YAML::Load(read_yaml_file(file));
  } catch (const YAML::Exception& error) {
    throw InputError(
        fmt::format("{}:{}: is not valid YAML: {}", name, error.mark.line + 1, error.msg));
  }
  if (!root.IsMap()) throw InputError(name + ": expected lines `key: value`");
  return {name, name, root, keys};
}

YamlMap::YamlMap(std::string file, std::string begin, const YAML::Node& node, const Keys& keys)
    : file_(std::move(file)),
      begin_(std::move(begin)),
      map_(std::make_shared<const YAML::Node>(node)),
      named_(keys.known) {
  for (const auto& entry : *map_) {
    const std::string key = key_of(entry.first);
    if (!found_.insert(key).second) {
      throw InputError(where(entry.first, key) + ": is there twice, expected once");
    }
  }
  check_keys(keys);
}

void YamlMap::check_keys(const Keys& keys) const {
  for (const auto& entry : *map_) {
    const std::string key = key_of(entry.first);
    if (keys.known.empty() || contains(keys.known, key)) continue;
    throw InputError(fmt::format("{}: is unknown, expected one of {}{}", where(entry.first, key),
                                 quoted_list(keys.known), did_you_mean(key, keys.known)));
  }
  for (const std::string& key : keys.needed) need(key);
}

bool YamlMap::has(const std::string& key) const { return found_.contains(key); }

void YamlMap::need(const std::string& key) const {
  if (has(key)) return;
  throw InputError(fmt::format("{}: key '{}' is missing, expected {}", begin_, key,
                               quoted_list(named_.empty() ? std::vector{key} : named_)));
}

YAML::Node YamlMap::at(const std::string& key) const {
  need(key);
  return (*map_)[key];
}

std::string YamlMap::where(const YAML::Node& node, const std::string& key) const {
  return fmt::format("{}:{}: key '{}'", file_, node.Mark().line + 1, key);
}

std::string YamlMap::where(const std::string& key) const {
  return has(key) ? where(at(key), key) : fmt::format("{}: key '{}'", file_, key);
}

std::string YamlMap::scalar(const YAML::Node& node, const std::string& key) const {
  if (!node.IsScalar()) throw InputError(where(node, key) + ": expected a single value");
  return node.Scalar();
}

double YamlMap::number(const YAML::Node& node, const std::string& key) const {
  return parse_finite(where(node, key), scalar(node, key));
}

std::string YamlMap::text(const std::string& key) const { return scalar(at(key), key); }

bool YamlMap::flag(const std::string& key, const std::string& meaning) const {
  const std::string value = text(key);
  if (value == "true" || value == "false") return value == "true";
  throw InputError(
      fmt::format("{}: is '{}', expected true ({}) or false", where(key), value, meaning));
}

double YamlMap::number(const std::string& key) const { return number(at(key), key); }

double YamlMap::positive(const std::string& key) const {
  return checked_positive(where(key), number(key));
}

double YamlMap::not_negative(const std::string& key) const {
  const double value = number(key);
  if (value >= 0) return value;
  throw InputError(
      fmt::format("{}: is {}, expected a number that is not negative", where(key), value));
}

// The list itself, or that of `data` in a map.
YAML::Node YamlMap::list_at(const std::string& key) const {
  const YAML::Node node = at(key);
  if (!node.IsMap()) return node;
  const YAML::Node data = node["data"];
  if (data) return data;
  throw InputError(where(node, key) + ": expected a list, or a matrix with rows, cols and data");
}

std::size_t YamlMap::count(const std::string& key) const {
  const YAML::Node list = list_at(key);
  return list.IsSequence() ? list.size() : 0;
}

Eigen::VectorXd YamlMap::numbers(const std::string& key, std::size_t size,
                                 const std::string& what) const {
  const YAML::Node list = list_at(key);
  if (!list.IsSequence() || list.size() != size) {
    throw InputError(fmt::format("{}: expected a list of {} {}", where(list, key), size, what));
  }
  Eigen::VectorXd values(static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i) {
    values(static_cast<Eigen::Index>(i)) = number(list[i], key);
  }
  return values;
}

Eigen::MatrixXd YamlMap::matrix(const std::string& key, std::size_t rows, std::size_t cols) const {
  const YAML::Node list = list_at(key);
  const bool flat = list.IsSequence() && list.size() == rows * cols && list[0].IsScalar();
  if (!flat && !(list.IsSequence() && list.size() == rows)) {
    throw InputError(
        fmt::format("{}: expected {} rows of {} numbers", where(list, key), rows, cols));
  }
  Eigen::MatrixXd M(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
  for (std::size_t i = 0; i < rows; ++i) {
    if (!flat && !(list[i].IsSequence() && list[i].size() == cols)) {
      throw InputError(fmt::format("{}: expected a row of {} numbers", where(list[i], key), cols));
    }
    for (std::size_t j = 0; j < cols; ++j) {
      M(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          number(flat ? list[i * cols + j] : list[i][j], key);
    }
  }
  return M;
}

SE3 YamlMap::motion(const std::string& key) const {
  return checked_motion(where(key), Eigen::Matrix4d(matrix(key, 4, 4)));
}

std::vector<std::string> YamlMap::texts(const std::string& key) const {
  std::vector<std::string> result;
  if (!has(key)) return result;
  const YAML::Node list = at(key);
  if (!list.IsSequence()) throw InputError(where(list, key) + ": expected a list of sentences");
  for (const auto& entry : list) result.push_back(scalar(entry, key));
  return result;
}

std::vector<std::string> YamlMap::texts_or_text(const std::string& key) const {
  if (at(key).IsSequence()) return texts(key);
  return {text(key)};
}

YamlMap YamlMap::below(const YAML::Node& node, const Keys& keys) const {
  return {file_, fmt::format("{}:{}", file_, node.Mark().line + 1), node, keys};
}

YamlMap YamlMap::map(const std::string& key, const Keys& keys) const {
  const YAML::Node node = at(key);
  if (!node.IsMap()) throw InputError(where(node, key) + ": expected lines `key: value`");
  return below(node, keys);
}

std::vector<YamlMap> YamlMap::maps(const std::string& key, const Keys& keys) const {
  const YAML::Node list = at(key);
  std::vector<YamlMap> result;
  if (!list.IsSequence() || list.size() == 0) {
    throw InputError(where(list, key) + ": expected a list, each entry with lines `key: value`");
  }
  for (const auto& entry : list) {
    if (!entry.IsMap()) throw InputError(where(entry, key) + ": expected lines `key: value`");
    result.push_back(below(entry, keys));
  }
  return result;
}

}  // namespace chasles
