# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# A third of the time to compile goes into what each source parses and instantiates again. In the release build sources of a
# library or of a program, tests too, are compiled eight at a time: the compiler's (ON), or all (ALL). What is run once a fablet
# or a command, and not once a voxel, takes longer to compile than it will ever run: that is compiled at -O1.
# Two sources of a library then cannot have the same name for different things without a namespace; a compiler says so. Other
# builds compile each source alone, which finds includes that are missing.
set(OPENFAB_FEWER_UNITS OFF CACHE STRING "Compile several sources at once, and with less optimisation where speed does not matter: ON, the compiler's; ALL; OFF")
set(openfab_unit_sources 8)

# openfab_fewer_units(FOLDER [QUICK] [ALL]): for all libraries and programs in it and below. QUICK: to compile, at -O1. ALL: only
# where all are. Sources with options or definitions of their own stay alone, and those of openfab_alone.
function(openfab_fewer_units folder)
    if(NOT OPENFAB_FEWER_UNITS OR ("ALL" IN_LIST ARGN AND NOT OPENFAB_FEWER_UNITS STREQUAL "ALL"))
        return()
    endif()
    get_filename_component(folder ${folder} ABSOLUTE)
    get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
    foreach(target IN LISTS targets)
        get_target_property(type ${target} TYPE)
        if(type MATCHES "^(STATIC_LIBRARY|EXECUTABLE)$")
            if("QUICK" IN_LIST ARGN)
                target_compile_options(${target} PRIVATE ${openfab_quick} $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
            endif()
            if("ALL" IN_LIST ARGN)
                # Names without a namespace are those of the unit.
                target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage;-Wno-maybe-uninitialized>)
            endif()
            openfab_unite(${target})
        endif()
    endforeach()
    get_property(below DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
    foreach(one IN LISTS below)
        openfab_fewer_units(${one} ${ARGN})
    endforeach()
endfunction()

# openfab_alone(SOURCE…): of this folder, which have names without a namespace in common with others of their library.
function(openfab_alone)
    set_source_files_properties(${ARGN} PROPERTIES OPENFAB_ALONE ON)
endfunction()

# openfab_unite(TARGET): its sources in as few units as there may be.
function(openfab_unite target)
    get_target_property(own ${target} SOURCE_DIR)
    get_target_property(sources ${target} SOURCES)
    set(others)
    set(includes)
    foreach(source IN LISTS sources)
        get_filename_component(path ${source} ABSOLUTE BASE_DIR ${own})
        get_source_file_property(options ${path} TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
        get_source_file_property(definitions ${path} TARGET_DIRECTORY ${target} COMPILE_DEFINITIONS)
        get_source_file_property(alone ${path} TARGET_DIRECTORY ${target} OPENFAB_ALONE)
        # Paths from the root, so that what one clone has compiled serves another.
        file(RELATIVE_PATH name ${CMAKE_SOURCE_DIR} ${path})
        if(NOT source MATCHES "[.]cpp$" OR options OR definitions OR alone OR name MATCHES "^[.][.]/|^build/")
            list(APPEND others ${source})
        else()
            list(APPEND includes "#include \"${name}\"\n")
        endif()
    endforeach()
    list(LENGTH includes count)
    if(count EQUAL 0)
        return()
    endif()
    math(EXPR last "(${count} - 1) / ${openfab_unit_sources}")
    set(united)
    foreach(number RANGE ${last})
        math(EXPR begin "${number} * ${openfab_unit_sources}")
        list(SUBLIST includes ${begin} ${openfab_unit_sources} text)
        list(JOIN text "" text)
        set(unit ${CMAKE_BINARY_DIR}/generated/units/${target}_${number}.cpp)
        file(CONFIGURE OUTPUT ${unit} CONTENT "${text}" @ONLY)
        list(APPEND united ${unit})
    endforeach()
    set_property(TARGET ${target} PROPERTY SOURCES ${united} ${others})
endfunction()
