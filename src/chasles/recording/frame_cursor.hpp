#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/codec/csv.hpp>

namespace chasles {

/// Finds the frames of a table's rows. Frames and rows are in order of time, and a frame may have
/// any number of rows.
class FrameCursor {
 public:
  /// The frames must outlive the cursor, and keep their places.
  explicit FrameCursor(std::vector<FeatureFrame>& frames)
      : frame_(frames.begin()), end_(frames.end()) {}

  /// The frame of this time, at or after the last one that was found; null: none.
  FeatureFrame* find(Time time);
  /// The frame of a row, whose first column is its time. Throws InputError where there is none.
  FeatureFrame& frame_of(const CsvReader& row);

 private:
  std::vector<FeatureFrame>::iterator frame_, end_;
};

}  // namespace chasles
