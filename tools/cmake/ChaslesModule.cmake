# What every target of the house is compiled with.
add_library(chasles_options INTERFACE)
target_compile_options(chasles_options INTERFACE
  -Wall -Wextra -Wpedantic -Wnon-virtual-dtor -Wconversion -Wno-sign-conversion
  -Wcast-align -Woverloaded-virtual -Wdouble-promotion -Wimplicit-fallthrough
  $<$<BOOL:${CHASLES_WERROR}>:-Werror>
  # In a unit it also reports the names of other files: Clang's in every folder, GCC's in tests, whose
  # files each have names of their own for the same things. The preset dev has no units.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<NOT:$<BOOL:$<TARGET_PROPERTY:CHASLES_TEST_UNIT>>>>:-Wshadow>
  # GCC looks for garbage of its own from 1 GB on, not from 128 MB: a tenth less time, a quarter more
  # memory where Eigen is heavy (0.9 to 1.1 GB).
  $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1048576>
  # From version 13 on GCC takes what is inside Eigen's decompositions and std::variant for that.
  $<$<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,13>>:-Wno-maybe-uninitialized>
  # Position independent code as quick as a program's own: nothing takes another function's place.
  $<$<CXX_COMPILER_ID:GNU>:-fno-semantic-interposition>
  # The same source gives the same bytes: no contraction of a*b+c into one rounding, which would
  # depend on the target and on what the optimiser sees.
  -ffp-contract=off)

