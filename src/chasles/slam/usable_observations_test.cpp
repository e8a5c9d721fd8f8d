#include <limits>

#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/usable_observations.hpp>

namespace chasles {
namespace {

TEST(UsableObservations, AreFiniteOfKnownCamerasAndTheFirstOfTheirKind) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PixelObservation> pixels{{.landmark = 5, .camera = 0, .pixel = {1, 1}},
                                             {.landmark = 4, .camera = 1, .pixel = {2, 2}},
                                             {.landmark = 5, .camera = 0, .pixel = {3, 3}},
                                             {.landmark = 5, .camera = 1, .pixel = {4, 4}},
                                             {.landmark = 6, .camera = 2, .pixel = {5, 5}},
                                             {.landmark = 7, .camera = -1, .pixel = {6, 6}},
                                             {.landmark = 8, .camera = 0, .pixel = {nan, 7}}};
  UsableObservations usable;
  EXPECT_EQ(usable.among(pixels, 2),
            (std::vector<const PixelObservation*>{&pixels[0], &pixels[1], &pixels[3]}));
}

}  // namespace
}  // namespace chasles
