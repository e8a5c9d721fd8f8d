# The libraries of FFmpeg: libav::at_run_time has their headers and the names of the files that the program loads when
# it reads a video (src/chasles/video/libav.hpp); PkgConfig::libav, which tests use, links them.
if(NOT TARGET PkgConfig::libav)
  pkg_check_modules(libav REQUIRED QUIET IMPORTED_TARGET libavformat libavcodec libavutil)
endif()
if(NOT TARGET libav::at_run_time)
  set(CHASLES_LIBAV_FILES)
  foreach(part avutil avcodec avformat)  # in the order in which they need one another
    find_library(LIBAV_${part} ${part} HINTS ${libav_LIBRARY_DIRS})
    file(REAL_PATH ${LIBAV_${part}} libav_file)
    get_filename_component(libav_file ${libav_file} NAME)
    if(NOT libav_file MATCHES "^lib${part}\\.so\\.[0-9]+")
      message(FATAL_ERROR "lib${part}.so is ${libav_file}, expected a link to lib${part}.so.NUMBER")
    endif()
    list(APPEND CHASLES_LIBAV_FILES ${CMAKE_MATCH_0})
  endforeach()
  add_library(libav::at_run_time INTERFACE IMPORTED)
  set_target_properties(libav::at_run_time PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${libav_INCLUDE_DIRS}"
    INTERFACE_LINK_LIBRARIES "${CMAKE_DL_LIBS}")
endif()
