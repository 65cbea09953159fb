// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_connections.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>
#include <system_error>
#include <tuple>

#include "base/clock.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

constexpr size_t kChunkBytes = 64 << 10;
/// Where the system has no descriptors left, and none of ours gives way.
constexpr double kPauseSeconds = 0.1;

std::string address_of(const sockaddr_storage& from) {
    std::array<char, INET6_ADDRSTRLEN> text{};
    const void* bytes = nullptr;
    if (from.ss_family == AF_INET6) {
        bytes = &reinterpret_cast<const sockaddr_in6&>(from).sin6_addr;
    } else {
        bytes = &reinterpret_cast<const sockaddr_in&>(from).sin_addr;
    }
    return ::inet_ntop(from.ss_family, bytes, text.data(), text.size()) == nullptr ? std::string()
                                                                                   : text.data();
}

bool waits() {
    return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
}

}  // namespace

Connections::Connections(int listening, Service service, const ConnectionLimits& limits)
    : listening_(listening),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      service_(std::move(service)),
      limits_(limits) {
    threads_.reserve(limits_.threads);
    try {
        for (size_t i = 0; i < limits_.threads; ++i)
            threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
        // Fewer will do, but none.
        if (threads_.empty()) throw;
    }
}

Connections::~Connections() {
    stop();
    for (std::thread& thread : threads_)
        thread.join();
    while (!connections_.empty())
        close(connections_.begin());
    ::close(listening_);
    if (wake_ >= 0) ::close(wake_);
}

void Connections::stop() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    const uint64_t one = 1;
    (void)!::write(wake_, &one, sizeof one);
}

void Connections::work() {
    for (;;) {
        Job job;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [&] {
                return stopping_ || (!jobs_.empty() && bytes_out_ < limits_.answer_bytes);
            });
            if (stopping_) return;
            job = std::move(jobs_.front());
            jobs_.pop_front();
        }
        Reply reply;
        try {
            reply = service_.answer(job.head, job.body);
        } catch (const std::exception&) {
            reply = service_.refuse(500, messages::kMemoryRanOut);
        }
        {
            const std::lock_guard lock(mutex_);
            replies_.emplace_back(job.id, std::move(reply));
        }
        const uint64_t one = 1;
        (void)!::write(wake_, &one, sizeof one);
    }
}

Result<void> Connections::run() {
    if (wake_ < 0) return outside_error(messages::kNoDescriptorLeft);
    while (wait_for_events()) {
    }
    return failed_;
}

/// Waits for one event or more and handles all; returns whether to go on.
bool Connections::wait_for_events() {
    const double now = seconds_now();
    double until = now + limits_.idle_seconds;
    const bool accepts =
        connections_.size() < limits_.connections || who_gives_way() != connections_.end();
    std::vector<pollfd> polled{{wake_, POLLIN, 0}, {accepts ? listening_ : -1, POLLIN, 0}};
    std::vector<uint64_t> ids;
    for (const auto& [id, connection] : connections_) {
        // A pool's answer wakes the loop, whatever the other end does meanwhile.
        if (connection.stage == Stage::kAnswering) continue;
        const bool sends = connection.stage == Stage::kSending;
        polled.push_back({connection.socket, static_cast<short>(sends ? POLLOUT : POLLIN), 0});
        ids.push_back(id);
        until = std::min(until, connection.deadline);
    }
    const double wait_ms = std::clamp(std::ceil((until - now) * 1000), 0.0, 60e3);
    if (::poll(polled.data(), polled.size(), static_cast<int>(wait_ms)) < 0 && errno != EINTR) {
        failed_ = outside_error(std::string(messages::kServerEnded) + std::strerror(errno));
        return false;
    }
    if (polled[0].revents != 0) {
        uint64_t count = 0;
        (void)!::read(wake_, &count, sizeof count);
    }
    {
        const std::lock_guard lock(mutex_);
        if (stopping_) return false;
    }
    take_replies();
    const double then = seconds_now();
    for (size_t i = 0; i < ids.size(); ++i) {
        const auto found = connections_.find(ids[i]);
        if (found == connections_.end()) continue;
        Connection& connection = found->second;
        bool stays = true;
        if (polled[i + 2].revents != 0) {
            stays = connection.stage == Stage::kSending ? send(ids[i], &connection)
                                                        : read(ids[i], &connection);
        } else if (connection.stage != Stage::kAnswering && then >= connection.deadline) {
            stays = pass_deadline(ids[i], &connection);
        }
        if (!stays) close(found);
    }
    return polled[1].revents == 0 || accept_one();
}

