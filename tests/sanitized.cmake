# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# The tests that each push runs under sanitizers (scripts/test --all): what reads a user's bytes, and what computes addresses. They
# are all of the folders below but those that are left to the night, which runs every test under sanitizers; a new test of these
# folders is one of them. They have the label `sanitized`, and the target `sanitized` makes their programs and no others.
set(sanitized_folders fuzz lang property server unit)

# Left to the night: LLVM is in the program, to compile kernels, into which sanitizers do not see.
set(left_compiled
    fuzz/differential_test property/pieces_test property/pipeline_test property/worlds_test unit/unit_lower unit/unit_tuner
    unit/passes_page_test)
# Left to the night: neither a user's bytes nor addresses; the compiler's algebra is compared with itself.
set(left_algebra
    property/property_function_bounds property/property_interval property/property_demand property/property_looks
    property/property_query_interval unit/functions_test unit/ir_test unit/unit_passes unit/unit_schedule unit/stdlib_test)
# Left to the night: neither of both; texts, clocks, threads, files of ours, what a child says and how it ends, which sanitizers change.
set(left_plain
    unit/check_test unit/deadline_test unit/near_miss_test unit/run_main_test unit/stage_timer_test unit/print_words_test
    unit/print_progress_test unit/part_pages_test unit/report_test unit/layer_clock_test unit/property_table_test unit/blue_noise_test
    unit/replace_file_test unit/own_folder_test unit/child_test unit/power_loss_test unit/power_loss_files_test unit/jail_test
    unit/catalogues_test unit/texture_optional_converter_test)
# Left to the night: what it costs is more than it finds; the same code is in tests that run.
set(left_costly
    property/nearest_lattices_equal_brute_force property/offset_test unit/unit_render unit/color_test server/lsp_client
    unit/gcvf_print_test unit/graph_test unit/inspection_test unit/opening_test unit/slicer_test unit/unit_mechanics)
set(left_to_the_night ${left_compiled} ${left_algebra} ${left_plain} ${left_costly})

# Of the folders whose programs are compared whole (crossings, exec, format, golden, package, programs, scenes, support): what an
# interrupted print left, what is refused, full disks.
set(sanitized_too programs/print_resume_test programs/print_resume_others_test programs/print_refusals_test programs/print_pipes_and_disks_test)

# Those that a night runs under the thread sanitizer: whole prints by kernels made by hand, and what threads share. They have the
# label `threaded`, and the target of that name.
set(threaded_tests
    unit/plain_threads_test unit/lru_cache_test unit/pipeline_unit_test unit/grow_threads_test unit/world_parts_test
    property/nearest_any_thread_count property/support_print_test property/box_print_test property/back_pressure_test)

# Whether a test has the label `sanitized` or `threaded`.
function(openfab_runs_under out kind test)
    set(runs OFF)
    if(kind STREQUAL threaded)
        if(test IN_LIST threaded_tests)
            set(runs ON)
        endif()
    else()
        string(REGEX REPLACE "/.*" "" folder ${test})
        if(test IN_LIST sanitized_too OR (folder IN_LIST sanitized_folders AND NOT test IN_LIST left_to_the_night))
            set(runs ON)
        endif()
    endif()
    set(${out} ${runs} PARENT_SCOPE)
endfunction()

# When all tests are known.
function(openfab_add_sanitized)
    set(unknown ${left_to_the_night} ${sanitized_too} ${threaded_tests})
    get_property(names GLOBAL PROPERTY openfab_test_names)
    list(REMOVE_ITEM unknown ${names})
    if(unknown)
        message(FATAL_ERROR "tests/sanitized.cmake names what is no test: ${unknown}")
    endif()
    foreach(kind sanitized threaded)
        get_property(programs GLOBAL PROPERTY openfab_${kind}_programs)
        add_custom_target(${kind})
        add_dependencies(${kind} ${programs})
    endforeach()
endfunction()
