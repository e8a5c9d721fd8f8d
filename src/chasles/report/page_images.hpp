#pragma once

#include <cstddef>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/run.hpp>

namespace chasles {

/// What a page's pictures may come to, before base64 [bytes].
inline constexpr std::size_t kPagePictures = 8'000'000;

/// `images` of a run in the page's data: a camera each {width, height, t, jpeg, count, …}: times in
/// seconds from the first state, pictures in base64 ("": none), and the points of all of them one
/// after the other, `count` of each, as columns of whole numbers: id, age and outcome (0 waiting,
/// 1 begun, 2 used, 3 rejected); u and v in tenths of a pixel; from there in hundredths of a pixel
/// to where it was before (before_u, before_v; 0: unknown) and to where it was expected
/// (expected_u, expected_v); deviations of that (sigma_u, sigma_v; 0: unknown) in hundredths of a
/// pixel, and their correlation in hundredths. Of more than `most` bytes of pictures so many whole
/// frames are left out, evenly, that the rest fits.
nlohmann::ordered_json images_json(const Run& run, std::size_t most);

}  // namespace chasles
