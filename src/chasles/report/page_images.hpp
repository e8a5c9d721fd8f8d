#pragma once

#include <cstddef>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>

namespace chasles {

/// The limit for all pictures of a page, before base64 [bytes].
inline constexpr std::size_t kPagePictures = 8'000'000;

/// `images` of a run in the page's data: for each camera {width, height, t, jpeg, count, …}. Times
/// are in seconds from the first state; pictures in base64 ("": none). The points of all pictures
/// follow one another, `count` for each picture, as columns of integers: id, age and outcome (0
/// waiting, 1 begun, 2 used, 3 rejected); u and v in tenths of a pixel. In hundredths of a pixel,
/// relative to (u, v): the previous position (before_u, before_v; 0: unknown) and the predicted
/// position (expected_u, expected_v). The prediction's standard deviations (sigma_u, sigma_v; 0:
/// unknown) are in hundredths of a pixel, its correlation in hundredths. If the pictures exceed
/// `most` bytes, whole frames are left out evenly until the rest fits.
nlohmann::ordered_json images_json(const Run& run, std::size_t most);

}  // namespace chasles
