knead_test(knead_remesh_test SOURCES
  ${PROJECT_SOURCE_DIR}/tests/support/paper_remesh.cpp
  ${CMAKE_CURRENT_LIST_DIR}/best_step_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cells_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/crossing_guard_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/facets_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/improve_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/remesh_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/seen_cells_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/settings_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shared_faces_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/surface_test.cpp)
