# Debian packages from the objects of this build: `make package` runs CPack over these components.
# Included by tools/cmake/ChaslesInstall.cmake with CHASLES_DEB.
#
#   libchasles0.1     the shared library; the number is that of its SONAME
#   libchasles-dev    headers, find_package(chasles), pkg-config
#   chasles           the command with its man pages and completions
#   python3-chasles   the module for the distribution's python3
if(NOT TARGET chasles_python)
  message(FATAL_ERROR "CHASLES_DEB needs CHASLES_PYTHON=ON: python3-chasles is one of the packages")
endif()
set(soversion ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(package_of_library-shared libchasles${soversion})
set(package_of_development libchasles-dev)
set(package_of_command chasles)
set(package_of_python-module python3-chasles)

# Who answers for the packages: Debian's variables of the environment, as for its own tools.
set(maintainer "The Chasles authors <maintainers@chasles.invalid>")
if(DEFINED ENV{DEBEMAIL})
  set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()

# The packages of another release of the distribution are other packages, and older or newer ones.
file(STRINGS /etc/os-release distribution REGEX "^(ID|VERSION_ID)=")
string(REGEX REPLACE ".*[^_]ID=\"?([a-z]+).*" "\\1" distribution_name ";${distribution}")
string(REGEX REPLACE ".*VERSION_ID=\"?([0-9.]+).*" "\\1" distribution_version ";${distribution}")
set(release 1~${distribution_name}${distribution_version})
set(CHASLES_DEB_VERSION ${PROJECT_VERSION}-${release})

# Documents: copyright, changelogs, the bill of materials. Their times are those of SOURCE_DATE_EPOCH,
# which tools/package takes from the commit.
set(documents ${PROJECT_BINARY_DIR}/deb)
set(tools ${PROJECT_SOURCE_DIR}/tools/packaging)
add_custom_command(OUTPUT ${documents}/stamp
  COMMAND ${CMAKE_COMMAND} -E make_directory ${documents}
  COMMAND ${Python3_EXECUTABLE} ${tools}/deb/copyright.py ${documents}/copyright
  COMMAND ${Python3_EXECUTABLE} ${tools}/deb/changelogs.py ${CHASLES_DEB_VERSION} "${maintainer}"
    ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${documents}
  COMMAND ${Python3_EXECUTABLE} ${tools}/deb/compress.py ${chasles_documents}/man ${documents}/man
  COMMAND ${Python3_EXECUTABLE} ${tools}/sbom.py --version ${PROJECT_VERSION}
    --loaded ${CHASLES_MATIO_FILE} --output ${documents}/chasles.spdx.json
    $<TARGET_FILE:chasles_shared> $<TARGET_FILE:chasles_linked> $<TARGET_FILE:chasles_python>
    $<TARGET_FILE:chasles_python_lab>
  COMMAND ${CMAKE_COMMAND} -E touch ${documents}/stamp
  DEPENDS chasles_documents chasles_shared chasles_linked chasles_python chasles_python_lab ${tools}/sbom.py
    ${tools}/components.py ${tools}/components.json ${tools}/deb/copyright.py ${tools}/deb/changelogs.py
    ${tools}/deb/compress.py ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${PROJECT_SOURCE_DIR}/src/web/package-lock.json
  COMMENT "Documents of the Debian packages" VERBATIM)
add_custom_target(chasles_deb DEPENDS ${documents}/stamp)

set(CPACK_COMPONENTS_ALL library-shared development command python-module)
foreach(component ${CPACK_COMPONENTS_ALL})
  set(package ${package_of_${component}})
  set(doc ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES ${documents}/copyright ${documents}/changelog.Debian.gz ${documents}/changelog.gz
    DESTINATION ${doc} COMPONENT ${component} EXCLUDE_FROM_ALL)
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${package})
  if(EXISTS ${tools}/deb/${component}.overrides)
    install(FILES ${tools}/deb/${component}.overrides RENAME ${package}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides COMPONENT ${component} EXCLUDE_FROM_ALL)
  endif()
endforeach()
foreach(component library-shared python-module)
  install(FILES ${documents}/chasles.spdx.json COMPONENT ${component} EXCLUDE_FROM_ALL
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package_of_${component}})
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME chasles)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT ${maintainer})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${release})
set(CPACK_DEBIAN_PACKAGE_SOURCE chasles)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
  GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# Before 1.0 any version may change any class: even with the same SONAME, what was built against
# 0.1.0-1 may need exactly that. So programs depend on libchasles0.1 (= version), and there is no
# symbols file: it would promise that an older library with the same names is enough, and C++ has
# changes of a class that no name shows.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/shared)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
set(same "(= ${CHASLES_DEB_VERSION})")
set(library ${package_of_library-shared})
# libmatio is opened when a .mat file is read, FFmpeg's libraries when a video is: dpkg-shlibdeps cannot see
# them.
set(opened_packages)
foreach(file ${CHASLES_MATIO_FILE} ${CHASLES_LIBAV_FILES})
  execute_process(COMMAND dpkg-query --search */${file} OUTPUT_VARIABLE opened_package
    COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX REPLACE ":.*" "" opened_package "${opened_package}")
  list(APPEND opened_packages ${opened_package})
endforeach()
list(JOIN opened_packages ", " opened_packages)

set(CPACK_DEBIAN_LIBRARY-SHARED_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBRARY-SHARED_PACKAGE_RECOMMENDS "${opened_packages}")
set(CPACK_DEBIAN_LIBRARY-SHARED_PACKAGE_CONTROL_EXTRA ${tools}/deb/triggers)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "${library} ${same}, libeigen3-dev (>= 3.4), nlohmann-json3-dev")
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COMMAND_PACKAGE_DEPENDS "${library} ${same}")
set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS "python3-chasles")
set(CPACK_DEBIAN_PYTHON-MODULE_PACKAGE_SECTION python)
math(EXPR next_minor "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON-MODULE_PACKAGE_DEPENDS
  "python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next_minor}), python3-numpy")
set(CPACK_DEBIAN_PYTHON-MODULE_PACKAGE_RECOMMENDS "${opened_packages}")
set(CPACK_DEBIAN_PYTHON-MODULE_PACKAGE_CONTROL_EXTRA ${tools}/deb/postinst ${tools}/deb/prerm)

# CPack would put one summary before all of these, whose first lines are summaries.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")
set(about "Chasles estimates the trajectory of a camera with an IMU, or of a stereo
camera with a velocity sensor, and a map of landmarks: by an extended Kalman
filter, a sliding window or batch estimation, each with covariances. It reads
EuRoC, KITTI, ROS bags and other recordings.")
set(CPACK_COMPONENT_LIBRARY-SHARED_DESCRIPTION "visual-inertial SLAM: shared library
${about}
.
This package has the shared library.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "visual-inertial SLAM: files for development
${about}
.
This package has the headers and what CMake and pkg-config need to link the
library.")
set(CPACK_COMPONENT_COMMAND_DESCRIPTION "visual-inertial SLAM: command
${about}
.
This package has the command chasles. It runs recordings, simulates them,
evaluates estimates and writes pages that show them.")
set(CPACK_COMPONENT_PYTHON-MODULE_DESCRIPTION "visual-inertial SLAM: Python module
${about}
.
This package has the module for Python 3, with numpy arrays.")
include(CPack)
