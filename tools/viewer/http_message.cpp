// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_message.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>

#include "base/text.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kHeadEnd = "\r\n\r\n";
/// Of a Content-Length: enough for any body, and no overflow.
constexpr size_t kMostDigits = 18;

bool is_token(std::string_view text) {
    constexpr std::string_view kMarks = "!#$%&'*+-.^_`|~";
    return !text.empty() && std::all_of(text.begin(), text.end(), [&](char c) {
        return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
               kMarks.find(c) != std::string_view::npos;
    });
}

std::string_view without_blanks(std::string_view text) {
    const size_t from = text.find_first_not_of(" \t");
    if (from == std::string_view::npos) return {};
    return text.substr(from, text.find_last_not_of(" \t") + 1 - from);
}

/// Nothing where a `%` is not followed by two hexadecimal digits.
std::optional<std::string> decoded(std::string_view text, bool plus_is_blank) {
    std::string made;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '+' && plus_is_blank) {
            made += ' ';
        } else if (text[i] == '%') {
            unsigned char byte = 0;
            if (i + 2 >= text.size()) return {};
            const char* from = text.data() + i + 1;
            const auto [rest, status] = std::from_chars(from, from + 2, byte, 16);
            if (status != std::errc() || rest != from + 2) return {};
            made += static_cast<char>(byte);
            i += 2;
        } else {
            made += text[i];
        }
    }
    return made;
}

HeadRead wrong(int status, std::string why) {
    HeadRead read;
    read.status = status;
    read.why = std::move(why);
    return read;
}

bool read_query(std::string_view text, std::map<std::string, std::string>* query) {
    while (!text.empty()) {
        const size_t end = std::min(text.find('&'), text.size());
        const std::string_view one = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (one.empty()) continue;
        const size_t equals = std::min(one.find('='), one.size());
        const std::optional<std::string> name = decoded(one.substr(0, equals), true);
        const std::optional<std::string> value =
            decoded(one.substr(std::min(equals + 1, one.size())), true);
        if (!name || !value) return false;
        query->emplace(*name, *value);
    }
    return true;
}

/// Reads `METHOD TARGET HTTP/1.x`; returns what is wrong, with status 0 where nothing is.
HeadRead read_request_line(std::string_view line) {
    const size_t first = line.find(' ');
    const size_t second = first == std::string_view::npos ? first : line.find(' ', first + 1);
    if (second == std::string_view::npos) return wrong(400, messages::kNoHttpRequest);
    HeadRead read;
    RequestHead& head = read.head;
    head.method = line.substr(0, first);
    const std::string_view target = line.substr(first + 1, second - first - 1);
    const std::string_view version = line.substr(second + 1);
    if (!is_token(head.method) || !version.starts_with("HTTP/"))
        return wrong(400, messages::kNoHttpRequest);
    if (version != "HTTP/1.1" && version != "HTTP/1.0") return wrong(505, messages::kOnlyHttp11);
    head.keeps_alive = version == "HTTP/1.1";
    const size_t question = std::min(target.find('?'), target.size());
    const std::optional<std::string> path = decoded(target.substr(0, question), false);
    if (!target.starts_with('/') || !path ||
        !read_query(target.substr(std::min(question + 1, target.size())), &head.query))
        return wrong(400, messages::kNoAddress);
    head.path = *path;
    return read;
}

/// Reads one header into `head`; returns what is wrong, with status 0 where nothing is.
HeadRead read_header(std::string_view line, RequestHead* head) {
    const size_t colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon)))
        return wrong(400, messages::kNoHeader);
    const std::string name = lower_ascii(std::string(line.substr(0, colon)));
    const std::string_view value = without_blanks(line.substr(colon + 1));
    const bool given = std::any_of(head->headers.begin(), head->headers.end(),
                                   [&](const auto& header) { return header.first == name; });
    if (name == "content-length") {
        const bool digits = !value.empty() && value.size() <= kMostDigits &&
                            value.find_first_not_of("0123456789") == std::string_view::npos;
        if (given || !digits) return wrong(400, messages::kLengthNoNumber);
        std::from_chars(value.data(), value.data() + value.size(), head->body_bytes);
    } else if (name == "transfer-encoding") {
        return wrong(501, messages::kChunkedBody);
    } else if (name == "expect") {
        return wrong(417, messages::kExpectNotRead);
    } else if (name == "host" && given) {
        return wrong(400, messages::kMoreThanOneHost);
    } else if (name == "connection" &&
               lower_ascii(std::string(value)).find("close") != std::string::npos) {
        head->keeps_alive = false;
    }
    if (head->headers.size() >= kMostHeaders) return wrong(431, messages::kTooManyHeaders);
    head->headers.emplace_back(name, value);
    return {};
}

}  // namespace

std::string_view RequestHead::header(std::string_view name) const {
    const auto found = std::find_if(headers.begin(), headers.end(),
                                    [&](const auto& header) { return header.first == name; });
    return found == headers.end() ? std::string_view() : std::string_view(found->second);
}

HeadRead read_head(std::string_view bytes) {
    const std::string_view within = bytes.substr(0, kLargestHead);
    const size_t end = within.find(kHeadEnd);
    const size_t first = within.find(kLineEnd);
    if (end == std::string_view::npos) {
        if (bytes.size() < kLargestHead) return {};
        return first == std::string_view::npos ? wrong(414, messages::kAddressTooLong)
                                               : wrong(431, messages::kHeadersTooLong);
    }
    HeadRead read = read_request_line(within.substr(0, first));
    if (read.status != 0) return read;
    for (size_t from = first + kLineEnd.size(); from < end;) {
        const size_t to = within.find(kLineEnd, from);
        const std::string_view line = within.substr(from, to - from);
        if (line.find_first_of(std::string_view("\r\n\0", 3)) != std::string_view::npos)
            return wrong(400, messages::kNoHeader);
        if (HeadRead refused = read_header(line, &read.head); refused.status != 0) return refused;
        from = to + kLineEnd.size();
    }
    read.bytes = end + kHeadEnd.size();
    return read;
}

std::string answer_head(int status, size_t body_bytes, bool keeps_alive,
                        const std::vector<std::pair<std::string, std::string>>& headers) {
    // Without a reason, which nobody reads: the body has ours (RFC 9112, section 4).
    std::string made = fmt::format("HTTP/1.1 {} \r\n", status);
    for (const auto& [name, value] : headers)
        made += fmt::format("{}: {}\r\n", name, value);
    if (status != 204) made += fmt::format("Content-Length: {}\r\n", body_bytes);
    made += keeps_alive ? "\r\n" : "Connection: close\r\n\r\n";
    return made;
}

}  // namespace openfab::viewer
