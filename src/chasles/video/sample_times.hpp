#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/video/video_index.hpp>

namespace chasles {

/// The samples of one stream in one payload, without their values.
struct SampleBlock {
  std::size_t payload = 0;             ///< its number in the video
  Time begin{}, duration{};            ///< of the payload
  std::uint64_t first = 0;             ///< number of its first sample in the recording
  std::size_t count = 0;               ///< its samples, at least one
  std::optional<std::uint64_t> stamp;  ///< of its first sample [us]
  double delay = 0;                    ///< [s]
};

/// GoPro's streams that have a sample for each picture, or for every n-th: the first one that is
/// there counts.
inline constexpr std::array<const char*, 5> kStreamsOfPictures{"SHUT", "ISOE", "ISOG", "WRGB",
                                                               "CORI"};

/// A straight line, by least squares.
struct Line {
  double x0 = 0, y0 = 0, slope = 1;
  double operator()(double x) const { return y0 + slope * (x - x0); }
};

/// Through the points; with `slope` through one point or through points of one x. `x`, `y`: of one
/// size, at least one.
Line fitted_line(const std::vector<double>& x, const std::vector<double>& y, double slope);

/// Whether all payloads have a stamp, and these rise.
bool are_stamped(const std::vector<SampleBlock>& blocks);

/// From the clock of the stamps [us] to that of the video [s], through a stream that has a sample
/// for each picture or every n-th one. Nothing if it does not fit the pictures within half the
/// time between two.
std::optional<Line> clock_by_pictures(const std::vector<SampleBlock>& blocks,
                                      const std::vector<VideoPicture>& pictures);

/// The times of all samples [s], by their stamps and the clock of these.
std::vector<double> stamped_times(const std::vector<SampleBlock>& blocks, const Line& clock);

/// The times of all samples [s], by the starts of the payloads.
std::vector<double> times_by_payloads(const std::vector<SampleBlock>& blocks);

}  // namespace chasles
