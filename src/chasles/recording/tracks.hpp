#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/recording/reader_settings.hpp>

namespace chasles {

/// One observation in a table of tracks: column `track`, row `frame`, pixels (uL, vL, uR, vR).
struct TrackPoint {
  std::uint32_t track = 0;
  std::uint32_t frame = 0;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
};

/// Stereo tracks in the layout of third-party recordings: 4 numbers for every track and frame, -1
/// without an observation. Only the observations are kept (one entry in a hundred).
struct TrackTable {
  std::size_t tracks = 0;
  std::size_t frames = 0;
  std::vector<TrackPoint> points;
  std::size_t partial = 0;  ///< left out: entries with some, not all, of the four numbers missing
};

/// Builds a TrackTable from the numbers of an array, which arrive in the order of the file.
class TrackCollector {
 public:
  /// The order of the numbers, the fastest index last.
  enum class Order {
    kPixelTrackFrame,  ///< .npz, C order: all uL, then all vL, …
    kFrameTrackPixel,  ///< .npz, Fortran order
    kTrackFramePixel,  ///< .mat, 4 x frames x tracks
  };

  /// `where` names the field in messages.
  TrackCollector(std::size_t tracks, std::size_t frames, Order order, std::string where);

  /// Adds the next numbers. Throws InputError for a number that is not finite, and for more
  /// observations than the budget allows.
  void add(std::span<const double> values);

  /// The table, its points in order of track, then frame.
  TrackTable finish() &&;

 private:
  void add_plane(std::span<const double> values);
  void begin_points(std::span<const double> piece, std::size_t begin);
  void fill_points(std::span<const double> piece, std::size_t begin, std::size_t pixel);
  void add_points(std::span<const double> values);
  void keep(std::size_t track, std::size_t frame, const Eigen::Vector4d& pixels);
  [[noreturn]] void fail_not_finite(std::size_t pixel, std::size_t track, std::size_t frame,
                                    double value) const;

  TrackTable table_;
  Order order_;
  std::string where_;
  std::size_t most_points_;
  std::size_t position_ = 0;  // of the next number in the array
  std::size_t next_ = 0;      // the point that the next number of a plane can belong to
  Eigen::Vector4d pixels_ = Eigen::Vector4d::Zero();
};

/// The frames of a table. Frames without observations stay, as empty ones. Left out and counted in
/// `remarks`: stale observations, and observations whose disparity uL - uR is not positive.
///
/// The landmark number is `track + segment * table.tracks`, where the segment counts the cuts of
/// the track so far. Observations are in order of landmark number.
std::vector<FeatureFrame> make_frames(const TrackTable& table, const std::vector<Time>& times,
                                      StalePixels stale_pixels, std::vector<std::string>& remarks);

}  // namespace chasles
