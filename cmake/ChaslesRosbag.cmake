# ROS 1 bags by librosbag-storage, where it is found: rosbag::storage, an empty target where it is not.
set(CHASLES_ROSBAG AUTO CACHE STRING "ROS 1 bags by librosbag-storage: AUTO (where it is found), ON, OFF")
if(NOT TARGET rosbag::storage)
  add_library(rosbag::storage INTERFACE IMPORTED)
  if(NOT CHASLES_ROSBAG STREQUAL "OFF")
    find_path(ROSBAG_INCLUDE_DIR rosbag/bag.h)
    set(rosbag_includes ${ROSBAG_INCLUDE_DIR})
    # Its headers include those of a loader of plugins, whose packages have a folder each.
    foreach(header pluginlib/class_loader class_loader/class_loader rcutils/logging_macros
        rcpputils/shared_library ament_index_cpp/get_package_prefix)
      get_filename_component(package ${header} DIRECTORY)
      find_path(ROSBAG_${package}_INCLUDE_DIR NAMES ${header}.hpp ${header}.h PATH_SUFFIXES ${package})
      list(APPEND rosbag_includes ${ROSBAG_${package}_INCLUDE_DIR})
    endforeach()
    set(rosbag_libraries "")
    foreach(library rosbag_storage roscpp_serialization rostime cpp_common console_bridge
        class_loader rcutils rcpputils ament_index_cpp tinyxml2)
      find_library(ROSBAG_${library}_LIBRARY ${library})
      list(APPEND rosbag_libraries ${ROSBAG_${library}_LIBRARY})
    endforeach()
    if(NOT "${rosbag_includes};${rosbag_libraries}" MATCHES "NOTFOUND")
      set_target_properties(rosbag::storage PROPERTIES
        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${rosbag_includes}"
        INTERFACE_INCLUDE_DIRECTORIES "${rosbag_includes}"
        INTERFACE_LINK_LIBRARIES "${rosbag_libraries}"
        INTERFACE_COMPILE_DEFINITIONS CHASLES_HAS_ROSBAG)
    elseif(CHASLES_ROSBAG STREQUAL "ON")
      message(FATAL_ERROR
        "librosbag-storage was not found: librosbag-storage-dev on Debian and Ubuntu")
    endif()
  endif()
endif()
