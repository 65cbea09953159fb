// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/system_reason.h"

#include <cerrno>
#include <system_error>

namespace openfab {

std::string system_reason(int code) {
    std::string words = std::generic_category().message(code);
    if (code == EMFILE) words += "; allow more (`ulimit -n`)";
    if (code == EFBIG) words += "; perhaps `ulimit -f` limits it";
    if (code == ENOMEM) words += "; allow more (`ulimit -v`), or free some";
    if (code == EAGAIN) words += "; allow more processes and threads (`ulimit -u`)";
    return words;
}

}  // namespace openfab
