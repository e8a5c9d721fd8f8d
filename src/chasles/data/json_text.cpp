#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/data/json_text.hpp>
#include <chasles/data/read_budget.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kBytesOfValue = 32;
// The keys of an object are compared with each other.
constexpr std::size_t kMostJsonKeys = 10'000;

// Counts what a text would take, before the value is made. Stops at an error of the text, of which
// the parser then makes the message.
class JsonLimits : public nlohmann::json_sax<OrderedJson> {
 public:
  explicit JsonLimits(const std::string& where)
      : where_(where), most_values_(read_budget().bytes / kBytesOfValue) {}

  bool null() override { return count(); }
  bool boolean(bool) override { return count(); }
  bool number_integer(number_integer_t) override { return count(); }
  bool number_unsigned(number_unsigned_t) override { return count(); }
  bool number_float(number_float_t, const string_t&) override { return count(); }
  bool string(string_t&) override { return count(); }
  bool binary(binary_t&) override { return count(); }
  bool start_object(std::size_t) override { return open(); }
  bool start_array(std::size_t) override { return open(); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const OrderedJson::exception&) override {
    return false;
  }
  bool key(string_t&) override {
    if (++keys_.back() <= kMostJsonKeys) return true;
    throw InputError(fmt::format("{}: an object has more than {} keys", where_, kMostJsonKeys));
  }

 private:
  bool count() {
    if (++values_ > most_values_) {
      check_memory(fmt::format("{}: has more than {} values", where_, most_values_),
                   values_ * kBytesOfValue);
    }
    return true;
  }
  bool open() {
    keys_.push_back(0);
    check_depth(where_, static_cast<int>(keys_.size()));
    return count();
  }
  bool close() {
    keys_.pop_back();
    return true;
  }

  const std::string& where_;
  std::size_t most_values_, values_ = 0;
  std::vector<std::size_t> keys_;  // of the objects and arrays that are open
};

}  // namespace

OrderedJson parse_json(std::string_view text, const std::string& where) {
  JsonLimits limits(where);
  OrderedJson::sax_parse(text, &limits);
  try {
    return OrderedJson::parse(text);
  } catch (const OrderedJson::exception& error) {
    throw InputError(fmt::format("{}: is not valid JSON: {}", where, error.what()));
  }
}

OrderedJson parse_json_object(std::string_view text, const std::string& where) {
  OrderedJson json = parse_json(text, where);
  if (json.is_object()) return json;
  throw InputError(where + ": expected a JSON object");
}

}  // namespace chasles
