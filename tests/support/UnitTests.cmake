# gentbeam_add_unit_test(NAME <name> SOURCES <file.pf>...
#                        [OTHER_SOURCES <file>...] [LINK_LIBRARIES <target>...])
#
# Builds the program <name> out of test files and registers it with CTest, label `unit`. OTHER_SOURCES are
# helpers of these tests alone; helpers that several suites share go into a library of LINK_LIBRARIES.
#
# GENTBEAM_TESTS_WITH says what runs the tests: pFUnit, the runner bundled in this directory, or pFUnit
# where CMake finds it and the bundled runner elsewhere. A suite passes if it ends with the line
# `N passed, 0 failed`, N > 0, so that neither a stop in the code under test nor an empty run goes unnoticed.

include_guard(GLOBAL)

set(GENTBEAM_TESTS_WITH auto CACHE STRING "What runs the unit tests: pfunit, bundled or auto")
set_property(CACHE GENTBEAM_TESTS_WITH PROPERTY STRINGS auto pfunit bundled)
set(GENTBEAM_UNIT_TEST_PASSES "\n[1-9][0-9]* passed, 0 failed\n")

if(GENTBEAM_TESTS_WITH STREQUAL "pfunit")
  find_package(PFUNIT REQUIRED)
elseif(GENTBEAM_TESTS_WITH STREQUAL "auto")
  find_package(PFUNIT QUIET)
elseif(NOT GENTBEAM_TESTS_WITH STREQUAL "bundled")
  message(FATAL_ERROR "GENTBEAM_TESTS_WITH is ${GENTBEAM_TESTS_WITH}; it may be pfunit, bundled or auto")
endif()
if(PFUNIT_FOUND AND NOT GENTBEAM_TESTS_WITH STREQUAL "bundled")
  set(GENTBEAM_UNIT_TEST_RUNNER pfunit)
else()
  set(GENTBEAM_UNIT_TEST_RUNNER bundled)
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  add_library(gentbeam_funit STATIC
    ${CMAKE_CURRENT_LIST_DIR}/funit.f90
    ${CMAKE_CURRENT_LIST_DIR}/funit_runner.f90)
  set_target_properties(gentbeam_funit PROPERTIES
    Fortran_MODULE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/mod/gentbeam_funit)
  target_include_directories(gentbeam_funit PUBLIC ${CMAKE_CURRENT_BINARY_DIR}/mod/gentbeam_funit)
endif()

# The report runs in the top folder, which does not see the variables of this one.
set_property(GLOBAL PROPERTY GENTBEAM_UNIT_TEST_RUNNER ${GENTBEAM_UNIT_TEST_RUNNER})

function(gentbeam_add_unit_test)
  cmake_parse_arguments(PARSE_ARGV 0 arg "" "NAME" "SOURCES;OTHER_SOURCES;LINK_LIBRARIES")
  if(NOT arg_NAME OR NOT arg_SOURCES OR arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "gentbeam_add_unit_test needs NAME and SOURCES, and takes OTHER_SOURCES and "
                        "LINK_LIBRARIES")
  endif()
  if(GENTBEAM_UNIT_TEST_RUNNER STREQUAL "pfunit")
    _gentbeam_add_pfunit_test()
  else()
    _gentbeam_add_bundled_test()
  endif()
  set_tests_properties(${arg_NAME} PROPERTIES
    LABELS unit
    PASS_REGULAR_EXPRESSION "${GENTBEAM_UNIT_TEST_PASSES}")

  foreach(source IN LISTS arg_SOURCES)
    file(STRINGS ${source} found REGEX "^[ \t]*@[tT][eE][sS][tT][ \t]*(\\(.*)?$")
    list(LENGTH found count)
    set_property(GLOBAL APPEND PROPERTY GENTBEAM_UNIT_TEST_COUNTS ${count})
  endforeach()
endfunction()

# The two ways to build a suite. Both read the arguments of gentbeam_add_unit_test from their caller.

macro(_gentbeam_add_bundled_test)
  set(preprocessor ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/pf_preprocess.py)
  set(directory ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME}.dir)
  file(MAKE_DIRECTORY ${directory})
  set(generated)
  set(modules)
  foreach(source IN LISTS arg_SOURCES)
    get_filename_component(source ${source} ABSOLUTE)
    get_filename_component(module ${source} NAME_WE)
    add_custom_command(
      OUTPUT ${directory}/${module}.F90
      COMMAND Python3::Interpreter ${preprocessor} ${source} ${directory}/${module}.F90
      DEPENDS ${source} ${preprocessor}
      VERBATIM)
    list(APPEND generated ${directory}/${module}.F90)
    list(APPEND modules ${module})
  endforeach()
  add_custom_command(
    OUTPUT ${directory}/driver.f90
    COMMAND Python3::Interpreter ${preprocessor} --driver ${directory}/driver.f90 ${modules}
    DEPENDS ${preprocessor}
    VERBATIM)
  list(APPEND generated ${directory}/driver.f90)

  add_executable(${arg_NAME} ${generated} ${arg_OTHER_SOURCES})
  set_target_properties(${arg_NAME} PROPERTIES Fortran_MODULE_DIRECTORY ${directory}/mod)
  target_include_directories(${arg_NAME} PRIVATE ${directory}/mod)
  target_link_libraries(${arg_NAME} PRIVATE gentbeam_funit ${arg_LINK_LIBRARIES})
  _gentbeam_warnings_are_no_errors(${generated})
  add_test(NAME ${arg_NAME} COMMAND ${arg_NAME} -v)
endmacro()

macro(_gentbeam_add_pfunit_test)
  # pFUnit writes what it makes of a relative path into the build tree, of an absolute one beside the source.
  set(relative_sources)
  set(generated ${CMAKE_CURRENT_BINARY_DIR}/${arg_NAME}_driver.F90)
  foreach(source IN LISTS arg_SOURCES)
    get_filename_component(source ${source} ABSOLUTE)
    file(RELATIVE_PATH source ${CMAKE_CURRENT_SOURCE_DIR} ${source})
    list(APPEND relative_sources ${source})
    string(REGEX REPLACE "\\.pf$" ".F90" output ${CMAKE_CURRENT_BINARY_DIR}/${source})
    list(APPEND generated ${output})
  endforeach()
  set(PFUNIT_DRIVER ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/pfunit_driver.F90)
  add_pfunit_ctest(${arg_NAME}
    TEST_SOURCES ${relative_sources}
    OTHER_SOURCES ${arg_OTHER_SOURCES}
    LINK_LIBRARIES ${arg_LINK_LIBRARIES})
  _gentbeam_warnings_are_no_errors(${generated})
endmacro()

function(_gentbeam_warnings_are_no_errors)
  set_source_files_properties(${ARGN} PROPERTIES
    COMPILE_OPTIONS "$<$<Fortran_COMPILER_ID:GNU>:-Wno-error>")
endfunction()

# Printed last of all: how many tests there are, so that one which drops out is missed.
function(_gentbeam_report_unit_tests)
  get_property(counts GLOBAL PROPERTY GENTBEAM_UNIT_TEST_COUNTS)
  get_property(runner GLOBAL PROPERTY GENTBEAM_UNIT_TEST_RUNNER)
  list(LENGTH counts files)
  list(JOIN counts "+" sum)
  math(EXPR sum "${sum}+0")
  message(STATUS "Unit tests: ${sum} found in ${files} files, run by ${runner}")
endfunction()
cmake_language(DEFER DIRECTORY ${CMAKE_SOURCE_DIR} CALL _gentbeam_report_unit_tests)
