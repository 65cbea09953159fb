# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# Print programs of fablets that several tests run: compiled once, for the instruction set of this machine unless told
# otherwise. They are not part of the default target, since LLVM takes its time; ctest builds those of a group before
# the first test that needs them.
set(openfab_openflc $<TARGET_FILE:openflc>)
set(openfab_openflc_needs openflc)
if(OPENFAB_HOST_BUILD)
    # Its location decides which runtime it links: this build's.
    set(openfab_openflc ${CMAKE_BINARY_DIR}/host/bin/openflc)
    openfab_host_file(${openfab_openflc} bin/openflc)
    file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/host)
    file(CREATE_LINK ${CMAKE_BINARY_DIR}/lib ${CMAKE_BINARY_DIR}/host/lib SYMBOLIC)
    set(openfab_openflc_needs ${openfab_openflc} openfab_link_probe)
endif()
file(STRINGS /proc/cpuinfo avx2 REGEX "^flags.* avx2 " LIMIT_COUNT 1)
if(avx2)
    set(openfab_native_target avx2)
else()
    set(openfab_native_target sse41)
endif()

set(OPENFAB_PRINT_PROGRAMS ${CMAKE_BINARY_DIR}/print_programs)
file(MAKE_DIRECTORY ${OPENFAB_PRINT_PROGRAMS})

# openfab_print_program(GROUP NAME SOURCE.fl [WITH more.fl …] [TARGET both] [SCHEDULE file])
function(openfab_print_program group name source)
    cmake_parse_arguments(arg "" "TARGET;SCHEDULE" "WITH" ${ARGN})
    if(NOT arg_TARGET)
        set(arg_TARGET ${openfab_native_target})
    endif()
    set(options --target ${arg_TARGET} --jobs 1)
    if(arg_SCHEDULE)
        list(APPEND options --schedule ${arg_SCHEDULE})
    endif()
    set(modules)
    foreach(file ${source} ${arg_WITH})
        get_filename_component(folder ${file} DIRECTORY)
        file(GLOB beside CONFIGURE_DEPENDS ${folder}/*.fl)
        list(APPEND modules ${beside})
    endforeach()
    add_custom_command(OUTPUT ${OPENFAB_PRINT_PROGRAMS}/${name}
        COMMAND ${openfab_openflc} build ${source} ${arg_WITH} -o ${OPENFAB_PRINT_PROGRAMS}/${name} ${options}
        DEPENDS ${modules} ${arg_SCHEDULE} ${openfab_openflc_needs} COMMENT "Compiling the fablets of ${name}" VERBATIM)
    set_property(GLOBAL APPEND PROPERTY openfab_print_programs_${group} ${OPENFAB_PRINT_PROGRAMS}/${name})
endfunction()

# openfab_print_programs(GROUP COST s): the target and the ctest entry that build a group; its tests have
# FIXTURES_REQUIRED GROUP_programs.
function(openfab_print_programs group cost)
    get_property(programs GLOBAL PROPERTY openfab_print_programs_${group})
    add_custom_target(${group}_programs DEPENDS ${programs})
    include(ProcessorCount)
    ProcessorCount(processors)
    openfab_test_entry(${group}_programs COST ${cost} TIMEOUT 3600
        COMMAND ${CMAKE_COMMAND} --build ${CMAKE_BINARY_DIR} --parallel ${processors} --target ${group}_programs)
    set_tests_properties(scenes/${group}_programs PROPERTIES
        FIXTURES_SETUP ${group}_programs PROCESSORS ${processors} RESOURCE_LOCK build)
endfunction()
