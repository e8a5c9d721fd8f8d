# One shared library of all folders, and the command linked to it, from the objects of the static
# libraries: nothing is compiled twice. Included by the root CMakeLists.txt after the folders.
#
#   CHASLES_SHARED: `cmake --install` installs these instead of the static libraries (conda, vcpkg)
#   CHASLES_DEB: components for `make package` (tools/cmake/ChaslesDeb.cmake); `cmake --install` as ever
#
# Components: library-shared, development, command, python-module.
get_property(chasles_modules GLOBAL PROPERTY CHASLES_MODULES)

add_library(chasles_shared SHARED)
set(chasles_shared_links)
foreach(module ${chasles_modules})
  get_target_property(type ${module} TYPE)
  # In the order of the folders: of a template's copies the linker takes the first, and the folders
  # with little optimisation come last.
  if(type STREQUAL "STATIC_LIBRARY")
    target_sources(chasles_shared PRIVATE $<TARGET_OBJECTS:${module}>)
  endif()
  get_target_property(links ${module} INTERFACE_LINK_LIBRARIES)
  if(NOT links)  # base links nothing
    continue()
  endif()
  list(FILTER links EXCLUDE REGEX "chasles_")
  list(APPEND chasles_shared_links ${links})
endforeach()
list(REMOVE_DUPLICATES chasles_shared_links)
# Debian's CMake package of Ceres names its archive. The shared library is in the package too.
get_target_property(ceres Ceres::ceres IMPORTED_LOCATION_RELEASE)
find_library(CHASLES_CERES NAMES libceres.so)
if(ceres MATCHES "\\.a$" AND CHASLES_CERES)
  list(TRANSFORM chasles_shared_links REPLACE "Ceres::ceres" "${CHASLES_CERES}")
endif()
# Before 1.0 a minor version may change the interface: the name of the library has it (libchasles.so.0.1).
set(chasles_map ${PROJECT_BINARY_DIR}/shared/chasles.map)
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/chasles.map.in ${chasles_map} @ONLY)
set_target_properties(chasles_shared PROPERTIES OUTPUT_NAME chasles LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/shared
  LINK_DEPENDS ${chasles_map})
target_link_libraries(chasles_shared PRIVATE ${chasles_shared_links})
target_link_options(chasles_shared PRIVATE -Wl,--version-script=${chasles_map}
  -Wl,-z,defs -Wl,-z,relro -Wl,-z,now -Wl,--as-needed)

add_executable(chasles_linked $<TARGET_OBJECTS:chasles> $<TARGET_OBJECTS:chasles_app>)
get_target_property(links chasles_app INTERFACE_LINK_LIBRARIES)
list(FILTER links EXCLUDE REGEX "chasles(_|::)")
set_target_properties(chasles_linked PROPERTIES OUTPUT_NAME chasles LINKER_LANGUAGE CXX
  RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/shared)
target_link_libraries(chasles_linked PRIVATE chasles_shared ${links})
target_link_options(chasles_linked PRIVATE -Wl,-z,relro -Wl,-z,now -Wl,--as-needed)

# Man pages from --help and completions from the options: what the command that was just linked says.
find_package(Python3 REQUIRED COMPONENTS Interpreter)
set(chasles_documents ${PROJECT_BINARY_DIR}/shared/documents)
add_custom_command(OUTPUT ${chasles_documents}/stamp
  COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/tools/packaging/man_pages.py
    $<TARGET_FILE:chasles_linked> ${chasles_documents}/man
  COMMAND $<TARGET_FILE:chasles_linked> completion bash > ${chasles_documents}/chasles.bash
  COMMAND $<TARGET_FILE:chasles_linked> completion zsh > ${chasles_documents}/_chasles
  COMMAND ${CMAKE_COMMAND} -E touch ${chasles_documents}/stamp
  DEPENDS chasles_linked ${PROJECT_SOURCE_DIR}/tools/packaging/man_pages.py
  COMMENT "Man pages and completions" VERBATIM)
add_custom_target(chasles_documents ALL DEPENDS ${chasles_documents}/stamp)
# With CHASLES_DEB only `make package` needs them.
set_target_properties(chasles_shared chasles_linked chasles_documents PROPERTIES
  EXCLUDE_FROM_ALL ${CHASLES_DEB})

set(libdir ${CMAKE_INSTALL_LIBDIR})
set(unless_named)
if(CHASLES_DEB)
  set(libdir lib/${CMAKE_LIBRARY_ARCHITECTURE})
  set(unless_named EXCLUDE_FROM_ALL)
else()
  file(RELATIVE_PATH to_libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
  set_target_properties(chasles_linked PROPERTIES INSTALL_RPATH $ORIGIN/${to_libraries})
  set_target_properties(chasles_shared PROPERTIES INSTALL_RPATH $ORIGIN)
endif()
install(TARGETS chasles_shared LIBRARY DESTINATION ${libdir} COMPONENT library-shared
  NAMELINK_COMPONENT development ${unless_named})
install(TARGETS chasles_linked RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command
  ${unless_named})
set(man_pages ${chasles_documents}/man)
if(CHASLES_DEB)
  set(man_pages ${PROJECT_BINARY_DIR}/deb/man)  # compressed
endif()
install(DIRECTORY ${man_pages}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/man/man1
  COMPONENT command ${unless_named} FILES_MATCHING PATTERN "*.1*")
install(FILES ${chasles_documents}/chasles.bash RENAME chasles
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT command ${unless_named})
# Debian's zsh looks into a folder of its own.
set(zsh_folder zsh/site-functions)
if(CHASLES_DEB)
  set(zsh_folder zsh/vendor-completions)
endif()
install(FILES ${chasles_documents}/_chasles DESTINATION ${CMAKE_INSTALL_DATADIR}/${zsh_folder}
  COMPONENT command ${unless_named})

# What find_package(chasles) and pkg-config read: the targets of the static package, each of which
# is the shared library.
set(chasles_folders ${chasles_modules})
list(TRANSFORM chasles_folders REPLACE "^chasles_" "")
set(package_dir ${libdir}/cmake/chasles)
set(LIBRARY_DIR ${libdir})
file(RELATIVE_PATH TO_PREFIX /${package_dir} /)
file(RELATIVE_PATH PC_TO_PREFIX /${libdir}/pkgconfig /)
string(REGEX REPLACE "/$" "" TO_PREFIX ${TO_PREFIX})
string(REGEX REPLACE "/$" "" PC_TO_PREFIX ${PC_TO_PREFIX})
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/chaslesSharedConfig.cmake.in
  ${PROJECT_BINARY_DIR}/shared/chaslesConfig.cmake @ONLY)
configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/chasles.pc.in ${PROJECT_BINARY_DIR}/shared/chasles.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/shared/chaslesConfig.cmake
  ${PROJECT_BINARY_DIR}/chaslesConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT development ${unless_named})
install(FILES ${PROJECT_BINARY_DIR}/shared/chasles.pc DESTINATION ${libdir}/pkgconfig
  COMPONENT development ${unless_named})
chasles_install_headers(development ${unless_named})
