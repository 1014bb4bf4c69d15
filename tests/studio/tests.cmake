# Studio as a process of its own, killed.
add_executable(studio_kill_driver ${CMAKE_CURRENT_LIST_DIR}/kill_driver.cpp)
target_link_libraries(studio_kill_driver PRIVATE knead_studio_core fmt::fmt)
knead_configure(studio_kill_driver)
knead_test(knead_studio_kill_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/kill_test.cpp LIBRARIES knead_studio_core fmt::fmt)
target_compile_definitions(knead_studio_kill_test PRIVATE KNEAD_KILL_DRIVER="$<TARGET_FILE:studio_kill_driver>")
add_dependencies(knead_studio_kill_test studio_kill_driver)

# The true window, where there is a display to be had.
if(TARGET knead-studio AND TARGET knead)
  add_test(NAME studio_window COMMAND ${CMAKE_CURRENT_LIST_DIR}/window_test.sh $<TARGET_FILE:knead>
                                      $<TARGET_FILE:knead-studio>)
  add_test(NAME studio_trace COMMAND ${CMAKE_CURRENT_LIST_DIR}/trace_test.sh $<TARGET_FILE:knead>
                                     $<TARGET_FILE:knead-studio>)
  add_executable(studio_pen ${CMAKE_CURRENT_LIST_DIR}/pen.cpp)
  knead_configure(studio_pen)
  add_test(NAME studio_pen COMMAND ${CMAKE_CURRENT_LIST_DIR}/pen_test.sh $<TARGET_FILE:knead> $<TARGET_FILE:knead-studio>
                                   $<TARGET_FILE:studio_pen>)
  add_test(NAME studio_poster COMMAND ${CMAKE_CURRENT_LIST_DIR}/poster_test.sh $<TARGET_FILE:knead>
                                      $<TARGET_FILE:knead-studio>)
  set_tests_properties(studio_window studio_trace PROPERTIES LABELS slow)
  # The display's drivers keep some memory to the end, which no build of ours changes.
  set_tests_properties(studio_window studio_trace studio_pen studio_poster PROPERTIES SKIP_RETURN_CODE 77 RUN_SERIAL ON TIMEOUT 900
                                                             ENVIRONMENT ASAN_OPTIONS=detect_leaks=0)
endif()
