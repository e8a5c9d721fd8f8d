# The report's pages as one string each in the program: src/web/page.html (runs), src/web/study.html (studies),
# src/web/map.html (saved maps), src/web/batch.html (batches of recordings) and src/web/calibration.html
# (calibrations), each built by Vite into one file
# with its style sheets and scripts put in. Included by src/chasles/CMakeLists.txt it defines chasles_embed_page(TARGET); run as a script (cmake -P) it writes
# the source file of PAGE. Nothing is downloaded here: `make deps` has put the packages into
# src/web/node_modules. A source tarball has the built pages in src/web/dist (tools/source-tarball), which
# are taken where there is no src/web/node_modules.
if(CMAKE_SCRIPT_MODE_FILE)
  file(READ ${HTML} page)
  file(WRITE ${OUT} "#include <chasles/report/page_template.hpp>\n\n"
    "#pragma GCC diagnostic ignored \"-Woverlength-strings\"\n\nnamespace chasles {\n\n"
    "const std::string_view ${PAGE}_template = R\"chasles_page(${page})chasles_page\";\n\n"
    "}  // namespace chasles\n")
  return()
endif()

set(page_embed_script ${CMAKE_CURRENT_LIST_FILE})

# chasles_embed_html(TARGET PAGE HTML): adds the source of one built page to the target.
function(chasles_embed_html target page html)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${page}_template.cpp)
  add_custom_command(OUTPUT ${out}
    COMMAND ${CMAKE_COMMAND} -DHTML=${html} -DPAGE=${page} -DOUT=${out} -P ${page_embed_script}
    DEPENDS ${page_embed_script} ${html} COMMENT "Embedding the report's ${page}" VERBATIM)
  target_sources(${target} PRIVATE ${out})
endfunction()

# chasles_embed_page(TARGET): adds the pages' sources to the target; written anew when src/web/ changes.
function(chasles_embed_page target)
  set(web ${PROJECT_SOURCE_DIR}/src/web)
  if(EXISTS ${web}/dist/page.html AND NOT EXISTS ${web}/node_modules/vite)
    foreach(page page study map batch calibration)
      chasles_embed_html(${target} ${page} ${web}/dist/${page}.html)
    endforeach()
    return()
  endif()
  find_program(CHASLES_NODE NAMES node nodejs DOC "Node.js, which builds the report's pages")
  if(NOT CHASLES_NODE OR NOT EXISTS ${web}/node_modules/vite)
    message(FATAL_ERROR "The report's pages need Node.js 18 or later and the packages of "
      "src/web/package-lock.json: run `make deps`, or install nodejs and npm and run `npm ci` in ${web}")
  endif()
  file(GLOB sources CONFIGURE_DEPENDS ${web}/src/*.ts ${web}/styles/*.css)
  list(APPEND sources ${web}/tsconfig.json ${web}/vite.config.ts ${web}/package-lock.json)
  # Vite takes the types for granted: they are checked with the tests.
  if(CHASLES_TESTS)
    set(checked ${CMAKE_CURRENT_BINARY_DIR}/web/types.stamp)
    add_custom_command(OUTPUT ${checked}
      COMMAND ${CHASLES_NODE} ${web}/node_modules/typescript/bin/tsc --noEmit --project ${web}
      COMMAND ${CMAKE_COMMAND} -E touch ${checked}
      DEPENDS ${sources} COMMENT "Checking the types of the report's pages" VERBATIM)
    add_custom_target(chasles_web_types ALL DEPENDS ${checked})
  endif()
  foreach(page page study map batch calibration)
    set(html ${CMAKE_CURRENT_BINARY_DIR}/web/${page}.html)
    add_custom_command(OUTPUT ${html}
      COMMAND ${CMAKE_COMMAND} -E env PAGE=${page} OUT=${CMAKE_CURRENT_BINARY_DIR}/web
        ${CHASLES_NODE} ${web}/node_modules/vite/bin/vite.js build --config ${web}/vite.config.ts
      DEPENDS ${sources} ${web}/${page}.html WORKING_DIRECTORY ${web}
      COMMENT "Building the report's ${page}" VERBATIM)
    chasles_embed_html(${target} ${page} ${html})
  endforeach()
endfunction()
