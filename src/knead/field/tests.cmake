knead_test(
  knead_field_test
  SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/blend_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/field_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/packed_set_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/paper_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/region_test.cpp)
