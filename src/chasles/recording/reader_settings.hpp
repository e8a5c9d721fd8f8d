#pragma once

#include <array>
#include <cstddef>

#include <chasles/base/settings.hpp>
#include <chasles/calibration/all_cameras.hpp>

namespace chasles {

/// Treatment of stale pixels: an observation whose four numbers equal those of the frame before.
enum class StalePixels {
  kKeep,
  /// The observation is dropped. Later observations of its track belong to another physical point
  /// (docs/formats.md), which becomes a new landmark. Equal numbers in three or more successive
  /// frames mean a static camera, and stay.
  kCut,
};

/// Interpretation of the extrinsics of an ECE276A archive.
enum class ArchiveExtrinsics { kAuto, kRecorded };

template <>
struct Choices<StalePixels> {
  static constexpr std::array list{Choice{StalePixels::kCut, "cut"},
                                   Choice{StalePixels::kKeep, "keep"}};
};

template <>
struct Choices<ArchiveExtrinsics> {
  static constexpr std::array list{Choice{ArchiveExtrinsics::kAuto, "auto"},
                                   Choice{ArchiveExtrinsics::kRecorded, "recorded"}};
};

/// How an ECE276A archive is read. The defaults repair its known faults. `cameras` is no setting of
/// that kind: it applies to recordings of images.
struct ReaderSettings {
  StalePixels stale_pixels = StalePixels::kCut;
  ArchiveExtrinsics extrinsics = ArchiveExtrinsics::kAuto;
  /// How many of the first cameras are read. The files of further cameras are ignored altogether.
  std::size_t cameras = kAllCameras;

  bool operator==(const ReaderSettings&) const = default;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<ReaderSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("stale_pixels", s.stale_pixels, "choice",
        "observations of an ECE276A archive that repeat those of the frame before: cut drops them "
        "and ends their landmarks, keep uses them as recorded",
        limits::kAny);
  visit("extrinsics", s.extrinsics, "choice",
        "cam_T_imu of an ECE276A archive: auto takes the interpretation that agrees with the data, "
        "recorded the matrix as it is",
        limits::kAny);
}

}  // namespace chasles
