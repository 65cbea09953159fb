// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/stream/message.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstring>
#include <type_traits>
#include <utility>

#include "backends/stream/messages.h"
#include "base/clock.h"
#include "base/text.h"

namespace openfab::stream {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

namespace {

constexpr size_t kMostStopText = 500;

template <typename T>
void put(std::vector<uint8_t>* out, const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* bytes = reinterpret_cast<const uint8_t*>(&value);
    out->insert(out->end(), bytes, bytes + sizeof(T));
}

void put_bytes(std::vector<uint8_t>* out, std::span<const uint8_t> bytes) {
    put(out, static_cast<uint32_t>(bytes.size()));
    out->insert(out->end(), bytes.begin(), bytes.end());
}

/// Takes a number from the front; false where there are too few bytes.
template <typename T>
bool take(std::span<const uint8_t>* bytes, T* value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (bytes->size() < sizeof(T)) return false;
    std::memcpy(value, bytes->data(), sizeof(T));
    *bytes = bytes->subspan(sizeof(T));
    return true;
}

bool take_bytes(std::span<const uint8_t>* bytes, std::span<const uint8_t>* out) {
    uint32_t n = 0;
    if (!take(bytes, &n) || n > bytes->size()) return false;
    *out = bytes->first(n);
    *bytes = bytes->subspan(n);
    return true;
}

}  // namespace

std::vector<uint8_t> frame(Kind kind, std::span<const uint8_t> bytes) {
    std::vector<uint8_t> out;
    out.reserve(kHeadBytes + bytes.size());
    put(&out, kind);
    put_bytes(&out, bytes);
    return out;
}

std::vector<uint8_t> frame_open(const Open& open) {
    std::vector<uint8_t> out;
    put(&out, kMagic);
    put(&out, kVersion);
    put(&out, open.mode);
    put(&out, open.sender);
    put_bytes(&out, {reinterpret_cast<const uint8_t*>(open.token.data()), open.token.size()});
    put_bytes(&out, open.header);
    return frame(Kind::kOpen, out);
}

std::vector<uint8_t> frame_ready(const Ready& ready) {
    std::vector<uint8_t> out;
    put(&out, ready.next);
    put(&out, ready.window);
    put(&out, ready.complete);
    return frame(Kind::kReady, out);
}

std::vector<uint8_t> frame_acknowledge(int32_t z) {
    std::vector<uint8_t> out;
    put(&out, z);
    return frame(Kind::kAcknowledge, out);
}

std::vector<uint8_t> frame_stop(StopCode code, const std::string& text) {
    std::vector<uint8_t> out;
    put(&out, code);
    const std::string some = text.substr(0, kMostStopText);
    put_bytes(&out, {reinterpret_cast<const uint8_t*>(some.data()), some.size()});
    return frame(Kind::kStop, out);
}

Result<Open> read_open(std::span<const uint8_t> bytes) {
    std::array<uint8_t, kMagic.size()> magic{};
    uint32_t version = 0;
    Open open;
    std::span<const uint8_t> token, header;
    if (!take(&bytes, &magic) || magic != kMagic) return user_error(messages::kNoPrint);
    if (!take(&bytes, &version) || version != kVersion) {
        return user_error(fmt::format(messages::kOtherProtocol, version, kVersion));
    }
    if (!take(&bytes, &open.mode) || open.mode > Mode::kSendBack || !take(&bytes, &open.sender) ||
        !take_bytes(&bytes, &token) || token.size() > kMostTokenBytes ||
        !take_bytes(&bytes, &header) || !bytes.empty())
        return user_error(messages::kFirstMessageDamaged);
    open.token.assign(token.begin(), token.end());
    open.header.assign(header.begin(), header.end());
    return open;
}

Result<Ready> read_ready(std::span<const uint8_t> bytes) {
    Ready ready;
    if (!take(&bytes, &ready.next) || !take(&bytes, &ready.window) ||
        !take(&bytes, &ready.complete) || !bytes.empty() || ready.window == 0)
        return user_error(messages::kAnswerDamaged);
    return ready;
}

Result<int32_t> read_acknowledge(std::span<const uint8_t> bytes) {
    int32_t z = 0;
    if (!take(&bytes, &z) || !bytes.empty()) return user_error(messages::kAcknowledgementDamaged);
    return z;
}

Stop read_stop(std::span<const uint8_t> bytes) {
    Stop stop;
    std::span<const uint8_t> text;
    if (!take(&bytes, &stop.code) || !take_bytes(&bytes, &text)) return stop;
    stop.text = printable(std::string(text.begin(), text.end()).substr(0, kMostStopText));
    return stop;
}

Line::Line(Socket socket, std::unique_ptr<TlsSession> tls)
    : socket_(std::move(socket)), tls_(std::move(tls)), heard_(seconds_now()) {}

Line& Line::operator=(Line&& other) noexcept {
    if (this == &other) return *this;
    tls_.reset();  // before its socket
    socket_ = std::move(other.socket_);
    tls_ = std::move(other.tls_);
    buffer_ = std::move(other.buffer_);
    begin_ = other.begin_;
    most_ = other.most_;
    heard_ = other.heard_;
    return *this;
}

void Line::close() {
    tls_.reset();
    socket_.close();
    buffer_.clear();
    begin_ = 0;
}

int64_t Line::read_some(std::span<uint8_t> bytes) {
    if (tls_ != nullptr) return tls_->read(bytes);
    ssize_t got = -1;
    do {
        got = ::recv(socket_.fd(), bytes.data(), bytes.size(), 0);
    } while (got < 0 && errno == EINTR);
    if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return 0;
    return got > 0 ? got : -1;
}

bool Line::receive() {
    constexpr size_t kStep = 64 << 10;
    // What was taken makes room first.
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
    // The place of the whole message at once: a vector that grows takes up to twice of it, and what
    // it grows out of. `next` refuses what is longer than allowed.
    if (uint32_t n = 0; buffer_.size() >= kHeadBytes) {
        std::memcpy(&n, buffer_.data() + 4, sizeof n);
        if (n <= most_) buffer_.reserve(kHeadBytes + n + kStep);
    }
    for (;;) {
        const size_t had = buffer_.size();
        buffer_.resize(had + kStep);
        const int64_t got = read_some(std::span(buffer_).subspan(had));
        buffer_.resize(had + static_cast<size_t>(std::max<int64_t>(got, 0)));
        if (got > 0) heard_ = seconds_now();
        // The rest of what TLS has decrypted: one record at most.
        if (got <= 0 || tls_ == nullptr || !tls_->has_more()) return got >= 0;
    }
}

Result<bool> Line::next(Message* message) {
    std::span<const uint8_t> rest = std::span<const uint8_t>(buffer_).subspan(begin_);
    uint32_t n = 0;
    if (rest.size() < kHeadBytes) return false;
    take(&rest, &message->kind);
    take(&rest, &n);
    if (n > most_) {
        return user_error(fmt::format(messages::kMessageTooLong, n, most_));
    }
    if (rest.size() < n) return false;
    message->bytes.assign(rest.begin(), rest.begin() + n);
    begin_ += kHeadBytes + n;
    return true;
}

int64_t Line::send_some(std::span<const uint8_t> bytes) {
    if (tls_ != nullptr) return tls_->write(bytes);
    const ssize_t n = ::send(socket_.fd(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (n >= 0) return n;
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -1;
}

bool Line::send_all(std::span<const uint8_t> bytes, double silent_seconds) {
    while (!bytes.empty()) {
        pollfd polled{fd(), POLLOUT, 0};
        if (::poll(&polled, 1, static_cast<int>(silent_seconds * 1000)) <= 0) return false;
        const int64_t n = send_some(bytes);
        if (n < 0) return false;
        bytes = bytes.subspan(static_cast<size_t>(n));
    }
    return true;
}

Result<bool> Line::wait(Message* message, double silent_seconds) {
    for (;;) {
        Result<bool> got = next(message);
        if (!got) return got.error();
        if (*got && message->kind != Kind::kAlive) return true;
        if (*got) continue;
        pollfd polled{fd(), POLLIN, 0};
        const int ready = ::poll(&polled, 1, static_cast<int>(silent_seconds * 1000));
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0 || !receive()) return false;
    }
}

}  // namespace openfab::stream
