knead_test(knead_studio_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/view/shown_shape_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view/look_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/keys_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/bend_along_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/lattice_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/gestures_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/masks_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/images_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/navigation_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/parts_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/pins_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/pose_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/prints_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/gestures/selected_pins_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/preferences_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/words_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/layers_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/studio_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/studio_work_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/view/stretch_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/document/document_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/objects_test.cpp
  LIBRARIES knead_studio_core fmt::fmt
  SLOW StretchTest.OffersToRemeshWhatTheLastStrokeMadeThin)
target_compile_definitions(knead_studio_test PRIVATE KNEAD_SOURCES="${PROJECT_SOURCE_DIR}")

if(TARGET knead_studio_panels)
  knead_test(knead_studio_panels_test SOURCES
    ${CMAKE_CURRENT_LIST_DIR}/panels/fit_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/panels/interface_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/panels/offers_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/panels/panels_test.cpp
    ${CMAKE_CURRENT_LIST_DIR}/panels/tool_bar_test.cpp
    LIBRARIES knead_studio_panels
    SLOW OffersTest.APoseThatFallsShortOffersTheOneThingToDo)
endif()
