// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/stage_table.h"

#include <HalideRuntime.h>

#include "abi/halide_hooks.h"

// The symbols that stage_gen compiled; the list of sizes is also in CMakeLists.txt.
#define OPENFAB_MATERIAL_COUNTS(DO) \
    DO(1) DO(2) DO(3) DO(4) DO(6) DO(8) DO(12) DO(15) DO(24) DO(32) DO(48) DO(64)

extern "C" {
#define DECLARE(name, m)                           \
    int openfab_##name##_##m##_sse41_argv(void**); \
    int openfab_##name##_##m##_avx2_argv(void**);
#define DECLARE_NORMALISE(m) DECLARE(normalise, m)
OPENFAB_MATERIAL_COUNTS(DECLARE_NORMALISE)
DECLARE(pack, 4)
DECLARE(pack, 8)
#undef DECLARE_NORMALISE
#undef DECLARE
}

namespace {

#define KERNELS(name, m) \
    { openfab_##name##_##m##_sse41_argv, openfab_##name##_##m##_avx2_argv }
const openfab_stage_set kSets[] = {
#define SET(m) {m, KERNELS(normalise, m)},
    OPENFAB_MATERIAL_COUNTS(SET)
#undef SET
};

// Refers to the hooks, so that they are linked with the table: members of an archive are linked
// only if something refers to them.
[[maybe_unused]] const bool hooks_installed = [] {
    halide_set_error_handler(openfab::abi::keep_kernel_error);
    halide_set_custom_do_par_for(openfab::abi::run_kernel_loop);
    return true;
}();

}  // namespace

extern "C" const openfab_stages openfab_stage_table = {sizeof(kSets) / sizeof(kSets[0]), kSets,
                                                       KERNELS(pack, 4), KERNELS(pack, 8)};
#undef KERNELS
