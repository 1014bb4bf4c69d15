knead_test(knead_engineering_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/kept_cells_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/solver_walls_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/walls_test.cpp
  LIBRARIES nlohmann_json::nlohmann_json)
