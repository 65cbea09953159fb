// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace openfab {

/// Runs a program. Our code throws nothing, but libraries do, above all where memory runs out: such an
/// exception ends the program with a message and an exit code of its own instead of an abort.
int run_main(int (*program)(int argc, char** argv), int argc, char** argv) noexcept;

/// Runs `body` and returns its exit code; after an exception one with a message, as above.
int run_guarded(const std::function<int()>& body) noexcept;

/// Runs what a thread does; an exception ends the process as above.
void run_thread(const std::function<void()>& body) noexcept;

}  // namespace openfab
