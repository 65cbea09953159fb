// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/interrupt.h"

#include <unistd.h>

#include <array>
#include <csignal>
#include <deque>
#include <utility>

#include "base/clean_exit.h"

namespace openfab::program {

namespace {

/// How long work has to end in order after a first signal.
constexpr unsigned kGraceSeconds = 1;

// Signal handlers can only use globals.
std::atomic<bool> interrupted{false};  // once set, it stays
std::atomic<bool> keeps_slices{false};
std::atomic<int> signal_number{0};
std::atomic<int64_t> signal_sender{0};
std::atomic<int> exit_code_at_once{0};
std::atomic<const char*> text_at_once{""};
std::array<std::atomic<int64_t>, 2> counts{};
static_assert(std::atomic<bool>::is_always_lock_free &&
                  std::atomic<const char*>::is_always_lock_free &&
                  std::atomic<int64_t>::is_always_lock_free,
              "a handler must not wait");

/// Writes the text with the counts. A message that cannot be written is ignored.
void write_text() {
    std::array<char, 1024> out;
    constexpr size_t kLongestNumber = 20;
    size_t size = 0, next = 0;
    for (const char* at = text_at_once.load(); *at != 0 && size + kLongestNumber < out.size();
         ++at) {
        if (at[0] != '{' || at[1] != '}' || next == counts.size()) {
            out[size++] = *at;
            continue;
        }
        std::array<char, kLongestNumber> digits;
        size_t length = 0;
        int64_t left = counts[next++].load();
        do {
            digits[length++] = static_cast<char>('0' + left % 10);
            left /= 10;
        } while (left > 0);
        while (length > 0)
            out[size++] = digits[--length];
        ++at;
    }
    [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, out.data(), size);
}

void on_signal(int signal, siginfo_t* info, void*) {
    if (signal == SIGALRM && !keeps_slices.load()) return;  // it has ended in order
    if (signal != SIGALRM && signal_number.exchange(signal) == 0)
        signal_sender.store(info != nullptr && info->si_code <= 0 ? info->si_pid : 0);
    if (signal != SIGALRM && keeps_slices.load() && !interrupted.exchange(true)) {
        alarm(kGraceSeconds);
        return;
    }
    begin_ending();
    write_text();
    end_cleanly(exit_code_at_once.load());
}

/// Keeps a text for as long as the process: a handler may be reading any.
const char* kept(std::string text) {
    static std::deque<std::string> all;
    return all.emplace_back(std::move(text)).c_str();
}

}  // namespace

const std::atomic<bool>& install_interrupt(int exit_code, const char* text) {
    exit_code_at_once.store(exit_code);
    text_at_once.store(text);
    struct sigaction action {};
    action.sa_sigaction = on_signal;
    action.sa_flags = SA_SIGINFO;
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    sigaction(SIGALRM, &action, nullptr);
    // `nohup` has it ignored.
    struct sigaction before {};
    if (sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, nullptr);
    end_with_starter();
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    return interrupted;
}

StopSignal last_stop_signal() {
    return {signal_number.load(), signal_sender.load()};
}

DeferredInterrupt::DeferredInterrupt() : text_before_(text_at_once.load()) {
    keeps_slices.store(true);
}

DeferredInterrupt::~DeferredInterrupt() {
    keeps_slices.store(false);
    text_at_once.store(text_before_);
}

void DeferredInterrupt::say(std::string text) {
    text_at_once.store(kept(std::move(text)));
}

void DeferredInterrupt::count(int64_t done, int64_t total) {
    counts[0].store(done);
    counts[1].store(total);
}

}  // namespace openfab::program
