# knead_test(NAME SOURCES... [LIBRARIES ...] [SLOW ...]): one GoogleTest program, each of its tests known to ctest. Those that
# take over 10 s of processor match a pattern of SLOW and have the label NAME.slow: ./dev test --all runs them, too. Meshes
# that the project does not hold lie in KNEAD_TEST_MESHES; tests that use them are skipped when they are absent.
set(KNEAD_TEST_MESHES "${PROJECT_SOURCE_DIR}/../shared/meshes" CACHE PATH "Folder of real meshes for tests (optional)")

function(knead_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES;SLOW" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE knead::core ${ARG_LIBRARIES} GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests ${PROJECT_SOURCE_DIR}/src)
  target_compile_definitions(${name} PRIVATE KNEAD_TEST_MESHES="${KNEAD_TEST_MESHES}")
  knead_configure(${name})
  if(WIN32)
    target_compile_options(${name} PRIVATE -include ${PROJECT_SOURCE_DIR}/tests/support/windows.h)
    target_link_options(${name} PRIVATE -Wl,--stack,8388608)
  endif()
  # A quarter less time to compile than with -O3; what tests wait for is in the library.
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  string(JOIN : slow ${ARG_SLOW})
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES TEST_FILTER "*-${slow}" PROPERTIES LABELS ${name})
  if(slow)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 NO_PRETTY_VALUES TEST_FILTER "${slow}" TEST_LIST ${name}_SLOW
                         PROPERTIES LABELS ${name}.slow)
  endif()
endfunction()
