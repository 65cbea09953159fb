// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/transport.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "base/text.h"

namespace openfab::server {

std::optional<std::string> MessageReader::next() {
    if (broken_) return std::nullopt;
    if (!length_) {
        const size_t end = buffer_.find("\r\n\r\n");
        broken_ = end > kMaxHeaderBytes && buffer_.size() > kMaxHeaderBytes;
        if (broken_ || end == std::string::npos) return std::nullopt;
        broken_ = !read_header(std::string_view(buffer_).substr(0, end));
        if (broken_) return std::nullopt;
        buffer_.erase(0, end + 4);
    }
    if (buffer_.size() < *length_) return std::nullopt;
    std::string message = buffer_.substr(0, *length_);
    buffer_.erase(0, *length_);
    length_.reset();
    return message;
}

bool MessageReader::read_header(std::string_view header) {
    while (!header.empty()) {
        const size_t end = std::min(header.find("\r\n"), header.size());
        const std::string_view line = header.substr(0, end);
        header.remove_prefix(std::min(end + 2, header.size()));
        const size_t colon = line.find(':');
        if (colon == std::string_view::npos) return false;
        if (lower_ascii(std::string(line.substr(0, colon))) != "content-length") continue;
        std::string_view digits = line.substr(colon + 1);
        while (digits.starts_with(' '))
            digits.remove_prefix(1);
        size_t length = 0;
        const auto [last, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), length);
        const bool whole = error == std::errc{} && last == digits.data() + digits.size();
        if (!whole || length > kMaxMessageBytes || length_) return false;
        length_ = length;
    }
    return length_.has_value();
}

std::string framed(std::string_view message) {
    return fmt::format("Content-Length: {}\r\n\r\n{}", message.size(), message);
}

}  // namespace openfab::server
