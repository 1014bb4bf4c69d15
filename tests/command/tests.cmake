# The built command, run as people run it.
set(here ${CMAKE_CURRENT_LIST_DIR})
knead_test(knead_command_test
           SOURCES ${here}/bench_test.cpp ${here}/check_test.cpp ${here}/deform_test.cpp ${here}/errors_test.cpp ${here}/examples_test.cpp ${here}/fit_test.cpp
                   ${here}/frames_test.cpp ${here}/interrupt_test.cpp ${here}/makers_test.cpp ${here}/parameters_test.cpp ${here}/process.cpp ${here}/remesh_test.cpp ${here}/shapes_test.cpp ${here}/streams_test.cpp ${here}/together_test.cpp
           LIBRARIES fmt::fmt nlohmann_json::nlohmann_json
           SLOW FitTest.BringsTheWholeSurfaceToTheTarget FitTest.FollowsAHandThatMovesFar FitTest.TakesTheTablesOfSpreadsheets
                FitTest.TakesTolerancesAndMaps)
target_compile_definitions(knead_command_test PRIVATE KNEAD_COMMAND="$<TARGET_FILE:knead>"
                                                      KNEAD_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
add_dependencies(knead_command_test knead knead-bench)
if(TARGET knead::gpu)
  target_compile_definitions(knead_command_test PRIVATE KNEAD_HAS_GPU)
  target_sources(knead_command_test PRIVATE ${here}/backend_test.cpp)
  add_library(knead_failing_gpu MODULE ${here}/failing_gpu.cpp)
  target_link_libraries(knead_failing_gpu PRIVATE knead::core PkgConfig::KNEAD_GL)
  target_include_directories(knead_failing_gpu PRIVATE ${PROJECT_SOURCE_DIR}/tests)
  knead_configure(knead_failing_gpu)
  target_compile_definitions(knead_command_test PRIVATE KNEAD_FAILING_GPU="$<TARGET_FILE:knead_failing_gpu>")
  add_dependencies(knead_command_test knead_failing_gpu)
endif()
if(TARGET knead::render)
  target_sources(knead_command_test PRIVATE ${here}/render_test.cpp)
  target_include_directories(knead_command_test SYSTEM PRIVATE ${KNEAD_STB_INCLUDE_DIR})
endif()

find_package(Python3 QUIET COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME wild_files COMMAND ${Python3_EXECUTABLE} ${here}/wild_files.py $<TARGET_FILE:knead>)
  set_tests_properties(wild_files PROPERTIES LABELS slow)
endif()
