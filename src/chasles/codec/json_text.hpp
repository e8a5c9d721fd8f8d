#pragma once

#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace chasles {

/// The value of a JSON text of a file. Throws InputError if it is not valid JSON, has a number
/// beyond a double, nests too deep or takes too much memory (read_budget.hpp), has more than
/// 10,000 keys in one object, or thousands in many objects. `where` names the file.
nlohmann::ordered_json parse_json(std::string_view text, const std::string& where);

/// The same, for a text that must be an object.
nlohmann::ordered_json parse_json_object(std::string_view text, const std::string& where);

}  // namespace chasles
