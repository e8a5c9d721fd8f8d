# OpenCV's modules one by one. The program uses ORB alone (loop/); tests and benchmarks compare with the
# others. Debian's OpenCVConfig.cmake comes with libopencv-dev, which brings 170 packages, VTK among them, of which
# nothing is used here. The shared libraries know their own dependencies.
#
#   opencv::core opencv::features2d, for tests opencv::imgproc opencv::imgcodecs, for benchmarks opencv::video
#
# Tests load imgcodecs when they need it (src/chasles/base/opencv_codecs_testing.hpp): chasles_opencv_codecs(TARGET).
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(opencv_modules core features2d)
if(CHASLES_TESTS OR CHASLES_BENCH OR CHASLES_FUZZ)
  list(APPEND opencv_modules imgproc imgcodecs)
endif()
if(CHASLES_BENCH)
  list(APPEND opencv_modules video)
endif()
foreach(module ${opencv_modules})
  find_library(OPENCV_${module}_LIBRARY opencv_${module})
  if(NOT OPENCV_INCLUDE_DIR OR NOT OPENCV_${module}_LIBRARY)
    message(FATAL_ERROR "OpenCV's ${module} was not found: libopencv-${module}-dev on Debian and Ubuntu (make deps)")
  endif()
  if(NOT TARGET opencv::${module})
    add_library(opencv::${module} UNKNOWN IMPORTED)
    set_target_properties(opencv::${module} PROPERTIES
      IMPORTED_LOCATION ${OPENCV_${module}_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
  endif()
endforeach()

# The target's programs find OpenCV's readers and writers of images beside them.
function(chasles_opencv_codecs target)
  if(NOT TARGET opencv_codecs)
    add_library(opencv_codecs MODULE ${PROJECT_SOURCE_DIR}/tests/opencv_codecs.cpp)
    target_include_directories(opencv_codecs PRIVATE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(opencv_codecs PRIVATE chasles_options opencv::core opencv::imgcodecs)
    set_target_properties(opencv_codecs PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
  endif()
  add_dependencies(${target} opencv_codecs)
  target_link_libraries(${target} PRIVATE opencv::core ${CMAKE_DL_LIBS})
endfunction()
