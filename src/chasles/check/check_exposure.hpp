#pragma once

#include <chasles/camera/image_frame.hpp>
#include <chasles/check/check_report.hpp>
#include <chasles/codec/image_source.hpp>

namespace chasles {

/// The exposure of an image.
struct ImageExposure {
  double mean = 0;      ///< mean of the pixels, 0 to 255
  double dark = 0;      ///< share of pixels up to 10
  double bright = 0;    ///< share of pixels from 250 on: saturated
  double contrast = 0;  ///< standard deviation of the pixels
};

/// The exposure of an image. Presumes that it is not empty.
ImageExposure exposure_of(const GrayImage& image);

/// Facts and findings from up to `most` pairs of neighbouring frames, evenly spread over the
/// recording: exposure of every camera, frames without contrast, images that repeat the one before,
/// damaged files.
void report_exposure(const ImageSource& images, std::size_t cameras, std::size_t most,
                     CheckReport& report);

}  // namespace chasles
