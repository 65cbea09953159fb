// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string_view>

namespace openfab {

/// Writes all of `bytes` to an open file; returns 0 or the error's number.
inline int write_all(int descriptor, std::string_view bytes) {
    while (!bytes.empty()) {
        // Linux writes at most 2 GiB at once.
        const ssize_t wrote =
            ::write(descriptor, bytes.data(), std::min<size_t>(bytes.size(), 1U << 30));
        if (wrote < 0 && errno != EINTR) return errno;
        if (wrote > 0) bytes.remove_prefix(static_cast<size_t>(wrote));
    }
    return 0;
}

}  // namespace openfab
