#pragma once

#include <filesystem>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/lie/se3.hpp>

namespace YAML {
class Node;
}

namespace chasles {

/// The text of a YAML file, with OpenCV's first line as a comment. Throws InputError as
/// read_text(), and for a file whose nodes would
/// take more memory than the budget (read_budget.hpp).
std::string read_yaml_file(const std::filesystem::path& file);

/// The keys of a YAML map and their checked values. All functions throw InputError with file, line
/// and key, the value found and the value expected.
class YamlMap {
 public:
  /// The keys that a map may have and must have. An empty `known` allows any key.
  struct Keys {
    std::vector<std::string> known;
    std::vector<std::string> needed;
  };

  static YamlMap read(const std::filesystem::path& file, const Keys& keys);

  bool has(const std::string& key) const;
  /// Throws unless the key is there.
  void need(const std::string& key) const;
  /// "FILE:LINE: key 'NAME'"; without the line where the key is missing.
  std::string where(const std::string& key) const;

  std::string text(const std::string& key) const;
  /// true or false; `meaning` is what true means, for the message.
  bool flag(const std::string& key, const std::string& meaning) const;
  double number(const std::string& key) const;  ///< finite
  double positive(const std::string& key) const;
  double not_negative(const std::string& key) const;
  /// A list of `size` finite numbers, or a map with such a list as `data`; `what` names them in
  /// messages.
  Eigen::VectorXd numbers(const std::string& key, std::size_t size, const std::string& what) const;
  /// A matrix of finite numbers: a list of rows, a list of all numbers row by row, or a map with
  /// such a list as `data` and its sizes as `rows` and `cols` (OpenCV's !!opencv-matrix, EuRoC's
  /// T_BS).
  Eigen::MatrixXd matrix(const std::string& key, std::size_t rows, std::size_t cols) const;
  /// A rigid motion as a matrix of four rows of four numbers.
  SE3 motion(const std::string& key) const;
  /// The length of that list.
  std::size_t count(const std::string& key) const;
  /// A list of texts; empty where the key is missing.
  std::vector<std::string> texts(const std::string& key) const;
  /// The same, or one text.
  std::vector<std::string> texts_or_text(const std::string& key) const;
  /// A nested map.
  YamlMap map(const std::string& key, const Keys& keys) const;
  /// A list of maps.
  std::vector<YamlMap> maps(const std::string& key, const Keys& keys) const;

 private:
  YamlMap(std::string file, std::string begin, const YAML::Node& node, const Keys& keys);
  YamlMap below(const YAML::Node& node, const Keys& keys) const;
  YAML::Node at(const std::string& key) const;
  std::string where(const YAML::Node& node, const std::string& key) const;
  std::string scalar(const YAML::Node& node, const std::string& key) const;
  double number(const YAML::Node& node, const std::string& key) const;
  YAML::Node list_at(const std::string& key) const;
  void check_keys(const Keys& keys) const;

  std::string file_;
  std::string begin_;  // "FILE", or "FILE:LINE" of a nested map
  std::shared_ptr<const YAML::Node> map_;
  std::set<std::string> found_;
  std::vector<std::string> named_;
};

}  // namespace chasles
