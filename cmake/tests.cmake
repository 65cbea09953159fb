# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
enable_testing()
find_package(GTest REQUIRED)

# Precompiles what nearly every test includes: a third of the tests' compile time. GCC 12 then sees overruns in
# std::string that are not there.
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/test_headers.cpp CONTENT "")
add_library(openfab_test_headers STATIC ${CMAKE_BINARY_DIR}/generated/test_headers.cpp)
target_link_libraries(openfab_test_headers PRIVATE openfab_options fmt::fmt GTest::gtest GTest::gmock)
target_compile_options(openfab_test_headers PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
target_precompile_headers(openfab_test_headers PRIVATE
    <algorithm> <array> <cmath> <cstdint> <filesystem> <fstream> <functional> <map> <memory> <optional> <random> <string>
    <utility> <vector> <fmt/format.h> <gmock/gmock.h> <gtest/gtest.h>)

# openfab_test_program(NAME SOURCES … LIBS …): a GoogleTest program, not yet registered with ctest.
function(openfab_test_program name)
    cmake_parse_arguments(arg "" "" "SOURCES;LIBS" ${ARGN})
    add_executable(${name} ${arg_SOURCES})
    target_link_libraries(${name} PRIVATE
        openfab_options openfab_test_places ${arg_LIBS} fmt::fmt GTest::gmock GTest::gtest GTest::gtest_main)
    # A test's own code runs for less time than -O2 takes to make it, what it tests is in libraries. At -O1 GCC takes more for
    # uninitialised than is. Clang warns of RapidJSON's iterators, whose comparisons C++20 may also turn around.
    target_compile_options(${name} PRIVATE "$<$<CONFIG:Release>:${openfab_quick}>"
        $<$<CXX_COMPILER_ID:Clang>:-Wno-ambiguous-reversed-operator>
        $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess;${openfab_pch_warnings};-Wno-maybe-uninitialized>)
    target_precompile_headers(${name} REUSE_FROM openfab_test_headers)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
    foreach(source IN LISTS arg_SOURCES)
        get_filename_component(source ${source} ABSOLUTE)
        set_property(GLOBAL APPEND PROPERTY openfab_test_sources ${source})
    endforeach()
endfunction()

# openfab_test_entry(NAME COMMAND … [COST s] [TIMEOUT s]): registers a test with ctest. Its labels are the folder of
# tests/ that it is in and what it costs: `fast`, or `whole` where whole programs run; `sanitized` and
# `threaded` as tests/sanitized.cmake has it. COST is seconds on two cores, 1 in folders that are quick and 10 in others unless told;
# the longest start first.
function(openfab_test_entry name)
    cmake_parse_arguments(arg "" "COST;TIMEOUT" "COMMAND" ${ARGN})
    if(NOT arg_TIMEOUT)
        set(arg_TIMEOUT 1200)
    endif()
    file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
    string(REGEX REPLACE "/.*" "" folder ${folder})
    set(labels ${folder})
    if(NOT arg_COST AND folder MATCHES "^(unit|lang|golden|support)$")
        set(arg_COST 1)
    elseif(NOT arg_COST)
        set(arg_COST 10)
    endif()
    if(folder MATCHES "^(programs|scenes)$")
        list(APPEND labels whole)
    elseif(arg_COST LESS 5)
        list(APPEND labels fast)
    endif()
    set_property(GLOBAL APPEND PROPERTY openfab_test_names ${folder}/${name})
    foreach(kind sanitized threaded)
        openfab_runs_under(runs ${kind} ${folder}/${name})
        if(runs)
            list(APPEND labels ${kind})
            list(GET arg_COMMAND 0 program)
            set_property(GLOBAL APPEND PROPERTY openfab_${kind}_programs ${program})
        endif()
    endforeach()
    add_test(NAME ${folder}/${name} COMMAND ${arg_COMMAND} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
    set_tests_properties(${folder}/${name} PROPERTIES LABELS "${labels}" COST ${arg_COST} TIMEOUT ${arg_TIMEOUT})
endfunction()

# openfab_test(NAME SOURCES … LIBS … [COST s] [TIMEOUT s]): a GoogleTest program, registered with ctest.
function(openfab_test name)
    cmake_parse_arguments(arg "" "COST;TIMEOUT" "SOURCES;LIBS" ${ARGN})
    openfab_test_program(${name} SOURCES ${arg_SOURCES} LIBS ${arg_LIBS})
    openfab_test_entry(${name} COMMAND ${name} COST ${arg_COST} TIMEOUT ${arg_TIMEOUT})
endfunction()

# openfab_optional_test(PART NAME SOURCES … LIBS …): of a part that is built where it was asked for
# (cmake/optional_parts.cmake). It has the label `optional`; the target of that name makes all that these tests run.
add_custom_target(optional)
function(openfab_optional_test part name)
    if(openfab_builds_${part})
        openfab_test(${name} ${ARGN})
        openfab_label_optional(${name} ${name})
    else()
        cmake_parse_arguments(arg "" "" "SOURCES" ${ARGN})
        foreach(source IN LISTS arg_SOURCES)
            get_filename_component(source ${source} ABSOLUTE)
            set_property(GLOBAL APPEND PROPERTY openfab_test_sources ${source})
        endforeach()
    endif()
endfunction()

# openfab_label_optional(NAME TARGET…): of a test in this folder that runs the optional parts.
function(openfab_label_optional name)
    file(RELATIVE_PATH folder ${CMAKE_SOURCE_DIR}/tests ${CMAKE_CURRENT_SOURCE_DIR})
    string(REGEX REPLACE "/.*" "" folder ${folder})
    set_property(TEST ${folder}/${name} APPEND PROPERTY LABELS optional)
    add_dependencies(optional ${ARGN})
endfunction()

# No test can vanish: a file named *_test.cpp that is in no program stops the configuration.
function(openfab_check_all_tests_are_built)
    file(GLOB_RECURSE files CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/tests/*_test.cpp)
    get_property(built GLOBAL PROPERTY openfab_test_sources)
    list(REMOVE_ITEM files ${built})
    if(files)
        list(JOIN files "\n  " list)
        message(FATAL_ERROR "tests that no program is made of:\n  ${list}")
    endif()
endfunction()
