// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// TLS 1.2 and newer over a socket that does not block, by OpenSSL. The receiver has a certificate,
// which the sender checks against its host's name; who sends is decided by the token, as without.

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "backends/stream/address.h"
#include "base/result.h"

struct ssl_st;
struct ssl_ctx_st;

namespace openfab::stream {

/// One connection's session. It uses the socket, but does not own it.
class TlsSession {
  public:
    explicit TlsSession(ssl_st* ssl) : ssl_(ssl) {}
    ~TlsSession();
    TlsSession(const TlsSession&) = delete;
    TlsSession& operator=(const TlsSession&) = delete;

    /// Reads what has arrived, at most `bytes`; 0: nothing now, -1: the line is cut or damaged. The
    /// receiver's first calls make the handshake.
    int64_t read(std::span<uint8_t> bytes);
    /// Returns whether bytes have been read from the socket that read() has not returned: poll does
    /// not tell of them.
    bool has_more() const;
    /// Sends some of `bytes` and returns how many, 0 where the socket takes nothing now; the next
    /// write must then begin with the same bytes. -1: the line is cut.
    int64_t write(std::span<const uint8_t> bytes);
    /// Returns whether such a write is due.
    bool must_repeat() const { return must_repeat_; }

  private:
    int64_t outcome(int result);

    ssl_st* ssl_;
    bool must_repeat_ = false;
};

/// What the sessions of one end have in common.
class TlsContext {
  public:
    /// Trusts the authorities of `ca_file`, a PEM file; empty: the system's.
    static Result<std::unique_ptr<TlsContext>> for_senders(const std::string& ca_file);
    /// `certificate_file` and `key_file`: PEM files, the former with the whole chain.
    static Result<std::unique_ptr<TlsContext>> for_receivers(const std::string& certificate_file,
                                                             const std::string& key_file);
    ~TlsContext();
    TlsContext(const TlsContext&) = delete;
    TlsContext& operator=(const TlsContext&) = delete;

    /// Makes the handshake of a sender that is connected to `address`, within `seconds`.
    Result<std::unique_ptr<TlsSession>> connect(const Socket& socket, const Address& address,
                                                double seconds) const;
    /// Begins the session of a client; null where memory ran out.
    std::unique_ptr<TlsSession> accept(const Socket& socket) const;

  private:
    explicit TlsContext(ssl_ctx_st* context) : context_(context) {}

    ssl_ctx_st* context_;
};

}  // namespace openfab::stream
