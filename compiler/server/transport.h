// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Messages of the Language Server Protocol in a stream of bytes: `Content-Length: N`, an empty line, N bytes.

#include <optional>
#include <string>
#include <string_view>

namespace openfab::server {

/// Takes messages out of bytes as they come. After a header that it does not understand it is broken: what follows
/// cannot be told apart.
class MessageReader {
  public:
    static constexpr size_t kMaxHeaderBytes = 4096;
    static constexpr size_t kMaxMessageBytes = 32u << 20;

    void add(std::string_view bytes) { buffer_ += bytes; }
    /// Returns the next whole message.
    std::optional<std::string> next();
    bool broken() const { return broken_; }

  private:
    bool read_header(std::string_view header);

    std::string buffer_;
    std::optional<size_t> length_;  ///< of the message whose header was read
    bool broken_ = false;
};

/// Returns a message with its header.
std::string framed(std::string_view message);

}  // namespace openfab::server
