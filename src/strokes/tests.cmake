knead_test(knead_strokes_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/limit_cylinder_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/cylinder_placement_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/body_bend_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/paint_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/handles_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/images_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/inflate_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/limb_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mirrored_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/parts_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pins_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mirror_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/placement_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/points_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/push_grids_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pose_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stamp_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stamp_tool_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/strain_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/stroke_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/widest_outer_test.cpp
  SLOW BodyBend.ARingIsRefusedWithAnAngleThatWorks BodyBend.AVertexThatNoTriangleUsesDoesNotMatter
       BodyBend.TheBitsDependNotOnThreads BodyBend.TheCentreMayLieBesideThePart BodyBend/ABarBends.*)
