knead_test(knead_session_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/coefficients_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/curve_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/curve_thickness_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/deformed_shape_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/derivatives_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/exact_image_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flow_of_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mask_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mirror_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/parameters_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/print_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/relax_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/replay_backend_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/remesh_limits_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/replay_remeshed_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/frames_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/lattice_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/replay_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/session_errors_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/session_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/snapshot_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stroke_keys_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/surface_stroke_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/wide_stroke_test.cpp
  LIBRARIES nlohmann_json::nlohmann_json
  SLOW ReplayRemeshed.WhatCrossesWithoutRemedyIsRefusedUnlessItIsAllowed
       RemeshLimits.ExtremeStrokesOfASphereEndOrAreRefusedSoon)
