knead_test(knead_shapes_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/shapes_test.cpp
                                     ${CMAKE_CURRENT_LIST_DIR}/polygonise_test.cpp)
