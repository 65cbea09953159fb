// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/stage_table.h"

#include <HalideRuntime.h>

#include "abi/halide_hooks.h"

// The symbols that stage_gen compiled.
extern "C" {
#if defined(__x86_64__)
#define DECLARE(name)                        \
    int openfab_##name##_sse41_argv(void**); \
    int openfab_##name##_avx2_argv(void**);
#define KERNELS(name) \
    { openfab_##name##_sse41_argv, openfab_##name##_avx2_argv }
#else
#define DECLARE(name) int openfab_##name##_sse41_argv(void**);
#define KERNELS(name) \
    { openfab_##name##_sse41_argv, nullptr }
#endif
DECLARE(normalise)
DECLARE(pack4)
DECLARE(pack8)
#undef DECLARE
}

namespace {

// Whoever uses the table has the hooks too: an archive's members are linked only where something
// refers to them.
[[maybe_unused]] const bool hooks_installed = [] {
    halide_set_error_handler(openfab::abi::keep_kernel_error);
    halide_set_custom_do_par_for(openfab::abi::run_kernel_loop);
    return true;
}();

}  // namespace

extern "C" const openfab_stages openfab_stage_table = {KERNELS(normalise), KERNELS(pack4),
                                                       KERNELS(pack8)};
#undef KERNELS
