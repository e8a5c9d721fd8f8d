# The installed package: libraries chasles::FOLDER, their headers, and what find_package(chasles)
# reads. tests/consumer proves it. (The command installs itself.) Included by the root CMakeLists.txt after the folders.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/chasles)
get_property(chasles_modules GLOBAL PROPERTY CHASLES_MODULES)

# chasles_install_headers(COMPONENT [EXCLUDE_FROM_ALL])
function(chasles_install_headers component)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/chasles DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
    COMPONENT ${component} ${ARGN} FILES_MATCHING PATTERN "*.hpp"
    # What only the tests include.
    PATTERN "testing.hpp" EXCLUDE PATTERN "*_testing.hpp" EXCLUDE PATTERN "test_*.hpp" EXCLUDE
    PATTERN "*_test.hpp" EXCLUDE PATTERN "testdata" EXCLUDE
    # What only one folder's sources include, among it all that needs other headers than Eigen's and
    # nlohmann's.
    PATTERN "series.hpp" EXCLUDE PATTERN "*_detail.hpp" EXCLUDE PATTERN "map_bytes.hpp" EXCLUDE
    PATTERN "matio_library.hpp" EXCLUDE PATTERN "libav.hpp" EXCLUDE PATTERN "container.hpp" EXCLUDE
    PATTERN "jpeg_error.hpp" EXCLUDE
    PATTERN "time_order.hpp" EXCLUDE)
endfunction()

# Static libraries, unless the shared one takes their place (tools/cmake/ChaslesShared.cmake).
set(unless_named)
if(CHASLES_SHARED)
  set(unless_named EXCLUDE_FROM_ALL)
endif()
install(TARGETS ${chasles_modules} EXPORT chaslesTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library ${unless_named})
install(EXPORT chaslesTargets NAMESPACE chasles:: DESTINATION ${package_dir} COMPONENT library
  ${unless_named})
chasles_install_headers(library ${unless_named})

configure_package_config_file(${PROJECT_SOURCE_DIR}/tools/cmake/chaslesConfig.cmake.in
  ${PROJECT_BINARY_DIR}/chaslesConfig.cmake INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/chaslesConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/chaslesConfig.cmake
  ${PROJECT_BINARY_DIR}/chaslesConfigVersion.cmake
  ${PROJECT_SOURCE_DIR}/tools/cmake/ChaslesLibav.cmake
  ${PROJECT_SOURCE_DIR}/tools/cmake/ChaslesMatio.cmake ${PROJECT_SOURCE_DIR}/tools/cmake/ChaslesOpenCV.cmake
  DESTINATION ${package_dir} COMPONENT library ${unless_named})
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT library)

if(CHASLES_SHARED OR CHASLES_DEB)
  include(ChaslesShared)
endif()
if(CHASLES_DEB)
  include(ChaslesDeb)
endif()
