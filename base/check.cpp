// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/check.h"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace openfab {

namespace {

/// Strips the path of the source tree.
std::string_view in_source(std::string_view file) {
    constexpr std::string_view kOwn = __FILE__;
    constexpr std::string_view kInSource = "base/check.cpp";
    static_assert(kOwn.ends_with(kInSource));
    const std::string_view root = kOwn.substr(0, kOwn.size() - kInSource.size());
    if (file.starts_with(root)) file.remove_prefix(root.size());
    return file;
}

}  // namespace

void check_failed(const char* file, int line, const char* expression, const std::string& values) {
    // Not through say.h: this must be written whatever else is broken.
    fmt::print(stderr, "{}:{}: internal error: `{}` does not hold{}{}\n", in_source(file), line,
               expression, values.empty() ? "" : ": ", values);
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
