// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/kernel_profile.h"

#include <HalideRuntime.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <utility>

namespace openfab::lower {

namespace {

constexpr std::chrono::microseconds kInterval{500};

struct FuncName {
    std::string function, func;
};

#if HALIDE_VERSION_MAJOR >= 19
/// Each call has its own, on its stack. The Func in it is an index into its kernel's, not a token.
using State = halide_profiler_instance_state;
#else
/// Each thread has its own.
using State = halide_profiler_state;
#endif

/// Where a call says which Func it is at.
struct Note {
    State* state;
    int first;  ///< what is added to it to make a token
};

/// What all profiled kernels of the process write to. It is never destroyed: a kernel may end after
/// everything else.
struct Registry {
    std::mutex mutex;
    std::vector<Note> notes;
    std::vector<FuncName> funcs;  ///< by token + index of the Func in its kernel
    std::map<std::string, int, std::less<>> kernels;  ///< token by name

    static Registry& get() {
        static auto* const registry = new Registry;
        return *registry;
    }
};

/// Returns the token of a kernel's first Func. `registry` is locked.
int token_of(Registry& registry, const char* name, int count, const uint64_t* names) {
    const auto known = registry.kernels.find(std::string_view(name));
    if (known != registry.kernels.end()) return known->second;
    const auto token = static_cast<int>(registry.funcs.size());
    for (int k = 0; k < count; ++k)
        registry.funcs.push_back({name, reinterpret_cast<const char*>(names[k])});
    registry.kernels.emplace(name, token);
    return token;
}

#if HALIDE_VERSION_MAJOR >= 19
int begin_call(void* /*user_context*/, const char* name, int count, const uint64_t* names,
               State* call) {
    *call = {};
    Registry& registry = Registry::get();
    const std::lock_guard lock(registry.mutex);
    registry.notes.push_back({call, token_of(registry, name, count, names)});
    return 0;
}

int end_call(void* /*user_context*/, State* call) {
    Registry& registry = Registry::get();
    const std::lock_guard lock(registry.mutex);
    std::erase_if(registry.notes, [&](const Note& note) { return note.state == call; });
    return 0;
}
#else
State* state_of_thread() {
    thread_local State* const state = [] {
        Registry& registry = Registry::get();
        const std::lock_guard lock(registry.mutex);
        auto* const mine = new State{};
        mine->current_func = halide_profiler_outside_of_halide;
        registry.notes.push_back({mine, 0});
        return mine;
    }();
    return state;
}

int begin_call(void* /*user_context*/, const char* name, int count, const uint64_t* names) {
    Registry& registry = Registry::get();
    const std::lock_guard lock(registry.mutex);
    return token_of(registry, name, count, names);
}

halide_profiler_pipeline_stats* pipeline_state(const char* /*name*/) {
    static halide_profiler_pipeline_stats unused{};
    return &unused;
}

void end_call(void* /*user_context*/, void* state) {
    static_cast<State*>(state)->current_func = halide_profiler_outside_of_halide;
}
#endif

void ignore_memory(void* /*user_context*/, void* /*pipeline*/, int /*func*/, uint64_t /*bytes*/) {}
void ignore_stack(void* /*user_context*/, void* /*pipeline*/, uint64_t* /*bytes*/) {}

}  // namespace

const void* profile_symbol(std::string_view name) {
    constexpr std::string_view kPrefix = "halide_profiler_";
    if (!name.starts_with(kPrefix)) return nullptr;
    name.remove_prefix(kPrefix.size());
#if HALIDE_VERSION_MAJOR >= 22
    // What a call begins with has changed.
    return nullptr;
#elif HALIDE_VERSION_MAJOR >= 19
    if (name == "instance_start") return reinterpret_cast<const void*>(&begin_call);
    if (name == "instance_end") return reinterpret_cast<const void*>(&end_call);
#else
    if (name == "get_state") return reinterpret_cast<const void*>(&state_of_thread);
    if (name == "get_pipeline_state") return reinterpret_cast<const void*>(&pipeline_state);
    if (name == "pipeline_start") return reinterpret_cast<const void*>(&begin_call);
    if (name == "pipeline_end") return reinterpret_cast<const void*>(&end_call);
#endif
    if (name == "memory_allocate" || name == "memory_free")
        return reinterpret_cast<const void*>(&ignore_memory);
    if (name == "stack_peak_update") return reinterpret_cast<const void*>(&ignore_stack);
    return nullptr;
}

KernelProfile::KernelProfile() : thread_([this] { look(); }) {}

KernelProfile::~KernelProfile() {
    finish();
}

std::vector<FuncSamples> KernelProfile::finish() {
    {
        const std::lock_guard lock(mutex_);
        over_ = true;
    }
    change_.notify_all();
    if (thread_.joinable()) thread_.join();
    Registry& registry = Registry::get();
    const std::lock_guard lock(registry.mutex);
    std::vector<FuncSamples> out;
    for (size_t k = 0; k < samples_.size(); ++k) {
        if (samples_[k] > 0)
            out.push_back({registry.funcs[k].function, registry.funcs[k].func, samples_[k]});
    }
    std::stable_sort(out.begin(), out.end(), [](const FuncSamples& a, const FuncSamples& b) {
        return a.samples > b.samples;
    });
    return out;
}

void KernelProfile::look() {
    Registry& registry = Registry::get();
    std::unique_lock lock(mutex_);
    while (!change_.wait_for(lock, kInterval, [this] { return over_; })) {
        const std::lock_guard notes(registry.mutex);
        samples_.resize(registry.funcs.size(), 0);
        for (const Note& note : registry.notes) {
            // Kernels write it without more than that.
            const int func = *static_cast<volatile int*>(&note.state->current_func);
            const int token = note.first + func;
            if (func >= 0 && static_cast<size_t>(token) < samples_.size())
                ++samples_[static_cast<size_t>(token)];
        }
    }
}

}  // namespace openfab::lower
