# What `knead bench` compares with.
knead_test(knead_bench_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/kelvinlets_test.cpp ${PROJECT_SOURCE_DIR}/bench/kelvinlets.cpp)
target_include_directories(knead_bench_test PRIVATE ${PROJECT_SOURCE_DIR}/bench)
