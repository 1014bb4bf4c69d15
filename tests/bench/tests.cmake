# What `knead bench` compares with, and how it judges.
knead_test(knead_bench_test
           SOURCES ${CMAKE_CURRENT_LIST_DIR}/integrators_test.cpp ${CMAKE_CURRENT_LIST_DIR}/kelvinlets_test.cpp
           LIBRARIES knead_benchmark)
