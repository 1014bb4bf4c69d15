knead_test(knead_math_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/elementary_test.cpp
                                ${CMAKE_CURRENT_LIST_DIR}/math_test.cpp)
