# The program of docs/tutorial.md: its cpp blocks, one after the other, compiled and run.
set(tutorial ${PROJECT_SOURCE_DIR}/docs/tutorial.md)
add_custom_command(OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/tutorial.cpp
                   COMMAND awk -f ${CMAKE_CURRENT_LIST_DIR}/code_blocks.awk ${tutorial}
                           > ${CMAKE_CURRENT_BINARY_DIR}/tutorial.cpp
                   DEPENDS ${tutorial} ${CMAKE_CURRENT_LIST_DIR}/code_blocks.awk
                   VERBATIM)
add_executable(tutorial ${CMAKE_CURRENT_BINARY_DIR}/tutorial.cpp)
target_link_libraries(tutorial PRIVATE knead::core)
knead_configure(tutorial)

knead_test(knead_tutorial_test SOURCES ${CMAKE_CURRENT_LIST_DIR}/tutorial_test.cpp)
target_compile_definitions(knead_tutorial_test PRIVATE TUTORIAL_PAGE="${tutorial}"
                                                       TUTORIAL_PROGRAM="$<TARGET_FILE:tutorial>")
add_dependencies(knead_tutorial_test tutorial)
