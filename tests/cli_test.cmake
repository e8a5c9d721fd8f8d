# The command, end to end, and its settings parser.
file(GLOB cli_tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/cli_*test.cpp)
chasles_test(cli_test SOURCES ${cli_tests}
    ${PROJECT_SOURCE_DIR}/src/chasles/live/testing_test.cpp
  LINKS chasles_app nlohmann_json::nlohmann_json fmt::fmt opencv::imgproc)
chasles_opencv_codecs(cli_test)
add_dependencies(cli_test chasles)
target_compile_definitions(cli_test PRIVATE CHASLES_BINARY="$<TARGET_FILE:chasles>"
  CHASLES_NODE="${CHASLES_NODE}")
