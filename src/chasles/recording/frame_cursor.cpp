#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/recording/frame_cursor.hpp>

namespace chasles {

FeatureFrame* FrameCursor::find(Time time) {
  for (; frame_ != end_ && frame_->time < time; ++frame_) {
    // All its rows are read: the frames of an hour would hold half as much again for nothing.
    frame_->observations.shrink_to_fit();
    frame_->pixels.shrink_to_fit();
  }
  return frame_ != end_ && frame_->time == time ? &*frame_ : nullptr;
}

FeatureFrame& FrameCursor::frame_of(const CsvReader& row) {
  const Time time = row.time(0);
  if (FeatureFrame* frame = find(time)) return *frame;
  throw InputError(fmt::format(
      "{}: {} is no frame of frames.csv at or after that of the row before, expected rows in "
      "order of time, each of a frame",
      row.where(0), time.count()));
}

}  // namespace chasles
