// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/interrupt.h"

#include <unistd.h>

#include <csignal>
#include <cstring>

#include "base/clean_exit.h"

namespace openfab::program {

namespace {

// Signal handlers can only use globals.
std::atomic<bool> interrupted{false};  // once set, it stays
std::atomic<bool> keeps_slices{false};
std::atomic<int> exit_code_at_once{0};
std::atomic<const char*> text_at_once{""};
static_assert(std::atomic<bool>::is_always_lock_free &&
                  std::atomic<const char*>::is_always_lock_free,
              "a handler must not wait");

void on_signal(int) {
    if (keeps_slices.load() && !interrupted.exchange(true)) return;
    const char* const text = text_at_once.load();
    // A message that cannot be written is ignored.
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text, std::strlen(text));
    end_cleanly(exit_code_at_once.load());
}

}  // namespace

const std::atomic<bool>& install_interrupt(int exit_code, const char* text) {
    exit_code_at_once.store(exit_code);
    text_at_once.store(text);
    struct sigaction action {};
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    // `nohup` has it ignored.
    struct sigaction before {};
    if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, nullptr);
    end_with_starter();
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    return interrupted;
}

DeferredInterrupt::DeferredInterrupt() {
    keeps_slices.store(true);
}

DeferredInterrupt::~DeferredInterrupt() {
    keeps_slices.store(false);
}

}  // namespace openfab::program
