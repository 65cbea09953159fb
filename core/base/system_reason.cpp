// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/system_reason.h"

#include <cerrno>
#include <system_error>

#include "base/messages.h"

namespace openfab {

std::string system_reason(int code) {
    std::string words = std::generic_category().message(code);
    if (code == EMFILE) words += messages::kAllowMoreFiles;
    if (code == EFBIG) words += messages::kFileSizeLimited;
    if (code == ENOMEM) words += messages::kAllowMoreAddresses;
    if (code == EAGAIN) words += messages::kAllowMoreProcesses;
    return words;
}

}  // namespace openfab
