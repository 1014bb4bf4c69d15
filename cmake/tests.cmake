# knead_test(NAME SOURCES... [LIBRARIES ...]): one GoogleTest program, each of its tests known to ctest. Meshes that the
# project does not hold lie in KNEAD_TEST_MESHES; tests that use them say so when they are absent.
set(KNEAD_TEST_MESHES "${PROJECT_SOURCE_DIR}/../shared/meshes" CACHE PATH "Folder of real meshes for tests (optional)")

function(knead_test name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
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
  gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60 PROPERTIES LABELS ${name})
endfunction()
