knead_test(knead_examples_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/field2d_test.cpp)
target_include_directories(knead_examples_test PRIVATE ${PROJECT_SOURCE_DIR}/examples)
