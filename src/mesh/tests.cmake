knead_test(knead_mesh_test SOURCES
  ${CMAKE_CURRENT_LIST_DIR}/flipped_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/folded_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/joined_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/measures_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/mesh_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/normals_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/predicates_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/self_intersections_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/shape_box_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/surface_tree_test.cpp
  ${CMAKE_CURRENT_LIST_DIR}/triangulate_test.cpp)
find_package(CGAL 5.5 QUIET)
if(CGAL_FOUND)
  knead_test(knead_cgal_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/self_intersections_cgal_test.cpp LIBRARIES CGAL::CGAL
             SLOW Scans/CgalMesh.*)
else()
  message(STATUS "CGAL is absent: the test that compares self-intersections with it is left out")
endif()
knead_test(knead_shapes_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/shapes_test.cpp
                                     ${CMAKE_CURRENT_LIST_DIR}/polygonise_test.cpp)
