# The command, end to end, and its settings parser.
chasles_test(cli_test SOURCES cli_test.cpp cli_run_test.cpp cli_settings_test.cpp
  LINKS chasles_app nlohmann_json::nlohmann_json fmt::fmt)
add_dependencies(cli_test chasles)
target_compile_definitions(cli_test PRIVATE CHASLES_BINARY="$<TARGET_FILE:chasles>")
