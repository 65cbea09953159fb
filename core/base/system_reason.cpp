// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/system_reason.h"

#include <sys/resource.h>

#include <cerrno>
#include <system_error>

#include "base/messages.h"

namespace openfab {

std::string system_reason(int code) {
    std::string words = std::generic_category().message(code);
    if (code == EMFILE) words += messages::kAllowMoreFiles;
    if (code == EFBIG) words += messages::kFileSizeLimited;
    if (code == ENOMEM) words += messages::kAllowMoreAddresses;
    // Of a thread whose stack finds no addresses the system says the same as of one too many.
    rlimit addresses{};
    const bool limited =
        ::getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY;
    if (code == EAGAIN)
        words += limited ? messages::kAllowMoreThreads : messages::kAllowMoreProcesses;
    return words;
}

}  // namespace openfab
