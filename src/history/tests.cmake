knead_test(knead_history_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/journal_everywhere_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/arrange_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gesture_strength_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/workbench_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/workbench_memory_test.cpp
  LIBRARIES nlohmann_json::nlohmann_json)
if(NOT WIN32)  # they use processes, signals and limits of POSIX
  target_sources(knead_history_test PRIVATE ${CMAKE_CURRENT_LIST_DIR}/journal_failures_test.cpp
                                            ${CMAKE_CURRENT_LIST_DIR}/journal_test.cpp)
endif()
