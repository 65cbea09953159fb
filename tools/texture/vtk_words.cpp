// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/vtk_words.h"

#include "tools/texture/messages.h"

namespace openfab::tools {

Result<std::string> VtkWords::word() {
    constexpr size_t kLongest = 4096;
    std::string out;
    for (;;) {
        const Result<int> c = peek();
        if (!c) return c.error();
        const bool blank = *c == ' ' || *c == '\t' || *c == '\r' || *c == '\n';
        if (*c < 0 || (blank && !out.empty())) return out;
        if (!blank) out += static_cast<char>(*c);
        if (out.size() > kLongest) return user_error(messages::kWordTooLong);
        pass(*c);
    }
}

Result<std::string> VtkWords::rest_of_line() {
    constexpr size_t kLongest = 65536;
    std::string out;
    for (;;) {
        const Result<int> c = peek();
        if (!c) return c.error();
        if (*c >= 0) pass(*c);
        if (*c < 0 || *c == '\n') break;
        out += static_cast<char>(*c);
        if (out.size() > kLongest) return user_error(messages::kLineTooLong);
    }
    if (!out.empty() && out.back() == '\r') out.pop_back();
    return out;
}

Result<int> VtkWords::peek() {
    if (next_ == held_) {
        window_ += static_cast<int64_t>(held_);
        next_ = 0;
        const Result<size_t> got = file_.read(window_, buffer_.data(), buffer_.size());
        if (!got) return got.error();
        held_ = *got;
        if (held_ == 0) return -1;
    }
    return static_cast<unsigned char>(buffer_[next_]);
}

std::string decoded_vtk_name(const std::string& name) {
    std::string out;
    for (size_t i = 0; i < name.size(); ++i) {
        int64_t code = 0;
        const auto digit = [](char c) {
            return (c >= '0' && c <= '9')   ? c - '0'
                   : (c >= 'a' && c <= 'f') ? c - 'a' + 10
                   : (c >= 'A' && c <= 'F') ? c - 'A' + 10
                                            : -1;
        };
        const bool coded = name[i] == '%' && i + 2 < name.size() && digit(name[i + 1]) >= 0 &&
                           digit(name[i + 2]) >= 0;
        if (coded) code = digit(name[i + 1]) * 16 + digit(name[i + 2]);
        out += coded ? static_cast<char>(code) : name[i];
        i += coded ? 2 : 0;
    }
    return out;
}

}  // namespace openfab::tools
