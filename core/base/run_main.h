// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace openfab {

/// Runs a program. Our code throws nothing, but libraries do, above all where memory runs out: such an
/// exception ends the program with a message and an exit code of its own instead of an abort.
int run_main(int (*program)(int argc, char** argv), int argc, char** argv) noexcept;

}  // namespace openfab
