#include <algorithm>

#include <chasles/base/validate.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

void validate(const InitialiserSettings& s) {
  validate_fields(s, "start.");
  if (s.max_window < std::max(s.min_window, s.min_stereo_window)) {
    reject_value("start.max_window", setting_text(s.max_window),
                 "at least min_window and min_stereo_window");
  }
  if (s.heading_sigma > 0 && !s.heading) {
    reject_value("start.heading_sigma", setting_text(s.heading_sigma), "0 without start.heading");
  }
  if (s.in_map && !s.heading) {
    reject_value("start.in_map", "true", "false without start.heading, the heading in the map");
  }
}

}  // namespace chasles
