// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/plain_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/messages.h"

namespace openfab {
namespace {

/// Returns the first carriage return at or behind `at` that ends a line by itself; those before a
/// line feed or at the end do not count.
size_t lone_return(std::string_view text, size_t at) {
    for (;;) {
        at = text.find('\r', at);
        if (at == std::string_view::npos) return at;
        const size_t behind = text.find_first_not_of('\r', at);
        if (behind == std::string_view::npos) return behind;
        if (text[behind] != '\n') return at;
        at = behind;
    }
}

}  // namespace

std::string_view wide_encoding(std::string_view bytes) {
    using namespace std::string_view_literals;
    if (bytes.starts_with("\xFF\xFE\0\0"sv) || bytes.starts_with("\0\0\xFE\xFF"sv)) return "UTF-32";
    if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) return "UTF-16";
    // Without a mark: ASCII with a zero before or behind each byte.
    const std::string_view start = bytes.substr(0, std::min<size_t>(bytes.size(), 32) & ~size_t{1});
    if (start.size() < 8) return {};
    for (const size_t zero : {size_t{0}, size_t{1}}) {
        bool wide = true;
        for (size_t i = 0; i < start.size(); i += 2)
            wide = wide && start[i + zero] == '\0' && start[i + 1 - zero] != '\0';
        if (wide) return "UTF-16";
    }
    return {};
}

Complaint not_utf8(std::string_view bytes) {
    const std::string_view encoding = wide_encoding(bytes);
    if (encoding.empty()) return {};
    return {fmt::format(messages::kWideText, encoding), messages::kWideTextHelp};
}

PlainText::PlainText(std::string_view bytes) : bytes_(bytes) {
    if (bytes_.starts_with(kByteOrderMark)) bytes_.remove_prefix(kByteOrderMark.size());
    if (lone_return(bytes_, 0) != std::string_view::npos)
        copied_ = with_line_feeds(std::string(bytes_));
}

std::string PlainText::with_line_feeds(std::string text) {
    for (size_t at = 0; (at = lone_return(text, at)) != std::string::npos;)
        text[at] = '\n';
    return text;
}

}  // namespace openfab
