// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/base64.h"

namespace openfab {

bool Base64Decoder::add(std::string_view text, std::string* out) {
    constexpr std::string_view kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    constexpr std::string_view kBlanks = " \t\r\n";
    for (const char c : text) {
        if (c == '=') {
            held_ = 0;
            continue;
        }
        if (kBlanks.find(c) != std::string_view::npos) continue;
        const size_t digit = kDigits.find(c);
        if (digit == std::string_view::npos) return false;
        bits_ = bits_ << 6 | static_cast<uint32_t>(digit);
        held_ += 6;
        if (held_ < 8) continue;
        held_ -= 8;
        out->push_back(static_cast<char>(bits_ >> held_ & 0xff));
    }
    return true;
}

std::string decode_base64(std::string_view text) {
    std::string out;
    out.reserve(text.size() / 4 * 3);
    return Base64Decoder().add(text, &out) ? out : std::string();
}

}  // namespace openfab
