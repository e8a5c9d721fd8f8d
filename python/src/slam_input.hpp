#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <chasles/pipeline/visual_inertial_slam.hpp>

#include "arrays.hpp"

// What the classes Slam and RealtimeSlam of the package have in common.
namespace chasles::python {

using Estimates = std::vector<Estimate>;

/// A Camera, or a sequence of them. Throws TypeError for another object.
std::vector<Camera> cameras_of(const std::string& name, const py::object& cameras);

/// The estimator of a class with this name; `map`: a file, or none. Throws UsageError for arguments
/// that cannot be used.
std::unique_ptr<VisualInertialSlam> make_slam(const char* name, const py::object& cameras,
                                              const ImuNoise* noise, const std::string& estimator,
                                              const std::optional<std::filesystem::path>& map,
                                              const py::kwargs& arguments);

/// A sample, with time, (3,) and (3,), or (N,) of them. Throws ValueError for other shapes.
std::vector<ImuSample> samples_of(const py::object& time, const Rows& rate, const Rows& force);
/// `images`: a sequence with an image for each camera, or that of the only one.
ImageFrame frame_of(const py::object& time, const py::object& images);

void add_counts(const ArrivalCounts& counts, py::dict& dict);

/// Warns once of each kind of input that gives no estimate.
class ArrivalWarnings {
 public:
  /// Throws where warnings are errors.
  void warn(const ArrivalCounts& counts);

 private:
  bool not_finite_ = false, late_samples_ = false, dropped_ = false, late_images_ = false,
       uncovered_ = false;
};

/// Docstrings.
inline constexpr const char* kSlamArguments =
    "cameras: a Camera, or a list of them; noise: ImuNoise; estimator: 'filter', 'window:N' or "
    "'batch'; map: file of a saved map; and settings by name, as chasles.settings() lists them.";
inline constexpr const char* kPredicted =
    "The state at a time since the last estimate, by the samples (PredictedState). None before a "
    "start, before the last estimate's time, .5 s after the last sample, 5 s after the estimate, "
    "where the estimate is lost, and where samples are missing for more than .5 s.";

}  // namespace chasles::python
