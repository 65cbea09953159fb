// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/stop_reason.h"

#include <string.h>
#include <unistd.h>

#include <string>

#include "program/interrupt.h"

namespace openfab::program {

job::StopReason signal_reason() {
    const StopSignal signal = last_stop_signal();
    job::StopReason reason;
    reason.by = "signal";
    if (const char* name = ::sigabbrev_np(signal.number); name != nullptr)
        reason.signal = std::string("SIG") + name;
    // Our own number stands for the program that started us and is gone.
    if (signal.sender != ::getpid()) reason.sender = signal.sender;
    return reason;
}

job::StopReason stop_reason(const Error& error) {
    if (error.code == ErrorCode::kInterrupted) return signal_reason();
    job::StopReason reason;
    reason.by = error.code == ErrorCode::kUserInput ? "limit" : "error";
    reason.error = error.text();
    return reason;
}

}  // namespace openfab::program
