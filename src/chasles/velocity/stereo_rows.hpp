#pragma once

#include <chasles/base/settings.hpp>

namespace chasles {

/// Which of the four pixels a measurement keeps. vL and vR say the same thing, so their mean loses
/// nothing; the disparity may be left out where its error stays the same along a track and would be
/// counted again with every frame.
enum class StereoRows {
  kAll,            ///< (uL, vL, uR, vR), as Du (20) has it
  kMeanDisparity,  ///< ((uL + uR)/2, (vL + vR)/2, uL - uR): independent where the four are
  kMean,           ///< ((uL + uR)/2, (vL + vR)/2)
};

template <>
struct Choices<StereoRows> {
  static constexpr std::array list{Choice{StereoRows::kAll, "all"},
                                   Choice{StereoRows::kMeanDisparity, "mean+disparity"},
                                   Choice{StereoRows::kMean, "mean"}};
};

}  // namespace chasles
