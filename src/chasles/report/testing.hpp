#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/report/report.hpp>

/// What the tests of this folder share.
namespace chasles::test {

struct DriveOptions {
  int states = 1000;
  int landmarks = 5000;
  std::uint64_t seed = 1;
  bool truth = true;
  bool dead_reckoning = true;
};

/// A run to look at, without a filter: a 700 m loop through streets, an estimate whose error grows
/// as its covariance says, dead reckoning that bends away, landmarks on façades whose ellipses
/// point away from the cameras that saw them.
ReportRun synthetic_drive(const DriveOptions& options = {});

/// Gives the run images of two cameras, every `every` states, of 96 x 60 px and half as wide as
/// their cameras: in each a dozen points of every outcome, that move to the right. The second
/// camera has no pictures.
void add_synthetic_images(Run& run, int every);

/// The json inside a page, as a browser's parser finds it.
nlohmann::json data_of(const std::string& page);

/// The bytes of a column of the json: its byte planes (encode.hpp), inflated.
std::string planes_of(const std::string& column);

/// A column of the json, decoded without the encoder.
std::vector<double> column(const nlohmann::json& text);

}  // namespace chasles::test
