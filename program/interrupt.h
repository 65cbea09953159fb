// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Ctrl-C: the first one asks the print to end after the slices in flight, the second ends the
// process at once.

#include <atomic>

namespace openfab::print {

/// Sets the handlers of SIGINT and SIGTERM, ignores SIGPIPE and SIGXFSZ (a closed pipe and a file
/// above the limit are then write errors with a message), and returns the flag that the first
/// signal sets.
const std::atomic<bool>& install_interrupt();

}  // namespace openfab::print
