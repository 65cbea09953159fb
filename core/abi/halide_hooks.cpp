// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "abi/halide_hooks.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <atomic>
#include <cstring>

namespace openfab::abi {

namespace {

thread_local char last_error[512];

}  // namespace

void keep_kernel_error(void* /*user_context*/, const char* message) {
    std::strncpy(last_error, message, sizeof(last_error) - 1);
    last_error[sizeof(last_error) - 1] = '\0';
}

// Isolated, so that a thread that waits for the loop steals no other work: it may hold the scratch
// memory of a block row in progress.
int run_kernel_loop(void* user_context, KernelTask task, int min, int size, uint8_t* closure) {
    std::atomic<int> status{0};
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(min, min + size, [&](int i) {
            const int result = task(user_context, i, closure);
            if (result != 0) status.store(result, std::memory_order_relaxed);
        });
    });
    return status.load();
}

std::string take_kernel_error() {
    std::string text = last_error;
    last_error[0] = '\0';
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    return text;
}

}  // namespace openfab::abi
