# The installed package: libraries chasles::FOLDER, their headers, and what find_package(chasles)
# reads. tests/consumer proves it. (The command installs itself.) Included by the root CMakeLists.txt after the folders.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/chasles)
get_property(chasles_modules GLOBAL PROPERTY CHASLES_MODULES)

install(TARGETS ${chasles_modules} EXPORT chaslesTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(EXPORT chaslesTargets NAMESPACE chasles:: DESTINATION ${package_dir} COMPONENT library)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/chasles DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT library FILES_MATCHING PATTERN "*.hpp"
  # What only the tests include.
  PATTERN "testing.hpp" EXCLUDE PATTERN "*_testing.hpp" EXCLUDE PATTERN "test_*.hpp" EXCLUDE
  PATTERN "*_test.hpp" EXCLUDE
  # What only one folder's sources include.
  PATTERN "series.hpp" EXCLUDE PATTERN "*_detail.hpp" EXCLUDE)

configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/chaslesConfig.cmake.in
  ${PROJECT_BINARY_DIR}/chaslesConfig.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/chaslesConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/chaslesConfig.cmake
  ${PROJECT_BINARY_DIR}/chaslesConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/cmake/ChaslesMatio.cmake ${PROJECT_SOURCE_DIR}/cmake/ChaslesOpenCV.cmake
  DESTINATION ${package_dir} COMPONENT library)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)