/// Returns false where the listening socket is broken.
bool Connections::accept_one() {
    const bool full = connections_.size() >= limits_.connections;
    if (full && who_gives_way() == connections_.end()) return true;
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    const int socket = ::accept4(listening_, reinterpret_cast<sockaddr*>(&from), &size,
                                 SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
        if (errno == EBADF || errno == EINVAL || errno == ENOTSOCK) {
            failed_ = outside_error(messages::kServerSocketFailed);
            return false;
        }
        if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM) {
            const auto other = who_gives_way();
            if (other != connections_.end()) {
                close(other);
            } else {
                std::this_thread::sleep_for(std::chrono::duration<double>(kPauseSeconds));
            }
        }
        return true;
    }
    if (full) close(who_gives_way());
    const int yes = 1;
    ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
    Connection& connection = connections_[++last_id_];
    connection.socket = socket;
    connection.address = address_of(from);
    begin_request(&connection);
    return true;
}

/// The connection whose place the next one takes; the end where all are being answered.
Connections::ById::iterator Connections::who_gives_way() {
    std::map<std::string_view, size_t> held;
    for (const auto& [id, connection] : connections_)
        ++held[connection.address];
    // The least of these goes.
    const auto rank = [&](const Connection& c) {
        return std::tuple(c.stage != Stage::kLingering, -static_cast<int64_t>(held[c.address]),
                          !c.in.empty(), c.since);
    };
    auto found = connections_.end();
    for (auto one = connections_.begin(); one != connections_.end(); ++one) {
        const Stage stage = one->second.stage;
        if (stage != Stage::kReading && stage != Stage::kLingering) continue;
        if (found == connections_.end() || rank(one->second) < rank(found->second)) found = one;
    }
    return found;
}

void Connections::close(ById::iterator connection) {
    ::close(connection->second.socket);
    drop_reply(&connection->second);
    connections_.erase(connection);
}

void Connections::drop_reply(Connection* connection) {
    {
        const std::lock_guard lock(mutex_);
        bytes_out_ -= connection->reply.body.size();
    }
    changed_.notify_all();
    connection->reply = {};
}

void Connections::begin_request(Connection* connection) {
    connection->stage = Stage::kReading;
    connection->since = seconds_now();
    connection->deadline = connection->since + (connection->in.empty() ? limits_.idle_seconds
                                                                       : limits_.request_seconds);
}

bool Connections::read(uint64_t id, Connection* connection) {
    std::array<char, kChunkBytes> buffer;
    size_t room = buffer.size();
    if (connection->stage == Stage::kReading) {
        const auto& request = connection->request;
        const uint64_t wanted =
            request ? request->bytes + request->head.body_bytes : uint64_t{kLargestHead};
        room = static_cast<size_t>(
            std::min<uint64_t>(room, wanted - std::min<uint64_t>(wanted, connection->in.size())));
    }
    const ssize_t got = ::recv(connection->socket, buffer.data(), room, 0);
    if (got < 0) return waits();
    if (got == 0) return false;
    if (connection->stage == Stage::kLingering) return true;
    const bool first = connection->in.empty();
    connection->in.append(buffer.data(), static_cast<size_t>(got));
    if (first) begin_request(connection);
    return advance(id, connection);
}

