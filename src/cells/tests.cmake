knead_test(knead_cells_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/cell_faces_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cell_measures_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/middle_nodes_test.cpp)
