// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which Funcs the kernels of this process spend their time in. Kernels that are compiled for it
// (KernelRequest::profiled) note the Func that they are at; a thread of ours looks every half
// millisecond. Halide's own profiler keeps one such note for all threads, so that calls at once
// overwrite each other's: here every thread has one. What a kernel computes is the same.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace openfab::lower {

/// How often a Func was seen at work.
struct FuncSamples {
    std::string function;  ///< of the kernel, KernelRequest::function
    std::string func;
    int64_t samples = 0;
};

/// Looks while it lives. At most one lives at a time.
class KernelProfile {
  public:
    KernelProfile();
    ~KernelProfile();
    KernelProfile(const KernelProfile&) = delete;
    KernelProfile& operator=(const KernelProfile&) = delete;

    /// Stops looking and returns what was seen, the most frequent first.
    std::vector<FuncSamples> finish();

  private:
    void look();

    std::mutex mutex_;
    std::condition_variable change_;
    bool over_ = false;
    std::vector<int64_t> samples_;  ///< by token
    std::thread thread_;
};

/// Returns the address of the function that profiled kernels call by this name of Halide's profiler;
/// null for other names.
const void* profile_symbol(std::string_view name);

}  // namespace openfab::lower
