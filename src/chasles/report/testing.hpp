#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/report/report.hpp>

/// Shared by the tests of this folder.
namespace chasles::test {

struct DriveOptions {
  int states = 1000;
  int landmarks = 5000;
  std::uint64_t seed = 1;
  bool truth = true;
  bool dead_reckoning = true;
  bool initial = false;    ///< landmarks know where they were initialised, but for every tenth
  bool prior_map = false;  ///< the run has found its place in synthetic_map() of its landmarks
};

/// A synthetic run, without a filter: a 700 m loop through streets. The error of the estimate grows
/// with its covariance; dead reckoning drifts away. Landmarks are on façades; their ellipses are
/// elongated along the viewing direction.
ReportRun synthetic_drive(const DriveOptions& options = {});

/// A map of two sessions, "Monday" and "Tuesday", beside these landmarks: one for each, in a frame
/// that is turned and moved. Every third has the id of its landmark, the others larger ones, and
/// every sixth has been recognised.
MapSketch synthetic_map(const std::vector<RunLandmark>& landmarks);

/// Adds images of two cameras to the run, every `every` states, of 96 x 60 px and half as wide as
/// their cameras. Each has a dozen points of every outcome that move to the right. The second
/// camera has no pictures.
void add_synthetic_images(Run& run, int every);

/// The JSON inside a page, as a browser's parser finds it.
nlohmann::json data_of(const std::string& page);

/// The bytes of a column of the JSON: its byte planes (encode.hpp), inflated.
std::string planes_of(const std::string& column);

/// A column of the JSON, decoded without the encoder.
std::vector<double> column(const nlohmann::json& text);

}  // namespace chasles::test
