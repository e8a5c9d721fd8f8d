#pragma once

#include <string_view>

namespace chasles {

/// src/web/page.html with its style sheets and scripts, as Vite builds it
/// (tools/cmake/EmbedPage.cmake). The JSON of the runs replaces `@PAGE_DATA@`.
extern const std::string_view page_template;

/// src/web/study.html in the same form, for studies.
extern const std::string_view study_template;

/// src/web/map.html in the same form, for saved maps.
extern const std::string_view map_template;

/// src/web/batch.html in the same form, for batches of recordings.
extern const std::string_view batch_template;

/// src/web/calibration.html in the same form, for calibrations.
extern const std::string_view calibration_template;

}  // namespace chasles
