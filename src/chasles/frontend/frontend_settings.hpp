#pragma once

#include <string>

#include <chasles/base/settings.hpp>

namespace chasles {

enum class CornerMeasure {
  kHarris,     ///< det - 0.04 trace^2 (Harris & Stephens 1988)
  kShiTomasi,  ///< the smaller eigenvalue (Shi & Tomasi 1994)
};
enum class Equalisation { kNone, kHistogram, kClahe };

template <>
struct Choices<CornerMeasure> {
  static constexpr std::array list{Choice{CornerMeasure::kHarris, "harris"},
                                   Choice{CornerMeasure::kShiTomasi, "shi-tomasi"}};
};

template <>
struct Choices<Equalisation> {
  static constexpr std::array list{Choice{Equalisation::kNone, "none"},
                                   Choice{Equalisation::kHistogram, "histogram"},
                                   Choice{Equalisation::kClahe, "clahe"}};
};

/// All settings of the image front end. The list below defines files, --set, --help and
/// summary.json.
struct FrontendSettings {
  CornerMeasure corners = CornerMeasure::kHarris;
  Equalisation equalisation = Equalisation::kNone;
  std::string mask = {};
  int max_tracks = 150;
  int grid_columns = 10;
  int grid_rows = 6;
  int cells_per_frame = 15;
  double min_distance = 15;
  double border = 8;
  double min_corner_gradient = 3;

  int window = 15;
  int levels = 4;
  int predicted_levels = 1;
  double min_correlation = 0.9;
  double max_backward_error = 0.7;
  double max_gap = 0.5;
  int patch_frames = 30;
  double min_kept_correlation = 0.95;
  double max_stretch = 1.6;

  bool reject_outliers = true;
  double outlier_threshold = 1.0;

  bool stereo = true;
  double epipolar_threshold = 1.0;
  double min_stereo_depth = 0.3;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<FrontendSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("corners", s.corners, "choice", "the measure that ranks corners", limits::kAny);
  visit("equalisation", s.equalisation, "choice",
        "of the grey levels, before all other steps; tracking itself is insensitive to gain and "
        "offset",
        limits::kAny);
  visit("mask", s.mask, "",
        "image of a camera's size, black where nothing is to be tracked (a robot's own arm); for a "
        "rig one file per camera, separated by commas; empty: none",
        limits::kAny);
  visit("max_tracks", s.max_tracks, "count",
        "maximum number at a time, shared by the cameras that find tracks",
        limits::from_to(1, 10000));
  visit("grid_columns", s.grid_columns, "count", "of cells over which the tracks are spread",
        limits::from_to(1, 100));
  visit("grid_rows", s.grid_rows, "count", "of cells over which the tracks are spread",
        limits::from_to(1, 100));
  visit("cells_per_frame", s.cells_per_frame, "count",
        "cells searched for corners in a frame, unless half of the tracks are gone",
        limits::from_to(1, 10000));
  visit("min_distance", s.min_distance, "px", "of a new corner to every track",
        limits::from_to(1, 1000));
  visit("border", s.border, "px", "at the image's edge where nothing is tracked",
        limits::from_to(0, 1000));
  visit("min_corner_gradient", s.min_corner_gradient, "grey levels/px",
        "a corner's mean (rms) gradient in its weakest direction", limits::from_to(0, 255));
  visit("window", s.window, "px", "side of a track's patch, odd", limits::from_to(7, 23));
  visit("levels", s.levels, "count", "of the image pyramid, each half as large",
        limits::from_to(1, 6));
  visit("predicted_levels", s.predicted_levels, "count",
        "used where the gyroscope predicts the position of a track; all where that fails",
        limits::from_to(1, 6));
  visit("min_correlation", s.min_correlation, "1",
        "minimum correlation of a patch with the one that is found", limits::from_to(-1, 1));
  visit("max_backward_error", s.max_backward_error, "px",
        "maximum distance of a patch that is followed to the new image and back",
        limits::from_to(0.01, 1000));
  visit("max_gap", s.max_gap, "s",
        "tracks end after this time without a usable image (missing, black, saturated)",
        limits::from_to(0, 10));
  visit("patch_frames", s.patch_frames, "count",
        "a track's patch is kept for so many images while it fits, and searched in every third of "
        "them, so that errors of single steps do not accumulate; 1 or 2: only each image's patch "
        "in the next one",
        limits::from_to(1, 100));
  visit("min_kept_correlation", s.min_kept_correlation, "1",
        "minimum correlation of a patch with the one that is kept; otherwise the track ends. Lower "
        "where noise lowers it between images as well",
        limits::from_to(-1, 1));
  visit("max_stretch", s.max_stretch, "1",
        "a track ends when its patch is longer or shorter by this factor than at its beginning",
        limits::from_to(1, 1000));
  visit("reject_outliers", s.reject_outliers, "bool", "two-view check of all tracks together",
        limits::kAny);
  visit("outlier_threshold", s.outlier_threshold, "px", "distance to the epipolar line of motion",
        limits::from_to(0.01, 1000));
  visit("stereo", s.stereo, "bool", "find tracks in the other cameras whose views overlap",
        limits::kAny);
  visit("epipolar_threshold", s.epipolar_threshold, "px",
        "distance to the epipolar line of the rig", limits::from_to(0.01, 1000));
  visit("min_stereo_depth", s.min_stereo_depth, "m", "nearest point that is searched",
        limits::from_to(0.01, 1000));
}

/// Throws UsageError with the setting's name ("frontend.window"), its value and the expected one,
/// for a value out of its limits.
void validate(const FrontendSettings& settings);

}  // namespace chasles
