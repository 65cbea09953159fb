// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/abi/stage_table.h"

#include <HalideRuntime.h>

#include "runtime/abi/halide_hooks.h"

// The symbols that stage_gen compiled; the list of sizes is also in CMakeLists.txt.
#define OPENFAB_MATERIAL_COUNTS(DO) DO(1) DO(2) DO(3) DO(4) DO(6) DO(8) DO(12) DO(15)

extern "C" {
#define DECLARE(m)                                  \
    int openfab_normalise_##m##_sse41_argv(void**); \
    int openfab_normalise_##m##_avx2_argv(void**);  \
    int openfab_dither_##m##_sse41_argv(void**);    \
    int openfab_dither_##m##_avx2_argv(void**);
OPENFAB_MATERIAL_COUNTS(DECLARE)
#undef DECLARE
int openfab_pack_0_sse41_argv(void**);
int openfab_pack_0_avx2_argv(void**);
}

namespace {

const openfab_stage_set kSets[] = {
#define SET(m)                                                                \
    {m,                                                                       \
     {openfab_normalise_##m##_sse41_argv, openfab_normalise_##m##_avx2_argv}, \
     {openfab_dither_##m##_sse41_argv, openfab_dither_##m##_avx2_argv}},
    OPENFAB_MATERIAL_COUNTS(SET)
#undef SET
};

// Whoever uses the table has the hooks too: an archive's members are linked only where something
// refers to them.
[[maybe_unused]] const bool hooks_installed = [] {
    halide_set_error_handler(openfab::abi::keep_kernel_error);
    halide_set_custom_do_par_for(openfab::abi::run_kernel_loop);
    return true;
}();

}  // namespace

extern "C" const openfab_stages openfab_stage_table = {
    sizeof(kSets) / sizeof(kSets[0]), kSets, {openfab_pack_0_sse41_argv, openfab_pack_0_avx2_argv}};
