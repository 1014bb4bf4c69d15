knead_test(knead_splats_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/splat_surface_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/splats_test.cpp)
