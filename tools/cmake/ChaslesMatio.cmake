# libmatio: matio::at_run_time has its headers and the name of the file that the program loads when it reads a .mat
# file (src/chasles/codec/matio_library.hpp); PkgConfig::matio, which tests use, links it.
if(NOT TARGET PkgConfig::matio)
  pkg_check_modules(matio REQUIRED QUIET IMPORTED_TARGET matio)
endif()
if(NOT TARGET matio::at_run_time)
  find_library(MATIO_LIBRARY matio HINTS ${matio_LIBRARY_DIRS})
  file(REAL_PATH ${MATIO_LIBRARY} matio_file)
  get_filename_component(matio_file ${matio_file} NAME)
  if(NOT matio_file MATCHES "^libmatio\\.so\\.[0-9]+")
    message(FATAL_ERROR "libmatio.so is ${matio_file}, expected a link to libmatio.so.NUMBER")
  endif()
  set(CHASLES_MATIO_FILE ${CMAKE_MATCH_0})
  add_library(matio::at_run_time INTERFACE IMPORTED)
  set_target_properties(matio::at_run_time PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${matio_INCLUDE_DIRS}"
    INTERFACE_LINK_LIBRARIES "${CMAKE_DL_LIBS}")
endif()
