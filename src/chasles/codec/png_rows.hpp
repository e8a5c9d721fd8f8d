#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace chasles {

/// Undoes the filters of PNG's rows (PNG specification, section 9).
///
/// `filtered`: rows of 1 + `row_bytes` bytes, of which the first names the filter; `pixel_bytes`:
/// the bytes of a pixel, 1 to 8. Passes each row's number and bytes to `take`, in order. Returns
/// false, after the rows before it, at a row whose filter PNG does not have.
bool unfilter_png_rows(std::span<const std::uint8_t> filtered, std::size_t row_bytes,
                       std::size_t pixel_bytes,
                       const std::function<void(std::size_t, std::span<const std::uint8_t>)>& take);

}  // namespace chasles
