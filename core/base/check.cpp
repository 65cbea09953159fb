// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/check.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

namespace openfab {

void check_failed(const char* file, int line, const char* expression, const std::string& values) {
    // Not through say.h: this must be written whatever else is broken.
    fmt::print(stderr, "{}:{}: internal error: `{}` does not hold{}{}\n", file, line, expression,
               values.empty() ? "" : ": ", values);
    (void)std::fflush(stderr);
    std::abort();
}

namespace check_detail {

std::string text_of(long long value) {
    return std::to_string(value);
}
std::string text_of(unsigned long long value) {
    return std::to_string(value);
}
std::string text_of(double value) {
    return fmt::format("{}", value);
}
std::string text_of(const void* value) {
    return fmt::format("{}", value);
}

}  // namespace check_detail
}  // namespace openfab
