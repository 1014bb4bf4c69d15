# Installs BUILD_DIR to a fresh prefix under WORK_DIR, then configures, builds and runs the project beside this file
# against it. COMPILER and FLAGS are those of the build: a sanitized library needs a sanitized program. VERSION is the
# MAJOR.MINOR of the project: find_package(knead VERSION) must succeed, and another version must not.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE ${WORK_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${WORK_DIR}/prefix)
run(${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${WORK_DIR}/build -G Ninja -DCMAKE_PREFIX_PATH=${WORK_DIR}/prefix -DKNEAD_VERSION=${VERSION}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${WORK_DIR}/build)
execute_process(COMMAND ${CMAKE_COMMAND} ${WORK_DIR}/build -DKNEAD_VERSION=9999.0 RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
if(status EQUAL 0)
  message(FATAL_ERROR "find_package(knead 9999.0) found version ${VERSION}")
endif()
run(${WORK_DIR}/build/consumer ${WORK_DIR}/sphere.ply)
foreach(example IN ITEMS pull torus_tool)
  run(${WORK_DIR}/build/${example} ${WORK_DIR}/sphere.ply ${WORK_DIR}/${example}.ply)
  run(${WORK_DIR}/build/consumer ${WORK_DIR}/sphere.ply ${WORK_DIR}/${example}.ply)
endforeach()