/// Does what can be done with the bytes that have come.
bool Connections::advance(uint64_t id, Connection* connection) {
    if (!connection->request) {
        HeadRead head = read_head(connection->in);
        if (head.status != 0)
            return begin_reply(id, connection, service_.refuse(head.status, head.why), false);
        if (head.bytes == 0) return true;
        std::optional<Reply> reply = service_.admit(head.head);
        const bool has_body = head.head.body_bytes > 0;
        if (!reply && head.head.body_bytes > limits_.body_bytes)
            reply = service_.refuse(413, messages::kBodyTooLarge);
        const bool keeps_alive = head.head.keeps_alive && !has_body;
        connection->request = std::move(head);
        if (reply) {
            // After a refusal nobody knows what comes: a body, or none to a HEAD.
            const bool refused = reply->status >= 400;
            return begin_reply(id, connection, std::move(*reply), keeps_alive && !refused);
        }
    }
    HeadRead& request = *connection->request;
    const size_t bytes = request.bytes + static_cast<size_t>(request.head.body_bytes);
    if (connection->in.size() < bytes) return true;
    connection->stage = Stage::kAnswering;
    const std::lock_guard lock(mutex_);
    jobs_.push_back(
        {id, request.head, connection->in.substr(request.bytes, bytes - request.bytes)});
    changed_.notify_one();
    return true;
}

void Connections::take_replies() {
    std::vector<std::pair<uint64_t, Reply>> replies;
    {
        const std::lock_guard lock(mutex_);
        replies.swap(replies_);
    }
    for (auto& [id, reply] : replies) {
        const auto found = connections_.find(id);
        Connection& connection = found->second;  // one that is answered is closed by nobody
        if (!begin_reply(id, &connection, std::move(reply), connection.request->head.keeps_alive))
            close(found);
    }
}

bool Connections::begin_reply(uint64_t id, Connection* connection, Reply reply, bool keeps_alive) {
    connection->reply = std::move(reply);
    {
        const std::lock_guard lock(mutex_);
        bytes_out_ += connection->reply.body.size();
    }
    connection->keeps_alive = keeps_alive;
    const size_t body_bytes = connection->body_out().size();
    connection->head_out =
        answer_head(connection->reply.status, body_bytes, keeps_alive, connection->reply.headers);
    connection->sent = 0;
    connection->stage = Stage::kSending;
    connection->deadline = seconds_now() + limits_.answer_seconds +
                           static_cast<double>(body_bytes) / limits_.answer_bytes_a_second;
    return send(id, connection);
}

bool Connections::send(uint64_t id, Connection* connection) {
    const std::string_view head = connection->head_out, body = connection->body_out();
    while (connection->sent < head.size() + body.size()) {
        const bool in_head = connection->sent < head.size();
        const std::string_view rest =
            in_head ? head.substr(connection->sent) : body.substr(connection->sent - head.size());
        const ssize_t sent = ::send(connection->socket, rest.data(), rest.size(),
                                    MSG_NOSIGNAL | (in_head && !body.empty() ? MSG_MORE : 0));
        if (sent < 0) return waits();
        connection->sent += static_cast<size_t>(sent);
    }
    return end_reply(id, connection);
}

/// The answer is out: the next request, or the end.
bool Connections::end_reply(uint64_t id, Connection* connection) {
    drop_reply(connection);
    if (!connection->keeps_alive) {
        ::shutdown(connection->socket, SHUT_WR);
        connection->in.clear();
        connection->stage = Stage::kLingering;
        connection->since = seconds_now();
        connection->deadline = connection->since + limits_.linger_seconds;
        return true;
    }
    const HeadRead& request = *connection->request;
    connection->in.erase(0, request.bytes + static_cast<size_t>(request.head.body_bytes));
    connection->request.reset();
    begin_request(connection);
    return connection->in.empty() || advance(id, connection);
}

/// Nothing has come in time.
bool Connections::pass_deadline(uint64_t id, Connection* connection) {
    if (connection->stage != Stage::kReading || connection->in.empty()) return false;
    return begin_reply(id, connection, service_.refuse(408, messages::kRequestTooLong), false);
}

}  // namespace openfab::viewer
