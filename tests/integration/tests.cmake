knead_test(
  knead_integration_test
  SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/documents_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/invalid_mesh_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pins_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pose_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/scale_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/tools_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/volume_test.cpp
  ${PROJECT_SOURCE_DIR}/tests/surveys/random_strokes.cpp
  LIBRARIES
  fmt::fmt
  SLOW
  PoseOnScans.*
  Tools/EveryUnit.*)
target_compile_definitions(knead_integration_test PRIVATE KNEAD_SOURCE="${PROJECT_SOURCE_DIR}")
