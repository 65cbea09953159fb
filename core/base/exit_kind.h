// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The reading of exit codes of our own programs: the reverse of `exit_code` (result.h). One that a signal ends has 130,
// by whichever signal, as it writes the one line that says so (clean_exit.h).

#include "base/result.h"

namespace openfab {

/// What a shell adds to the number of the signal that ended a program.
constexpr int kExitBySignal = 128;

/// Returns the kind of trouble of a program that ended with `status`, as a shell gives it. One that was ended before it
/// could say that it was interrupted, was; one that was killed failed by the outside world.
constexpr ErrorCode kind_of_exit(int status) {
    constexpr int kHangUp = 1, kKill = 9, kTerminate = 15;
    for (const ErrorCode code : {ErrorCode::kUserInput, ErrorCode::kUsage, ErrorCode::kOutside,
                                 ErrorCode::kInternal, ErrorCode::kInterrupted}) {
        if (status == exit_code(code)) return code;
    }
    if (status == kExitBySignal + kHangUp || status == kExitBySignal + kTerminate)
        return ErrorCode::kInterrupted;
    return status == kExitBySignal + kKill ? ErrorCode::kOutside : ErrorCode::kInternal;
}

}  // namespace openfab
