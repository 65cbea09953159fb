// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Requests and answers of HTTP/1.1 as bytes: as much of RFC 9112 as a page and its server need.
// What is unusual is refused: bodies in chunks, continued lines, bare line feeds.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace openfab::viewer {

/// The largest head of a request; the colours of 255 materials take 2 kB of it.
constexpr size_t kLargestHead = 16 << 10;
constexpr size_t kMostHeaders = 64;

/// What comes before the body.
struct RequestHead {
    std::string method;
    std::string path;                          ///< decoded, from `/` on
    std::map<std::string, std::string> query;  ///< decoded; of two with one name the first
    std::vector<std::pair<std::string, std::string>> headers;  ///< names in small letters
    uint64_t body_bytes = 0;
    bool keeps_alive = true;  ///< whether another request may follow on the connection

    /// Returns the value of a header, or an empty text.
    std::string_view header(std::string_view name) const;
};

struct HeadRead {
    /// Bytes of the head; 0: its end has not come yet, or it is wrong.
    size_t bytes = 0;
    /// The status of the answer to what is wrong; 0: nothing is. Where the next request begins is
    /// not known then.
    int status = 0;
    std::string why;
    RequestHead head;
};

/// Reads the head at the begin of what has come so far.
HeadRead read_head(std::string_view bytes);

/// Returns the status line and the headers before a body of so many bytes, and the empty line.
std::string answer_head(int status, size_t body_bytes, bool keeps_alive,
                        const std::vector<std::pair<std::string, std::string>>& headers);

}  // namespace openfab::viewer
