#include <algorithm>
#include <array>

#include <chasles/base/validate.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/target/marker_codes.hpp>
#include <chasles/target/marker_dictionary.hpp>

namespace chasles {
namespace {

namespace mc = marker_codes;

std::span<const std::uint64_t> first(std::span<const std::uint64_t> codes, std::size_t count) {
  return codes.first(count);
}

const std::array kDictionaries = {
    MarkerDictionary{"DICT_4X4_50", 4, first(mc::k4X4_1000, 50)},
    MarkerDictionary{"DICT_4X4_100", 4, first(mc::k4X4_1000, 100)},
    MarkerDictionary{"DICT_4X4_250", 4, first(mc::k4X4_1000, 250)},
    MarkerDictionary{"DICT_4X4_1000", 4, mc::k4X4_1000},
    MarkerDictionary{"DICT_5X5_50", 5, first(mc::k5X5_1000, 50)},
    MarkerDictionary{"DICT_5X5_100", 5, first(mc::k5X5_1000, 100)},
    MarkerDictionary{"DICT_5X5_250", 5, first(mc::k5X5_1000, 250)},
    MarkerDictionary{"DICT_5X5_1000", 5, mc::k5X5_1000},
    MarkerDictionary{"DICT_6X6_50", 6, first(mc::k6X6_1000, 50)},
    MarkerDictionary{"DICT_6X6_100", 6, first(mc::k6X6_1000, 100)},
    MarkerDictionary{"DICT_6X6_250", 6, first(mc::k6X6_1000, 250)},
    MarkerDictionary{"DICT_6X6_1000", 6, mc::k6X6_1000},
    MarkerDictionary{"DICT_7X7_50", 7, first(mc::k7X7_1000, 50)},
    MarkerDictionary{"DICT_7X7_100", 7, first(mc::k7X7_1000, 100)},
    MarkerDictionary{"DICT_7X7_250", 7, first(mc::k7X7_1000, 250)},
    MarkerDictionary{"DICT_7X7_1000", 7, mc::k7X7_1000},
    MarkerDictionary{"DICT_APRILTAG_16h5", 4, mc::kAPRILTAG_16h5},
    MarkerDictionary{"DICT_APRILTAG_25h9", 5, mc::kAPRILTAG_25h9},
    MarkerDictionary{"DICT_APRILTAG_36h11", 6, mc::kAPRILTAG_36h11},
    MarkerDictionary{"DICT_ARUCO_MIP_36h12", 6, mc::kARUCO_MIP_36h12},
    MarkerDictionary{"DICT_ARUCO_ORIGINAL", 5, mc::kARUCO_ORIGINAL},
};

}  // namespace

std::vector<std::string> dictionary_names() {
  std::vector<std::string> names;
  for (const MarkerDictionary& dictionary : kDictionaries) names.emplace_back(dictionary.name);
  return names;
}

MarkerDictionary marker_dictionary(const std::string& name) {
  const auto* const found = std::ranges::find(kDictionaries, name, &MarkerDictionary::name);
  if (found != kDictionaries.end()) return *found;
  reject_value(
      "dictionary", quoted_text(name),
      "one of " + quoted_list(dictionary_names()) + did_you_mean(name, dictionary_names()));
}

MarkerDictionary target_dictionary(const Target& target) {
  return marker_dictionary(target.kind == TargetKind::april_grid ? "DICT_APRILTAG_36h11"
                                                                 : target.dictionary);
}

std::uint64_t turned(std::uint64_t code, int side) {
  std::uint64_t result = 0;
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      const int from =
          column * side + (side - 1 - row);  // counterclockwise: the right column goes up
      result = 2 * result + (code >> (side * side - 1 - from) & 1);
    }
  }
  return result;
}

}  // namespace chasles
