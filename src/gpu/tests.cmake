knead_test(
  knead_gpu_test SOURCES ${PROJECT_SOURCE_DIR}/src/gpu/advect_gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/pins_gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/glsl_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/gpu_failures_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/gpu_surface_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/gpu_test.cpp
                         ${PROJECT_SOURCE_DIR}/src/gpu/grid_gpu_test.cpp LIBRARIES knead::gpu
  SLOW GpuTest.AgreesWithTheReferenceForEveryKindOfSegment GpuTest.InDoubleItAgreesFarBelowFloat GpuTest.LargePointSets
       GpuTest.PointSetsWithTrees* GpuTest.PointsThatNoToolTouchesKeepTheirBits)
