# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# The tests that each push runs under sanitizers (scripts/test --all): what reads a user's bytes, and what computes addresses.
# They have the label `sanitized`, and the target `sanitized` makes their programs and no others; a night runs all.
# Left to the night: what compares results of compiled kernels, into which sanitizers do not see, with LLVM in the programs
# (exec, scenes, differential_test, pipeline_test, worlds_test, unit_lower, programs/tools); what neither reads nor has addresses.
set(sanitized_tests
    # Bytes: texts and numbers, worlds, meshes, pictures and volumes, fablets, schedules, what an interrupted print left.
    fuzz/readers_test fuzz/picture_readers_test fuzz/mutations_test
    unit/base_text_test unit/input_file_test unit/json_test unit/hash_test unit/lru_cache_test
    unit/obj_test unit/load_mesh_test unit/reading_memory_test unit/openfab_import_unit_test unit/world_test unit/part_test
    unit/texture_pyramid_test unit/texture_convert_test unit/texture_volume_test unit/texture_vtk_test unit/texture_xdmf_test unit/texture_strangers_files_test unit/texture_oiio_test
    unit/source_test unit/diag_test unit/syntax_test unit/check_language_test unit/translate_test
    unit/interp_test lang/lang_test server/server_test
    unit/print_options_test unit/print_output_check_test
    unit/ofr_test unit/folder_sink_test unit/preview_test unit/mesh_sink_test unit/gcvf_test
    programs/print_resume_test programs/print_refusals_test programs/print_pipes_and_disks_test
    property/foreign_meshes_test
    # Addresses: trees and their kernels, dicing, coverage, dither, packing, slabs, segments, culling, support, output.
    unit/nearest_unit unit/surface_test unit/shape_solid_test unit/near_boxes_test unit/split_search_test unit/voxel_test unit/stages_test unit/simd_operations_test unit/pipeline_unit_test
    property/nearest_engine_equals_brute_force property/nearest_bounds_hold property/nearest_points_equal_brute_force
    property/nearest_treelets_are_built_once property/nearest_winding_is_exact property/nearest_attributes_are_the_winners
    property/nearest_any_thread_count property/nearest_sides_agree_with_coverage property/nearest_whole_parts_are_exact
    property/surface_property_test property/voxel_property_test property/cuts_test property/point_queries_test
    property/dither_means_test property/dither_skin_test property/dither_pattern_test property/depth_map_test
    property/support_print_test property/box_print_test property/back_pressure_test property/boundary_property_test)

# Those that a night runs under the thread sanitizer: whole prints by kernels made by hand, and what threads share. They have the
# label `threaded`, and the target of that name.
set(threaded_tests
    unit/plain_threads_test unit/lru_cache_test unit/pipeline_unit_test
    property/nearest_any_thread_count property/support_print_test property/box_print_test property/back_pressure_test)

# When all tests are known.
function(openfab_add_sanitized)
    foreach(kind sanitized threaded)
        get_property(names GLOBAL PROPERTY openfab_${kind}_tests)
        set(unknown ${${kind}_tests})
        list(REMOVE_ITEM unknown ${names})
        if(unknown)
            message(FATAL_ERROR "tests/sanitized.cmake names what is no test: ${unknown}")
        endif()
        get_property(programs GLOBAL PROPERTY openfab_${kind}_programs)
        add_custom_target(${kind})
        add_dependencies(${kind} ${programs})
    endforeach()
endfunction()
