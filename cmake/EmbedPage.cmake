# The report's pages as one string each in the program: web/page.html (runs) and web/study.html
# (studies) with the style sheets and the scripts put in. Included by src/chasles/CMakeLists.txt it
# defines chasles_embed_page(TARGET); run as a script (cmake -P) it writes the source file of PAGE.

# The scripts share one scope, the last one starts the page.
set(common_scripts data format store theme canvas plot_draw plot)
set(page_scripts ${common_scripts} run_colours plots map_draw map map_input tables overview_table
  overview main)
set(study_scripts ${common_scripts} map_draw map map_input study_colours study_tables study_plots
  study_boxes study_map study)
set(page_styles page)
set(study_styles page study)

if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${WEB}/${PAGE}.html page)
  set(css "")
  foreach(style IN LISTS ${PAGE}_styles)
    file(READ ${WEB}/${style}.css text)
    string(APPEND css "${text}")
  endforeach()
  set(js "")
  foreach(script IN LISTS ${PAGE}_scripts)
    file(READ ${WEB}/js/${script}.js text)
    string(APPEND js "${text}\n")
  endforeach()
  string(REPLACE "@PAGE_CSS@" "${css}" page "${page}")
  string(REPLACE "@PAGE_JS@" "${js}" page "${page}")
  file(WRITE ${OUT} "#include <chasles/report/page_template.hpp>\n\nnamespace chasles {\n\n"
    "const std::string_view ${PAGE}_template = R\"chasles_page(${page})chasles_page\";\n\n"
    "}  // namespace chasles\n")
  return()
endif()

set(page_embed_script ${CMAKE_CURRENT_LIST_FILE})

# chasles_embed_page(TARGET): adds the pages' sources to the target; written anew when web/ changes.
function(chasles_embed_page target)
  set(web ${PROJECT_SOURCE_DIR}/web)
  foreach(page page study)
    set(out ${CMAKE_CURRENT_BINARY_DIR}/${page}_template.cpp)
    list(TRANSFORM ${page}_scripts REPLACE "(.+)" "${web}/js/\\1.js" OUTPUT_VARIABLE scripts)
    list(TRANSFORM ${page}_styles REPLACE "(.+)" "${web}/\\1.css" OUTPUT_VARIABLE styles)
    add_custom_command(OUTPUT ${out}
      COMMAND ${CMAKE_COMMAND} -DWEB=${web} -DPAGE=${page} -DOUT=${out} -P ${page_embed_script}
      DEPENDS ${page_embed_script} ${web}/${page}.html ${styles} ${scripts}
      COMMENT "Embedding the report's ${page}" VERBATIM)
    target_sources(${target} PRIVATE ${out})
  endforeach()
endfunction()
