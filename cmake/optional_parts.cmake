# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# Readers and writers whose libraries few need. None is built because its library happens to be there: -DOPENFAB_WITH_VDB=ON (or
# BLOSC, DICOM, HDF5, STEP, VRML) asks for it in one build folder, `scripts/setup --vdb`, which records it, in all that were not told otherwise.
set(OPENFAB_OPTIONAL_PARTS VDB BLOSC DICOM HDF5 STEP VRML)
set(recorded ${CMAKE_SOURCE_DIR}/build/optional_parts)
set(asked_for)
if(EXISTS ${recorded})
    set_property(DIRECTORY ${CMAKE_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${recorded})
    file(STRINGS ${recorded} asked_for)
endif()
foreach(part IN LISTS OPENFAB_OPTIONAL_PARTS)
    string(TOLOWER ${part} option)
    set(OPENFAB_WITH_${part} "" CACHE STRING "Build what needs ${part}'s library: ON, OFF; empty: if `scripts/setup --${option}` was run")
    if(OPENFAB_WITH_${part} OR ("${OPENFAB_WITH_${part}}" STREQUAL "" AND option IN_LIST asked_for))
        set(openfab_builds_${part} ON)
    else()
        set(openfab_builds_${part} OFF)
        message(STATUS "${part}: not asked for (scripts/setup --${option})")
    endif()
endforeach()

# openfab_need_optional(PART LIBRARY VARIABLE…): stops where a library that was asked for is not there.
function(openfab_need_optional part library)
    string(TOLOWER ${part} option)
    foreach(variable IN LISTS ARGN)
        if(NOT ${variable})
            message(FATAL_ERROR "${library} was asked for and not found (${variable}): run scripts/setup --${option}, or "
                "configure with -DOPENFAB_WITH_${part}=OFF")
        endif()
    endforeach()
endfunction()
