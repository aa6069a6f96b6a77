# gw_library(NAME [PURE] SOURCES ... [PUBLIC libs...] [PRIVATE libs...])
# PURE: a core; gw_purity_tests() checks on its archive that it needs no clock, thread, file and the like.
function(gw_library name)
  cmake_parse_arguments(ARG "PURE" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_include_directories(${name} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PUBLIC ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  if(ARG_PURE)
    set_property(GLOBAL APPEND PROPERTY GW_PURE_LIBRARIES ${name})
  endif()
endfunction()

# gw_purity_tests(): one test over all PURE libraries, and one that shows that the check can fail.
# Sanitizers put their own symbols into every archive, so there is nothing to check in such a build.
function(gw_purity_tests)
  find_package(Python3 COMPONENTS Interpreter)
  if(NOT Python3_FOUND OR GW_SANITIZE)
    return()
  endif()
  get_property(pure GLOBAL PROPERTY GW_PURE_LIBRARIES)
  list(TRANSFORM pure REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE archives)
  set(check Python3::Interpreter ${CMAKE_SOURCE_DIR}/tools/project/check/purity.py)
  add_test(NAME purity COMMAND ${check} ${archives})
  add_test(NAME purity.finds_clocks_and_threads COMMAND ${check} $<TARGET_FILE:gw_process>)
  set_tests_properties(purity.finds_clocks_and_threads PROPERTIES
    PASS_REGULAR_EXPRESSION "needs clock_gettime")
  set_tests_properties(purity purity.finds_clocks_and_threads PROPERTIES LABELS unit)
endfunction()

# gw_program(NAME SOURCES ... LIBS ...): an installed program with --help and --version smoke tests. The target
# gw_programs is all of them.
add_custom_target(gw_programs)
function(gw_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS})
  install(TARGETS ${name} RUNTIME DESTINATION bin)
  add_dependencies(gw_programs ${name})
  foreach(flag help version)
    add_test(NAME ${name}.${flag} COMMAND ${name} --${flag})
    set_tests_properties(${name}.${flag} PROPERTIES LABELS unit)
  endforeach()
endfunction()

# gw_test(NAME SOURCES ... LIBS ... [LABEL unit|world|golden|multiproc|dataset|study|robot] [TIMEOUT seconds])
# One ctest entry per program; GoogleTest prints the cases. Each has a folder of its own for temporary files, so that tests
# of several builds may run at the same time.
function(gw_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LIBS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  if(GW_SANITIZE OR CMAKE_CROSSCOMPILING)
    math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * 10")  # sanitizers and emulators are that much slower
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    GW_SOURCE_DIR="${CMAKE_SOURCE_DIR}" GW_BINARY_DIR="${CMAKE_BINARY_DIR}/bin")
  add_test(NAME ${name} COMMAND ${name})
  set(temporary ${CMAKE_BINARY_DIR}/test_tmp/${name})
  file(MAKE_DIRECTORY ${temporary})
  set_tests_properties(${name} PROPERTIES LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT}
    ENVIRONMENT_MODIFICATION "TMPDIR=set:${temporary};TEST_TMPDIR=set:${temporary}")
endfunction()

# gw_benchmark(NAME SOURCES ... LIBS ...): built with the rest, run by `tools/dev bench`.
function(gw_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LIBS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} PRIVATE ${CMAKE_SOURCE_DIR})
  target_link_libraries(${name} PRIVATE ${ARG_LIBS} benchmark::benchmark)
endfunction()
