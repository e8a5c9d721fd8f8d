#include <chasles/filter/error_chart.hpp>
#include <chasles/slam/inertial_settings.hpp>
#include <chasles/validate.hpp>

namespace chasles {

void validate(const InertialSlamSettings& s) {
  validate_fields(s);
  if (s.composition_interval > 0 && !s.nav_attitude) {
    refuse_value("composition_interval", setting_text(s.composition_interval),
                 "0 without nav_attitude, the world's attitude in the state");
  }
  if (s.keep_scale == KeepScale::kTrue && s.chart == kLeftSe3Chart.name) {
    refuse_value("keep_scale", setting_text(s.keep_scale),
                 "auto or false with the chart left-se3, whose pose errors turn with the pose");
  }
}

}  // namespace chasles
