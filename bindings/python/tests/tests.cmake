# One test of ctest for each file, run by pytest with the module of this build.
execute_process(COMMAND ${Python_EXECUTABLE} -c "import pytest, numpy" RESULT_VARIABLE result ERROR_QUIET)
if(NOT result EQUAL 0 OR KNEAD_SANITIZE)
  message(STATUS "knead: pytest not found, or a build with sanitizers: the tests of Python's module are left out")
  return()
endif()
file(GLOB tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/test_*.py)
set(slow python_docs python_examples python_fit python_fuzz python_long_work python_notebooks python_skin)
foreach(test IN LISTS tests)
  get_filename_component(name ${test} NAME_WE)
  string(REPLACE test_ python_ name ${name})
  add_test(NAME ${name} COMMAND ${Python_EXECUTABLE} -m pytest -q -rs -p no:cacheprovider ${test})
  set_tests_properties(${name} PROPERTIES
    LABELS knead_python
    SKIP_RETURN_CODE 5 # pytest, where a file is skipped as a whole
    ENVIRONMENT "PYTHONPATH=${KNEAD_PYTHON_DIR};PYTHONDONTWRITEBYTECODE=1;KNEAD=$<TARGET_FILE:knead>;KNEAD_SOURCE=${PROJECT_SOURCE_DIR};KNEAD_TEST_MESHES=${KNEAD_TEST_MESHES}")
  if(name IN_LIST slow)
    set_property(TEST ${name} APPEND PROPERTY LABELS slow)
  endif()
endforeach()
