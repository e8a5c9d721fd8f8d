#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/json_text.hpp>
#include <chasles/codec/read_budget.hpp>

namespace chasles {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::size_t kBytesOfValue = 32;
// The keys of an object are compared with each other. An object of a run has about a hundred.
constexpr std::size_t kMostJsonKeys = 10'000;
constexpr std::size_t kMostCompared = 100'000'000, kComparedOfByte = 20, kBytesOfComparison = 16;

// Counts what a text would take, before the value is made. Stops at an error of the text, of which
// the parser then makes the message.
class JsonLimits : public nlohmann::json_sax<OrderedJson> {
 public:
  JsonLimits(const std::string& where, std::size_t bytes)
      : where_(where),
        most_values_(read_budget().bytes / kBytesOfValue),
        most_compared_(kMostCompared + kComparedOfByte * bytes) {}

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
  bool key(string_t& name) override {
    compared_ += keys_.back() * (1 + name.size() / kBytesOfComparison);
    if (++keys_.back() > kMostJsonKeys) {
      throw InputError(fmt::format("{}: an object has more than {} keys", where_, kMostJsonKeys));
    }
    if (compared_ <= most_compared_) return true;
    throw InputError(fmt::format("{}: too many objects have thousands of keys", where_));
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
  std::size_t most_compared_, compared_ = 0;  // pairs of keys
  std::vector<std::size_t> keys_;             // of the objects and arrays that are open
};

}  // namespace

OrderedJson parse_json(std::string_view text, const std::string& where) {
  JsonLimits limits(where, text.size());
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
