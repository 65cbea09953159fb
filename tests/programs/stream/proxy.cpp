// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/programs/stream/proxy.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <utility>

namespace openfab::testing {

namespace {

bool send_whole(int fd, const char* data, size_t bytes) {
    while (bytes > 0) {
        pollfd polled{fd, POLLOUT, 0};
        if (::poll(&polled, 1, 5000) <= 0) return false;
        const ssize_t n = ::send(fd, data, bytes, MSG_NOSIGNAL);
        if (n < 0) return false;
        data += n;
        bytes -= static_cast<size_t>(n);
    }
    return true;
}

}  // namespace

Proxy::Proxy(stream::Address receiver, std::vector<int64_t> cuts, int64_t damaged)
    : receiver_(std::move(receiver)), cuts_(std::move(cuts)), damaged_(damaged) {
    const stream::Address any = *stream::parse_address("tcp://127.0.0.1:0");
    listening_ = std::move(*stream::listen_at(any));
    address_ = stream::listening_text(listening_, any);
    thread_ = std::thread([this] { run(); });
}

Proxy::~Proxy() {
    quit_ = true;
    thread_.join();
}

void Proxy::run() {
    while (!quit_) {
        pollfd polled{listening_.fd(), POLLIN, 0};
        if (::poll(&polled, 1, 50) <= 0) continue;
        stream::Socket sender(
            ::accept4(listening_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        Result<stream::Socket> receiver = stream::connect_to(receiver_, 5);
        if (sender.is_open() && receiver) pass(std::move(sender), std::move(*receiver));
    }
}

void Proxy::pass(stream::Socket sender, stream::Socket receiver) {
    // Small steps, so that a cut is where it is meant to be.
    std::array<char, 4096> buffer;
    while (!quit_) {
        std::array<pollfd, 2> polled{{{sender.fd(), POLLIN, 0}, {receiver.fd(), POLLIN, 0}}};
        if (::poll(polled.data(), polled.size(), 50) <= 0) continue;
        if (polled[1].revents != 0) {
            const ssize_t n = ::recv(receiver.fd(), buffer.data(), buffer.size(), 0);
            if (n <= 0 || !send_whole(sender.fd(), buffer.data(), static_cast<size_t>(n))) return;
        }
        if (polled[0].revents == 0) continue;
        ssize_t n = ::recv(sender.fd(), buffer.data(), buffer.size(), 0);
        if (n <= 0) return;
        const bool cut = static_cast<size_t>(cuts_made_) < cuts_.size() &&
                         passed_ + n >= cuts_[static_cast<size_t>(cuts_made_)];
        if (cut) n = std::max<int64_t>(cuts_[static_cast<size_t>(cuts_made_)] - passed_, 0);
        if (damaged_ > passed_ && damaged_ <= passed_ + n)
            buffer[static_cast<size_t>(damaged_ - passed_ - 1)] ^= 16;
        passed_ += n;
        if (!send_whole(receiver.fd(), buffer.data(), static_cast<size_t>(n))) return;
        if (!cut) continue;
        ++cuts_made_;
        return;
    }
}

}  // namespace openfab::testing
