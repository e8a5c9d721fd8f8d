# OpenCV's modules one by one, for tests and benchmarks, which compare with it; the program does without. Debian's
# OpenCVConfig.cmake comes with libopencv-dev, which brings 170 packages, VTK and Qt among them, of which nothing is
# used here. The shared libraries know their own dependencies.
#
#   opencv::core opencv::imgproc opencv::imgcodecs, and for benchmarks opencv::video
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(opencv_modules core imgproc imgcodecs)
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
