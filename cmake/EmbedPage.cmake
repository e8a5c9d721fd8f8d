# The report's page as one string in the program: web/page.html with the style sheet and the scripts
# put in. Included by src/chasles/CMakeLists.txt it defines chasles_embed_page(TARGET); run as a
# script (cmake -P) it writes the source file.

# The scripts share one scope, main.js starts the page: so it comes last.
set(page_scripts data format store theme canvas plot_draw plot plots map_draw map map_input tables main)

if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${WEB}/page.html page)
  file(READ ${WEB}/page.css css)
  set(js "")
  foreach(script IN LISTS page_scripts)
    file(READ ${WEB}/js/${script}.js text)
    string(APPEND js "${text}\n")
  endforeach()
  string(REPLACE "@PAGE_CSS@" "${css}" page "${page}")
  string(REPLACE "@PAGE_JS@" "${js}" page "${page}")
  file(WRITE ${OUT} "#include <chasles/report/page_template.hpp>\n\nnamespace chasles {\n\n"
    "const std::string_view page_template = R\"chasles_page(${page})chasles_page\";\n\n"
    "}  // namespace chasles\n")
  return()
endif()

set(page_embed_script ${CMAKE_CURRENT_LIST_FILE})

# chasles_embed_page(TARGET): adds the page's source to the target; written anew when web/ changes.
function(chasles_embed_page target)
  set(web ${PROJECT_SOURCE_DIR}/web)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/page_template.cpp)
  list(TRANSFORM page_scripts REPLACE "(.+)" "${web}/js/\\1.js" OUTPUT_VARIABLE scripts)
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DWEB=${web} -DOUT=${out} -P ${page_embed_script}
    DEPENDS ${page_embed_script} ${web}/page.html ${web}/page.css ${scripts}
    COMMENT "Embedding the report's page" VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()
