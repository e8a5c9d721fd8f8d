#include <chasles/base/validate.hpp>
#include <chasles/frontend/frontend_settings.hpp>

namespace chasles {

void validate(const FrontendSettings& s) {
  validate_fields(s, "frontend.");
  if (s.window % 2 == 0) {
    reject_value("frontend.window", setting_text(s.window), "an odd number: a patch has a middle");
  }
  if (s.predicted_levels > s.levels) {
    reject_value("frontend.predicted_levels", setting_text(s.predicted_levels),
                 "not more than levels, " + setting_text(s.levels));
  }
}

}  // namespace chasles