# Most of a file's compiling is reading headers: where files of a folder are compiled several at a time,
# a build from nothing takes about half the time, one after a change a little more. Names in anonymous
# namespaces must differ within such a folder. Large files of Eigen's expressions are compiled ALONE:
# GCC keeps all typedefs of double in one list and searches it for every type of an expression, so
# that they take longer together. Clang has no such list: it takes folders of up to 16 sources whole and
# larger ones in halves, which memory allows, and two thirds of g++'s time.
option(CHASLES_UNITY "Compile several sources of a folder at a time" ON)
function(chasles_unity target sources)
  cmake_parse_arguments(ARG "" "" "ALONE" ${ARGN})
  get_target_property(of_target ${target} SOURCES)
  set(batch ${sources})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    set(ARG_ALONE)
    list(LENGTH of_target batch)
    if(batch GREATER 16)
      math(EXPR batch "(${batch} + 1) / 2")
    endif()
  endif()
  set_target_properties(${target} PROPERTIES
    UNITY_BUILD ${CHASLES_UNITY} UNITY_BUILD_BATCH_SIZE ${batch})
  foreach(name ${ARG_ALONE})
    set(file ${of_target})
    list(FILTER file INCLUDE REGEX "/${name}\\.cpp$")
    if(NOT file)
      message(FATAL_ERROR "${target} has no ${name}.cpp, which is to be compiled alone")
    endif()
    set_source_files_properties(${file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
endfunction()

# What is in no loop that counts, and large: with -O1 g++ takes a quarter less time than with -O3, with
# -O0 Clang takes half. Not for folders that share much with the filter: of a template's copies the linker
# takes the first one that it meets, and with codec/, recording/, run_folder/, eval/ and lab/ so too a
# stereo-velocity run took seven times as long.
function(chasles_cold target)
  target_compile_options(${target} PRIVATE
    $<$<CONFIG:Release,RelWithDebInfo>:$<IF:$<CXX_COMPILER_ID:Clang>,-O0,-O1>>)
endfunction()

# chasles_module(NAME [COLD | HOT] [UNITY sources [ALONE name...]] [TESTS_UNITY sources]
#                [USES folder...] [LINKS library...] [PRIVATE library...] [TESTS_USE folder...])
#
# One folder of src/chasles: all *.cpp below it are the library chasles_NAME, all *_test.cpp one test
# program. USES are the arrows to other folders, LINKS the outside libraries that its headers need,
# PRIVATE those that only its sources need, TESTS_USE the folders that its tests alone use. UNITY: g++ compiles so many at a time, but
# for those ALONE; TESTS_UNITY: so many tests at a time (8); COLD: see above; HOT: loops over pixels, with
# -O3 where a preset asks for less.
function(chasles_module name)
  cmake_parse_arguments(ARG "COLD;HOT" "UNITY;TESTS_UNITY" "ALONE;USES;LINKS;PRIVATE;TESTS_USE" ${ARGN})
  if(CHASLES_FOLDERS AND NOT name IN_LIST CHASLES_FOLDERS)
    return()
  endif()
  set(dir ${PROJECT_SOURCE_DIR}/src/chasles/${name})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${dir}/*.cpp)
  file(GLOB_RECURSE tests CONFIGURE_DEPENDS ${dir}/*_test.cpp)
  list(REMOVE_ITEM sources ${tests})
  list(TRANSFORM ARG_USES PREPEND chasles_ OUTPUT_VARIABLE uses)
  if(sources)
    add_library(chasles_${name} STATIC ${sources})
    set(scope PUBLIC)
    if(ARG_UNITY)
      chasles_unity(chasles_${name} ${ARG_UNITY} ALONE ${ARG_ALONE})
    endif()
    if(ARG_COLD)
      chasles_cold(chasles_${name})
    elseif(ARG_HOT)
      target_compile_options(chasles_${name} PRIVATE $<$<CONFIG:Release>:-O3>)
    endif()
    target_link_libraries(chasles_${name} PRIVATE $<BUILD_INTERFACE:chasles_options>)
  else()
    add_library(chasles_${name} INTERFACE)
    set(scope INTERFACE)
  endif()
  add_library(chasles::${name} ALIAS chasles_${name})
  set_property(GLOBAL APPEND PROPERTY CHASLES_MODULES chasles_${name})
  set_target_properties(chasles_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(chasles_${name} ${scope} cxx_std_20)
  target_include_directories(chasles_${name} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(chasles_${name} ${scope} ${uses} ${ARG_LINKS})
  if(ARG_PRIVATE AND sources)
    target_link_libraries(chasles_${name} PRIVATE ${ARG_PRIVATE})
  endif()
  if(CHASLES_TESTS AND tests)
    list(TRANSFORM ARG_TESTS_USE PREPEND chasles_ OUTPUT_VARIABLE tests_use)
    chasles_test(${name}_test UNITY ${ARG_TESTS_UNITY} SOURCES ${tests}
      LINKS chasles_${name} ${tests_use})
  endif()
endfunction()

# chasles_test(NAME [UNITY sources] SOURCES file... LINKS library...): a GoogleTest program whose tests
# CTest lists. Its sources are compiled 8 or UNITY at a time and with -O1: the time of a test is spent in
# the libraries, the time of its compiling in the headers (docs/build.md).
function(chasles_test name)
  cmake_parse_arguments(ARG "" "UNITY" "SOURCES;LINKS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  if(NOT ARG_UNITY)
    set(ARG_UNITY 8)
  endif()
  chasles_unity(${name} ${ARG_UNITY})
  set_target_properties(${name} PROPERTIES CHASLES_TEST_UNIT ${CHASLES_UNITY})
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release,RelWithDebInfo>:-O1>)
  cmake_language(EVAL CODE "cmake_language(DEFER DIRECTORY [[${PROJECT_SOURCE_DIR}]]
    CALL chasles_library_copies_first ${name} ${ARG_LINKS})")
  target_link_libraries(${name} PRIVATE chasles_options ${ARG_LINKS} GTest::gtest_main)
  chasles_source_dir(${name} ${ARG_SOURCES})
  # Tests of tests/slow_tests.txt have the label slow, all others quick: `make check` runs the quick ones.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/slow_tests.txt)
  file(STRINGS ${PROJECT_SOURCE_DIR}/tests/slow_tests.txt slow REGEX "^${name} ")
  list(TRANSFORM slow REPLACE "^${name} " "")
  list(JOIN slow ":" slow)
  set(how WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES)
  if(slow)
    gtest_discover_tests(${name} ${how} TEST_FILTER ${slow} PROPERTIES TIMEOUT 300 LABELS slow)
    gtest_discover_tests(${name} ${how} TEST_FILTER -${slow} PROPERTIES TIMEOUT 300 LABELS quick)
  else()
    gtest_discover_tests(${name} ${how} PROPERTIES TIMEOUT 300 LABELS quick)
  endif()
endfunction()

# CHASLES_SOURCE_DIR for programs whose sources name it, or a header that does. The others' objects do
# not depend on the checkout's folder, so that ccache has them for all folders.
function(chasles_source_dir program)
  foreach(source ${ARGN})
    file(STRINGS ${source} found LIMIT_COUNT 1
      REGEX "CHASLES_SOURCE_DIR|frontend_testing.hpp|(bags|calibration|check|codec|recording|run_folder|report|video)/.*testing.hpp")
    if(found)
      target_compile_definitions(${program} PRIVATE CHASLES_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
      return()
    endif()
  endforeach()
endfunction()

# Of a template's copies the linker takes the first one that it meets. Our libraries that the program
# links stand whole before its own objects: what is tested is the libraries' code, not a copy with -O1.
# Deferred to the end of the root CMakeLists.txt, where all libraries are known.
function(chasles_library_copies_first program)
  set(todo ${ARGN})
  set(files)
  set(seen)
  while(todo)
    list(POP_FRONT todo name)
    string(REPLACE "chasles::" "chasles_" name "${name}")
    if(NOT name MATCHES "^chasles_" OR NOT TARGET ${name} OR name IN_LIST seen)
      continue()
    endif()
    list(APPEND seen ${name})
    get_target_property(type ${name} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND files $<TARGET_FILE:${name}>)
    endif()
    get_target_property(uses ${name} INTERFACE_LINK_LIBRARIES)
    list(APPEND todo ${uses})
  endwhile()
  if(files)
    target_link_options(${program} PRIVATE -Wl,--whole-archive ${files} -Wl,--no-whole-archive)
  endif()
endfunction()
