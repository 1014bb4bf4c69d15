knead_test(knead_studio_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/view/gpu_preview_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/platform/file_list_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/keys_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/gestures_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/images_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/navigation_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/preferences_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/studio_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/document/stroke_fields_test.cpp
  LIBRARIES knead_studio_core fmt::fmt)
