#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace chasles {

/// A value of a JSON file and its place. All functions throw InputError with the file, the place
/// and what is expected there.
class JsonPlace {
 public:
  JsonPlace(std::string where, const nlohmann::ordered_json& value)
      : where_(std::move(where)), value_(&value) {}

  const std::string& where() const { return where_; }  ///< "FILE: value0.T_imu_cam[0]"
  bool has(const std::string& key) const;
  bool is_list() const;
  std::size_t size() const;  ///< of a list; 0 for other values
  JsonPlace at(const std::string& key) const;
  JsonPlace at(std::size_t index) const;
  double value() const;  ///< of a number, which is finite
  double number(const std::string& key) const { return at(key).value(); }
  double number(std::size_t index) const { return at(index).value(); }
  std::string text(const std::string& key) const;

 private:
  std::string where_;
  const nlohmann::ordered_json* value_;
};

/// A JSON file whose text is an object. Throws InputError as parse_json_object().
class JsonFile {
 public:
  explicit JsonFile(const std::filesystem::path& file);
  JsonPlace root() const { return {file_ + ":", *json_}; }

 private:
  std::string file_;
  std::shared_ptr<const nlohmann::ordered_json> json_;
};

}  // namespace chasles
