// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/jail_line.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace openfab {

void JailLine::bytes(void* data, size_t count) {
    auto* at = static_cast<char*>(data);
    const size_t all = count;
    while (count > 0 && fine_) {
        const ssize_t done =
            sends_ ? ::write(descriptor_, at, count) : ::read(descriptor_, at, count);
        if (done < 0 && errno == EINTR) continue;
        if (done <= 0) {
            fine_ = false;
            break;
        }
        at += done;
        count -= static_cast<size_t>(done);
    }
    if (!fine_ && !sends_ && all > 0) std::memset(data, 0, all);
}

bool JailLine::take(uint64_t count, size_t bytes_each) {
    if (count > static_cast<uint64_t>(left_) / bytes_each) {
        fine_ = false;
        return false;
    }
    left_ -= static_cast<int64_t>(count * bytes_each);
    return true;
}

void pass(JailLine* line, Error* error) {
    auto code = static_cast<int32_t>(error->code);
    pass(line, &code);
    if (code < 0 || code > static_cast<int32_t>(ErrorCode::kInterrupted)) line->fail();
    error->code = static_cast<ErrorCode>(code);
    pass(line, &error->message);
    pass(line, &error->help);
    pass(line, &error->location);
}

}  // namespace openfab
