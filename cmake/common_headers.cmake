# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# What most sources include, parsed once: a third of the time that they take to compile. It hides includes that are missing:
# scripts/headers compiles without it.
#
# GCC 12 then sees overruns in std::string that are not there.
set(openfab_pch_warnings -Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread)
# What is compiled at -O1 takes the precompiled headers of -O2. GCC 13 and later refuse that (-Winvalid-pch, and parse it all again)
# for two settings of x86 that -O2 turns on, unless they are the same.
set(openfab_quick -O1)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13 AND openfab_x86)
    list(APPEND openfab_quick -munroll-only-small-loops -mvzeroupper)
endif()
# fmt's own definitions, for all: a precompiled header is good for those alone that have the same.
target_compile_definitions(openfab_options INTERFACE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/generated/common_headers.cpp CONTENT "")
add_library(openfab_common_headers STATIC EXCLUDE_FROM_ALL ${CMAKE_BINARY_DIR}/generated/common_headers.cpp)
target_link_libraries(openfab_common_headers PRIVATE openfab_options fmt::fmt)
target_compile_options(openfab_common_headers PRIVATE $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>)
target_precompile_headers(openfab_common_headers PRIVATE
    <algorithm> <array> <bit> <cmath> <cstdint> <cstring> <filesystem> <functional> <limits> <map> <memory> <optional> <span>
    <string> <string_view> <utility> <vector> <fmt/format.h>)

# openfab_use_common_headers(FOLDER): for all libraries and programs in it and below. What is compiled for another instruction
# set or with other rules for numbers than the rest parses its own.
function(openfab_use_common_headers folder)
    if(NOT OPENFAB_COMMON_HEADERS)
        return()
    endif()
    get_filename_component(folder ${folder} ABSOLUTE)
    set(other "(^|;)(-m|-fno-math|-fno-trapping)")
    get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
    foreach(target IN LISTS targets)
        get_target_property(type ${target} TYPE)
        get_target_property(has ${target} PRECOMPILE_HEADERS_REUSE_FROM)
        get_target_property(options ${target} COMPILE_OPTIONS)
        get_target_property(sources ${target} SOURCES)
        if(NOT type MATCHES "^(STATIC_LIBRARY|EXECUTABLE)$" OR has OR options MATCHES "${other}" OR NOT sources MATCHES "[.]cpp(;|$)")
            continue()
        endif()
        get_target_property(own ${target} SOURCE_DIR)
        foreach(source IN LISTS sources)
            get_filename_component(source ${source} ABSOLUTE BASE_DIR ${own})
            get_source_file_property(options ${source} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
            if(options MATCHES "${other}")
                set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
            endif()
        endforeach()
        target_compile_options(${target} PRIVATE
            $<$<AND:$<CXX_COMPILER_ID:GNU>,$<COMPILE_LANGUAGE:CXX>>:-fpch-preprocess;${openfab_pch_warnings}>)
        target_precompile_headers(${target} REUSE_FROM openfab_common_headers)
    endforeach()
    get_property(below DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
    foreach(one IN LISTS below)
        openfab_use_common_headers(${one})
    endforeach()
endfunction()
