# OpenCV's modules one by one: Debian's OpenCVConfig.cmake comes with libopencv-dev, which brings 170 packages, VTK and Qt
# among them, of which nothing is used here. The shared libraries know their own dependencies.
#
#   opencv::core opencv::imgproc opencv::imgcodecs opencv::video
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
foreach(module core imgproc imgcodecs video)
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
