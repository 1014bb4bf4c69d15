knead_test(knead_pose_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/pose_test.cpp)
