// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/interrupt.h"

#include <csignal>

namespace openfab::print {

namespace {

// A signal handler has no other way to anything: the one mutable global, set once and only ever to
// true.
std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a handler must not wait");

void on_signal(int) {
    interrupted.store(true);
}

}  // namespace

const std::atomic<bool>& install_interrupt() {
    struct sigaction action {};
    action.sa_handler = on_signal;
    // After the first signal the default action is back, so that a second one ends a process that
    // hangs.
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    return interrupted;
}

}  // namespace openfab::print
