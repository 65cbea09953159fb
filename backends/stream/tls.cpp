// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/stream/tls.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>
#include <poll.h>

#include <algorithm>
#include <limits>

#include "backends/stream/messages.h"
#include "base/clock.h"
#include "base/input_file.h"
#include "base/text.h"

namespace openfab::stream {

namespace {

/// Returns the reason of the newest error of this thread, and forgets all.
std::string reason() {
    const unsigned long code = ERR_peek_last_error();
    ERR_clear_error();
    const char* text = code == 0 ? nullptr : ERR_reason_error_string(code);
    return text == nullptr ? messages::kOtherEndClosed : printable(text);
}

Error unreadable(const std::string& file, const char* what) {
    return user_error(fmt::format(messages::kCannotReadFrom, what, file, reason()));
}

/// OpenSSL opens files by their names, and would wait for a pipe's writer.
Result<void> check_file(const std::string& file, const char* what) {
    const Result<InputFile> opened = InputFile::open(file);
    if (opened) return {};
    return Error{opened.error().code,
                 fmt::format(messages::kCannotReadFrom, what, file, opened.error().text())};
}

/// Nobody is asked for the password of a key.
int no_password(char*, int, int, void*) {
    return 0;
}

ssl_ctx_st* make_context(const SSL_METHOD* method) {
    ssl_ctx_st* context = SSL_CTX_new(method);
    if (context == nullptr) return nullptr;
    SSL_CTX_set_min_proto_version(context, TLS1_2_VERSION);
    SSL_CTX_set_default_passwd_cb(context, no_password);
    SSL_CTX_set_mode(context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
    return context;
}

bool is_number(const std::string& host) {
    in6_addr ignored{};
    return ::inet_pton(AF_INET, host.c_str(), &ignored) == 1 ||
           ::inet_pton(AF_INET6, host.c_str(), &ignored) == 1;
}

/// Makes the certificate be checked against the name that was asked for.
bool expect_host(ssl_st* ssl, const std::string& host) {
    if (is_number(host))
        return X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(ssl), host.c_str()) == 1;
    return SSL_set1_host(ssl, host.c_str()) == 1 &&
           SSL_set_tlsext_host_name(ssl, host.c_str()) == 1;
}

int clipped(size_t bytes) {
    return static_cast<int>(std::min<size_t>(bytes, std::numeric_limits<int>::max()));
}

}  // namespace

TlsSession::~TlsSession() {
    // One attempt to say that nothing follows; where the line is cut, it fails.
    (void)SSL_shutdown(ssl_);
    SSL_free(ssl_);
    ERR_clear_error();
}

int64_t TlsSession::outcome(int result) {
    if (result > 0) return result;
    const int error = SSL_get_error(ssl_, result);
    ERR_clear_error();
    return error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE ? 0 : -1;
}

int64_t TlsSession::read(std::span<uint8_t> bytes) {
    ERR_clear_error();
    return outcome(SSL_read(ssl_, bytes.data(), clipped(bytes.size())));
}

bool TlsSession::has_more() const {
    return SSL_pending(ssl_) > 0;
}

int64_t TlsSession::write(std::span<const uint8_t> bytes) {
    if (bytes.empty()) return 0;
    ERR_clear_error();
    const int64_t n = outcome(SSL_write(ssl_, bytes.data(), clipped(bytes.size())));
    must_repeat_ = n == 0;
    return n;
}

Result<std::unique_ptr<TlsContext>> TlsContext::for_senders(const std::string& ca_file) {
    ERR_clear_error();
    std::unique_ptr<TlsContext> made(new TlsContext(make_context(TLS_client_method())));
    if (made->context_ == nullptr) return outside_error(messages::kCannotBeginTls + reason());
    SSL_CTX_set_verify(made->context_, SSL_VERIFY_PEER, nullptr);
    if (!ca_file.empty()) {
        if (Result<void> there = check_file(ca_file, "certificates"); !there) return there.error();
    }
    if (ca_file.empty()) {
        SSL_CTX_set_default_verify_paths(made->context_);
    } else if (SSL_CTX_load_verify_locations(made->context_, ca_file.c_str(), nullptr) != 1) {
        return unreadable(ca_file, "certificates");
    }
    return made;
}

Result<std::unique_ptr<TlsContext>> TlsContext::for_receivers(const std::string& certificate_file,
                                                              const std::string& key_file) {
    ERR_clear_error();
    std::unique_ptr<TlsContext> made(new TlsContext(make_context(TLS_server_method())));
    if (made->context_ == nullptr) return outside_error(messages::kCannotBeginTls + reason());
    for (const auto& [file, what] : {std::pair(certificate_file, messages::kACertificate),
                                     std::pair(key_file, messages::kKeyOfCertificate)}) {
        if (Result<void> there = check_file(file, what); !there) return there.error();
    }
    if (SSL_CTX_use_certificate_chain_file(made->context_, certificate_file.c_str()) != 1)
        return unreadable(certificate_file, messages::kACertificate);
    if (SSL_CTX_use_PrivateKey_file(made->context_, key_file.c_str(), SSL_FILETYPE_PEM) != 1)
        return unreadable(key_file, messages::kKeyOfCertificate);
    return made;
}

TlsContext::~TlsContext() {
    SSL_CTX_free(context_);
}

Result<std::unique_ptr<TlsSession>> TlsContext::connect(const Socket& socket,
                                                        const Address& address,
                                                        double seconds) const {
    ERR_clear_error();
    ssl_st* const ssl = SSL_new(context_);
    if (ssl == nullptr) return outside_error(messages::kCannotBeginTls + reason());
    auto session = std::make_unique<TlsSession>(ssl);
    if (SSL_set_fd(ssl, socket.fd()) != 1 || !expect_host(ssl, address.host))
        return outside_error(fmt::format(messages::kCannotBeginTlsWith, address.text, reason()));
    const double end = seconds_now() + seconds;
    for (;;) {
        const int result = SSL_connect(ssl);
        if (result == 1) return session;
        const int error = SSL_get_error(ssl, result);
        if (error != SSL_ERROR_WANT_READ && error != SSL_ERROR_WANT_WRITE) break;
        pollfd polled{socket.fd(),
                      static_cast<int16_t>(error == SSL_ERROR_WANT_READ ? POLLIN : POLLOUT), 0};
        const double left = end - seconds_now();
        if (left <= 0 || ::poll(&polled, 1, static_cast<int>(left * 1000) + 1) <= 0) {
            return outside_error(fmt::format(messages::kNoTlsAnswer, address.text));
        }
    }
    const long verified = SSL_get_verify_result(ssl);
    if (verified != X509_V_OK) {
        ERR_clear_error();
        Error error = user_error(fmt::format(messages::kNotTrusted, address.text,
                                             X509_verify_cert_error_string(verified)));
        error.help = messages::kNotTrustedHelp;
        return error;
    }
    return outside_error(fmt::format(messages::kNoTls, address.text, reason()));
}

std::unique_ptr<TlsSession> TlsContext::accept(const Socket& socket) const {
    ssl_st* const ssl = SSL_new(context_);
    if (ssl == nullptr) return nullptr;
    auto session = std::make_unique<TlsSession>(ssl);
    if (SSL_set_fd(ssl, socket.fd()) != 1) return nullptr;
    SSL_set_accept_state(ssl);
    return session;
}

}  // namespace openfab::stream
