# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# openfab_compile_for(SET OPTIONS SOURCE …): compiles the sources for one instruction set of x86 and with these options, and
# names them in ${SET_sources}. None has FMA that the source does not ask for. On another processor the first set is that of the
# machine (core/simd/intrinsics.h), and the list of a wider one is empty.
set(openfab_x86 OFF)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    set(openfab_x86 ON)
elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
    find_path(OPENFAB_SIMDE simde/x86/sse4.1.h)
    if(NOT OPENFAB_SIMDE)
        message(FATAL_ERROR "SIMDe was not found: run scripts/setup")
    endif()
else()
    message(FATAL_ERROR "OpenFab runs on x86-64 and on arm64, not on ${CMAKE_SYSTEM_PROCESSOR}: core/simd and compiler/lower/code/machine_code.cpp name what another would need")
endif()
function(openfab_compile_for set options)
    set(flags_sse41 -msse4.1)
    set(flags_avx2 -mavx2)
    set(flags_avx2_fma -mavx2 -mfma)
    set(flags_avx512 -mavx2 -mfma -mavx512f -mavx512vl -mavx512dq)
    set(sources ${ARGN})
    if(openfab_x86)
        set(flags ${flags_${set}} ${options})
    elseif(NOT set STREQUAL "sse41")
        set(sources)
    endif()
    if(sources)
        set_source_files_properties(${sources} PROPERTIES COMPILE_OPTIONS "${flags};${openfab_hot_loops}")
    endif()
    set(${set}_sources ${sources} PARENT_SCOPE)
endfunction()
