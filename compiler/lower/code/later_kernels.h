// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Kernels that are compiled while a program already runs. The interval form of the volume stage is
// often the slowest kernel to compile, and the only one that a print can do without: where nothing
// is known of a block its voxels are evaluated, to the same bits. So `openflc run` shows the first
// slices of a changed fablet without waiting for it, and culls from when it is there.

#include <atomic>
#include <deque>
#include <optional>
#include <thread>
#include <variant>
#include <vector>

#include "compiler/lower/code/load_code.h"
#include "compiler/lower/code/program.h"

namespace openfab::lower {

/// Returns whether a print can do without a kernel.
bool can_come_later(const KernelUnit& unit);

class LaterKernels {
  public:
    /// `cache` may be null; it and the entries that are added must outlive this object.
    explicit LaterKernels(KernelCache* cache) : cache_(cache) {}
    /// Waits for the kernel that is being compiled and gives up the others.
    ~LaterKernels();
    LaterKernels(const LaterKernels&) = delete;
    LaterKernels& operator=(const LaterKernels&) = delete;

    /// Adds a kernel with its entry in the table, before `start`. Returns its function, for any
    /// number of threads, or what went wrong: it says that nothing is known until the kernel is
    /// there.
    std::variant<openfab_kernel_fn, std::string> add(const KernelUnit& unit,
                                                     const openfab_kernel& entry);
    /// Starts compiling, one kernel after the other, behind whatever else this machine does. Of
    /// several objects one compiles at a time.
    void start();
    /// Gives up those that are not being compiled yet.
    void give_up() { given_up_ = true; }
    bool done() const { return done_; }
    /// Waits for all, and returns what they took or the first fault.
    std::variant<std::vector<KernelTime>, Fault> finish();

  private:
    struct Kernel {
        ir::Stage stage;
        KernelUnit unit;
        const openfab_kernel* entry = nullptr;
        LoadedKernel caller;  ///< calls `call` with this
        LoadedKernel loaded;
        std::atomic<openfab_kernel_fn> function{nullptr};  ///< of `loaded`, once it is there
    };

    static int call(void** args, void* kernel);
    void run();
    std::optional<Fault> make(Kernel* kernel);

    KernelCache* cache_;
    std::deque<Kernel> kernels_;
    std::vector<KernelTime> times_;
    std::optional<Fault> fault_;
    std::atomic<bool> given_up_{false};
    std::atomic<bool> done_{true};
    std::thread thread_;
};

}  // namespace openfab::lower
