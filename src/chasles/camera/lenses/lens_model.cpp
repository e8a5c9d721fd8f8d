#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include <chasles/camera/lenses/lens_model.hpp>

namespace chasles {
namespace {

constexpr bool in_order_of_enum() {
  for (std::size_t i = 0; i < kLensModels.size(); ++i) {
    if (static_cast<std::size_t>(kLensModels[i].distortion) != i) return false;
  }
  return true;
}
static_assert(in_order_of_enum());

constexpr std::size_t kTiltedSensor = 14;  // OpenCV's coefficients with tauX and tauY

std::string small_letters(std::string_view text) {
  std::string small(text);
  std::ranges::transform(small, small.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return small;
}

// Whether a word stands in a text of words.
bool has_word(std::string_view text, std::string_view word) {
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    if (text.substr(0, end) == word) return true;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return false;
}

// "a, b or c"
std::string counts_text(const LensModel& model) {
  std::string text;
  for (std::size_t i = 0; i < model.counts.size() && model.counts[i] > 0; ++i) {
    const bool last = i + 1 == model.counts.size() || model.counts[i + 1] == 0;
    if (i > 0) text += last ? " or " : ", ";
    text += std::to_string(model.counts[i]);
  }
  return text.empty() ? "0" : text;
}

// The names of the coefficients, with all brackets closed.
std::string closed(std::string_view names) {
  return std::string(names) +
         std::string(static_cast<std::size_t>(std::ranges::count(names, '[')), ']');
}

bool may_have(const LensModel& model, std::size_t count) {
  if (count == 0) return model.counts[0] == 0;
  return std::ranges::find(model.counts, count) != model.counts.end();
}

}  // namespace

const LensModel* find_lens_model(Distortion distortion) {
  const auto index = static_cast<std::size_t>(distortion);
  return index < kLensModels.size() ? &kLensModels[index] : nullptr;
}

std::optional<Distortion> lens_model_named(std::string_view name) {
  const std::string small = small_letters(name);
  for (const LensModel& model : kLensModels) {
    if (small == model.name || has_word(model.other_names, small)) return model.distortion;
  }
  return std::nullopt;
}

std::string lens_model_names() {
  std::string text;
  for (const LensModel& model : kLensModels) {
    if (!text.empty()) text += ", ";
    text += model.name;
    if (model.other_names.empty()) continue;
    text += " (also ";
    for (const char c : model.other_names) text += c == ' ' ? std::string(", ") : std::string(1, c);
    text += ")";
  }
  return text;
}

std::vector<std::string> coefficient_names(Distortion distortion) {
  std::vector<std::string> names;
  std::istringstream words{std::string(find_lens_model(distortion)->coefficients)};
  for (std::string word; words >> word;) {
    names.push_back(word.front() == '[' ? word.substr(1) : word);
  }
  return names;
}

std::string lens_model_coefficients() {
  std::string text;
  for (const LensModel& model : kLensModels) {
    if (!text.empty()) text += ", ";
    text += model.name;
    if (!model.coefficients.empty()) text += " (" + closed(model.coefficients) + ")";
  }
  return text;
}

std::span<const double> without_padding(Distortion distortion, std::span<const double> list) {
  const LensModel* model = find_lens_model(distortion);
  std::size_t stated = list.size();
  while (stated > 0 && list[stated - 1] == 0) --stated;
  if (!model) return list;
  if (model->counts[0] == 0) return list.first(stated);
  for (const std::size_t count : model->counts) {
    if (count > 0 && count >= stated && count <= list.size()) return list.first(count);
  }
  return list;
}

std::string coefficients_fault(Distortion distortion, std::span<const double> list) {
  const LensModel* model = find_lens_model(distortion);
  if (!model) return "is a lens model that is not known";
  const std::string name(model->name);
  if (!std::ranges::all_of(list, [](double k) { return std::isfinite(k); })) {
    return "has a coefficient that is not finite, expected finite numbers";
  }
  if (!may_have(*model, list.size())) {
    const bool tilted = distortion == Distortion::kRadtan && list.size() == kTiltedSensor;
    return "has " + std::to_string(list.size()) + " coefficients, expected " + counts_text(*model) +
           " with the model " + name +
           (model->coefficients.empty() ? "" : ": " + closed(model->coefficients)) +
           (tilted ? " (a tilted sensor, tauX and tauY, is not supported)" : "");
  }
  if (model->is_within && !model->is_within(LensCoefficients(list))) {
    std::string found;
    for (const double k : list) found += (found.empty() ? "" : ", ") + std::to_string(k);
    return "has the coefficients " + found + ", expected " + std::string(model->limits) +
           " with the model " + name;
  }
  return "";
}

}  // namespace chasles
