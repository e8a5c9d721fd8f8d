#pragma once

#include <memory>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/codec/image_source.hpp>
#include <chasles/video/frame_decoder.hpp>

namespace chasles {

/// The pictures of a video as the images of one camera, at these times (one for each picture, by
/// the clock of the IMU). Each is decoded when it is read: in order of time that is one pass
/// through the file. Throws InputError for a video whose pictures have not the camera's size, with
/// what to do.
std::shared_ptr<const ImageSource> open_video_images(VideoIndex index, std::vector<Time> times,
                                                     const Camera& camera);

}  // namespace chasles
