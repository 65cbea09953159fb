// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where prints are streamed to: `tcp://HOST:PORT`, `tls://HOST:PORT` or `unix:PATH`. Plain sockets and poll: an end has
// one line, or a handful of them, so that a library for many would be more than what it replaces.

#include <string>

#include "base/result.h"

namespace openfab::stream {

struct Address {
    std::string text;  ///< as it was typed
    std::string host;  ///< tcp and tls; empty: unix
    std::string port;
    bool is_tls = false;
    std::string path;  ///< unix
};

/// Returns whether the text is meant as an address, well-formed or not.
bool is_address(const std::string& text);
/// Parses an address; errors are usage errors.
Result<Address> parse_address(const std::string& text);

/// Returns whether nobody outside this machine can reach it: a path, or a loopback host.
Result<bool> is_local(const Address& address);

/// A socket, closed by the destructor.
class Socket {
  public:
    explicit Socket(int fd = -1) : fd_(fd) {}
    Socket(Socket&& other) noexcept;
    Socket& operator=(Socket&& other) noexcept;
    ~Socket() { close(); }
    int fd() const { return fd_; }
    bool is_open() const { return fd_ >= 0; }
    void close();

  private:
    int fd_;
};

/// Connects within `seconds`; the socket does not block.
Result<Socket> connect_to(const Address& address, double seconds);
/// Listens; a socket's file that a killed process has left is replaced, and only its user may
/// connect to it. The socket does not block.
Result<Socket> listen_at(const Address& address);
/// Returns the address that a listening socket really has, where port 0 was asked for.
std::string listening_text(const Socket& socket, const Address& address);

/// Returns who is at the other end of a connection, for messages: HOST:PORT, or the user of its
/// process.
std::string other_end(const Socket& socket);

/// Reads the token that both ends share: the first line of `file`, else the environment's
/// OPENFAB_TOKEN; empty where neither is given.
Result<std::string> load_token(const std::string& file);
constexpr size_t kMostTokenBytes = 256;

}  // namespace openfab::stream
