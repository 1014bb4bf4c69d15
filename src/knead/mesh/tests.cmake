knead_test(knead_mesh_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/flipped_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/measures_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/normals_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/triangulate_test.cpp)
include(${CMAKE_CURRENT_LIST_DIR}/shapes_tests.cmake OPTIONAL)
