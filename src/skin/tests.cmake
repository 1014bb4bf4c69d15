knead_test(knead_skin_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/gltf_skin_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/skin_test.cpp)
