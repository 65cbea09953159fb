// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The functions that kernels call: of Halide's runtime, of ours, and of C's library.

#include <HalideRuntime.h>

#include <algorithm>
#include <cstring>
#include <iterator>

#include "abi/nearest_stage.h"
#include "abi/stage_table.h"
#include "compiler/lower/code/kernel_profile.h"
#include "compiler/lower/code/load_code.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

struct KernelSymbol {
    std::string_view name;
    const void* address;
};

#define OPENFAB_KERNEL_SYMBOL(name) {#name, reinterpret_cast<const void*>(&(name))},
#if defined(__x86_64__)
#define OPENFAB_WIDER_SYMBOL(name) OPENFAB_KERNEL_SYMBOL(name)
#else
#define OPENFAB_WIDER_SYMBOL(name)
#endif
const KernelSymbol kSymbols[] = {
// Halide's errors, from its header.
#include "compiler/lower/code/halide_errors.inc"
    OPENFAB_KERNEL_SYMBOL(halide_error) OPENFAB_KERNEL_SYMBOL(halide_do_par_for)
        OPENFAB_KERNEL_SYMBOL(halide_do_parallel_tasks) OPENFAB_KERNEL_SYMBOL(halide_semaphore_init)
            OPENFAB_KERNEL_SYMBOL(halide_semaphore_release) OPENFAB_KERNEL_SYMBOL(
                halide_semaphore_try_acquire) OPENFAB_KERNEL_SYMBOL(halide_malloc)
                OPENFAB_KERNEL_SYMBOL(halide_free) OPENFAB_KERNEL_SYMBOL(openfab_sample_sse41)
                    OPENFAB_WIDER_SYMBOL(openfab_sample_avx2)
                        OPENFAB_KERNEL_SYMBOL(openfab_nearest){
                            "memcpy",
                            reinterpret_cast<const void*>(
                                static_cast<void* (*)(void*, const void*, size_t)>(std::memcpy))},
    {"memmove", reinterpret_cast<const void*>(
                    static_cast<void* (*)(void*, const void*, size_t)>(std::memmove))},
    {"memset",
     reinterpret_cast<const void*>(static_cast<void* (*)(void*, int, size_t)>(std::memset))},
};
#undef OPENFAB_WIDER_SYMBOL
#undef OPENFAB_KERNEL_SYMBOL

/// Brings the hooks of Halide's runtime (abi/halide_hooks.h) with it.
[[gnu::used]] const openfab_stages* const kStages = &openfab_stage_table;

}  // namespace

const void* kernel_symbol(std::string_view name) {
    const auto* const found =
        std::find_if(std::begin(kSymbols), std::end(kSymbols),
                     [&](const KernelSymbol& symbol) { return symbol.name == name; });
    return found != std::end(kSymbols) ? found->address : profile_symbol(name);
}

}  // namespace openfab::lower
