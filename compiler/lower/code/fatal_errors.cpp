// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/code/fatal_errors.h"

#include <dlfcn.h>

#include <cstdlib>

namespace openfab::lower {

namespace {

void (*end_by)(const Fault& fault) = nullptr;

/// LLVM's C interface, which all versions have (llvm-c/ErrorHandling.h).
using Handler = void (*)(const char* reason);
using InstallHandler = void (*)(Handler handler);

void on_fatal_error(const char* reason) {
    end_by(fault_of(reason));
    std::abort();
}

}  // namespace

void end_fatal_errors_by(void (*end)(const Fault& fault)) {
    end_by = end;
    // We link Halide alone, which brings LLVM with it; one that holds LLVM inside hides it.
    void* const install = ::dlsym(RTLD_DEFAULT, "LLVMInstallFatalErrorHandler");
    if (install != nullptr) reinterpret_cast<InstallHandler>(install)(on_fatal_error);
}

}  // namespace openfab::lower
