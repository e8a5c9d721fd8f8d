#pragma once

#include <string_view>

namespace chasles {

/// web/page.html with its style sheets and scripts, as Vite builds it (cmake/EmbedPage.cmake).
/// `@PAGE_DATA@` stands where the json of the runs belongs.
extern const std::string_view page_template;

/// web/study.html in the same way, for studies.
extern const std::string_view study_template;

}  // namespace chasles
