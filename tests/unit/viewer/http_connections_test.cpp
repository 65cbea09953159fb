// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_connections.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <memory>

namespace openfab::testing {
namespace {

using ::testing::EndsWith;
using ::testing::StartsWith;
using viewer::ConnectionLimits;
using viewer::Reply;
using viewer::RequestHead;

/// A connection of this test; what does not come lets it hang, which ctest ends.
class Client {
  public:
    explicit Client(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in to{};
        to.sin_family = AF_INET;
        to.sin_port = htons(static_cast<uint16_t>(port));
        to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
    }
    ~Client() { ::close(socket_); }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    /// Returns whether the other end still takes bytes.
    bool send(const std::string& bytes) const {
        return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
               static_cast<ssize_t>(bytes.size());
    }
    /// Returns the next bytes; none at the end.
    std::string some() const {
        std::array<char, 65536> buffer{};
        const ssize_t n = ::recv(socket_, buffer.data(), buffer.size(), 0);
        return {buffer.data(), static_cast<size_t>(std::max<ssize_t>(n, 0))};
    }
    /// Returns all bytes up to and with `end`, or to the end of the connection.
    std::string until(const std::string& end) {
        std::string got;
        while (got.size() < end.size() || !got.ends_with(end)) {
            const std::string more = some();
            if (more.empty()) break;
            got += more;
        }
        return got;
    }
    std::string to_the_end() {
        std::string got;
        for (std::string more = some(); !more.empty(); more = some())
            got += more;
        return got;
    }

  private:
    int socket_;
};

/// Answers with the path and the body; `/slow` when it is let go, `/large` with many bytes.
class Server {
  public:
    explicit Server(const ConnectionLimits& limits) {
        const int listening = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        sockaddr_in at{};
        at.sin_family = AF_INET;
        at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof at;
        EXPECT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&at), size), 0);
        EXPECT_EQ(::listen(listening, 1000), 0);
        ::getsockname(listening, reinterpret_cast<sockaddr*>(&at), &size);
        port_ = ntohs(at.sin_port);
        connections_ = std::make_unique<viewer::Connections>(
            listening,
            viewer::Service{[](const RequestHead& head) -> std::optional<Reply> {
                                if (head.path == "/page") return Reply{200, {}, {}, "the page"};
                                if (head.path == "/no") return refuse(403, "no");
                                return {};
                            },
                            [this](const RequestHead& head, const std::string& body) {
                                if (head.path == "/large")
                                    return Reply{200, {}, std::string(32 << 20, 'x'), {}};
                                if (head.path == "/slow") {
                                    ++waiting_;
                                    let_go_.wait(false);
                                }
                                return Reply{200, {}, head.path + " " + body + "!", {}};
                            },
                            refuse},
            limits);
        thread_ = std::thread([this] { EXPECT_TRUE(connections_->run()); });
    }
    ~Server() {
        let_go();
        connections_->stop();
        thread_.join();
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    int port() const { return port_; }
    void wait_for(int slow_ones) const {
        while (waiting_ < slow_ones)
            std::this_thread::yield();
    }
    void let_go() {
        let_go_ = true;
        let_go_.notify_all();
    }

  private:
    static Reply refuse(int status, const std::string& why) { return {status, {}, why, {}}; }

    int port_ = 0;
    std::atomic<int> waiting_{0};
    std::atomic<bool> let_go_{false};
    std::unique_ptr<viewer::Connections> connections_;
    std::thread thread_;
};

std::string get(const std::string& path, bool close = false) {
    return "GET " + path + " HTTP/1.1\r\nHost: a\r\n" + (close ? "Connection: close\r\n" : "") +
           "\r\n";
}

std::string answer_of(int port, const std::string& path) {
    Client client(port);
    client.send(get(path, true));
    return client.to_the_end();
}

ConnectionLimits few(size_t connections) {
    ConnectionLimits limits;
    limits.connections = connections;
    limits.threads = 2;
    return limits;
}

TEST(HttpConnections, RequestsOfAConnectionAreAnsweredInOrder) {
    const Server server(few(8));
    Client client(server.port());
    // In one piece, a page's file between two that the pool answers, one with a body.
    client.send("POST /a HTTP/1.1\r\nContent-Length: 5\r\n\r\n12345" + get("/page") + get("/b"));
    const std::string got = client.until("/b !");
    const size_t first = got.find("/a 12345!"), second = got.find("the page");
    EXPECT_LT(first, second);
    EXPECT_LT(second, got.size());
    // Byte by byte.
    for (const char byte : std::string("POST /c HTTP/1.1\r\nContent-Length: 2\r\n\r\nxy"))
        client.send(std::string(1, byte));
    EXPECT_THAT(client.until("!"), EndsWith("/c xy!"));
    client.send(get("/d", true));
    EXPECT_THAT(client.to_the_end(), EndsWith("/d !"));
}

TEST(HttpConnections, ARefusalEndsTheConnectionAndArrives) {
    const Server server(few(8));
    Client refused(server.port());
    // More than the system's buffers hold: what the server does not read must not hide its answer.
    std::thread sender([&] {
        refused.send("POST /no HTTP/1.1\r\nContent-Length: 4000000\r\n\r\n" +
                     std::string(4000000, ' '));
    });
    EXPECT_THAT(refused.to_the_end(), StartsWith("HTTP/1.1 403 "));
    sender.join();
    EXPECT_THAT(answer_of(server.port(), "/%"), StartsWith("HTTP/1.1 400 "));
    Client large(server.port());
    large.send("POST /a HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n");
    EXPECT_THAT(large.to_the_end(), StartsWith("HTTP/1.1 413 "));
}

TEST(HttpConnections, IdleOnesGiveWayTheLongestFirst) {
    const Server server(few(4));
    std::vector<std::unique_ptr<Client>> idle;
    for (int i = 0; i < 4; ++i) {
        idle.push_back(std::make_unique<Client>(server.port()));
        idle.back()->send(get("/page"));
        idle.back()->until("the page");
    }
    EXPECT_THAT(answer_of(server.port(), "/a"), EndsWith("/a !"));
    EXPECT_EQ(idle[0]->some(), "");
    idle[3]->send(get("/b"));
    EXPECT_THAT(idle[3]->until("!"), EndsWith("/b !"));
    // Many more than there are places: each new one is answered.
    std::vector<std::unique_ptr<Client>> silent;
    for (int i = 0; i < 100; ++i)
        silent.push_back(std::make_unique<Client>(server.port()));
    EXPECT_THAT(answer_of(server.port(), "/c"), EndsWith("/c !"));
}

TEST(HttpConnections, SlowRequestsGiveWayAfterIdleOnes) {
    const Server server(few(2));
    Client slow(server.port());
    slow.send("GET /a HT");
    Client idle(server.port());
    idle.send(get("/page"));
    idle.until("the page");
    EXPECT_THAT(answer_of(server.port(), "/b"), EndsWith("/b !"));
    EXPECT_EQ(idle.some(), "");
    slow.send("TP/1.1\r\n\r\n");
    EXPECT_THAT(slow.until("!"), EndsWith("/a !"));
}

TEST(HttpConnections, WhatIsBeingAnsweredKeepsItsPlace) {
    Server server(few(2));
    Client first(server.port()), second(server.port());
    first.send(get("/slow"));
    second.send(get("/slow"));
    server.wait_for(2);
    Client third(server.port());
    third.send(get("/c", true));
    server.let_go();
    EXPECT_THAT(first.until("!"), EndsWith("/slow !"));
    EXPECT_THAT(second.until("!"), EndsWith("/slow !"));
    EXPECT_THAT(third.to_the_end(), EndsWith("/c !"));
}

TEST(HttpConnections, ARequestHasADeadlineAsAWhole) {
    ConnectionLimits limits = few(8);
    limits.request_seconds = limits.linger_seconds = 0.05;
    const Server server(limits);
    // As long as it is listened to: a byte now and then keeps nothing alive.
    Client slow(server.port());
    slow.send("GET /a HTTP/1.1\r\nX: ");
    while (slow.send("y"))
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    Client patient(server.port());
    patient.send("POST /a HTTP/1.1\r\nContent-Length: 9\r\n\r\n1");
    EXPECT_THAT(patient.to_the_end(), StartsWith("HTTP/1.1 408 "));
}

TEST(HttpConnections, AnIdleConnectionEnds) {
    ConnectionLimits limits = few(8);
    limits.idle_seconds = 0.02;
    const Server server(limits);
    Client client(server.port());
    EXPECT_EQ(client.some(), "");
}

TEST(HttpConnections, WhoTakesNothingHoldsNobodyUpAndIsClosed) {
    ConnectionLimits limits = few(8);
    limits.answer_bytes = 1;  // one at a time
    limits.answer_seconds = 0.05;
    limits.answer_bytes_a_second = 1e9;
    const Server server(limits);
    std::vector<std::unique_ptr<Client>> takers;
    for (int i = 0; i < 4; ++i) {
        takers.push_back(std::make_unique<Client>(server.port()));
        takers.back()->send(get("/large"));
    }
    // What needs no pool is answered meanwhile, the rest once the answers before it are gone.
    EXPECT_THAT(answer_of(server.port(), "/page"), EndsWith("the page"));
    EXPECT_THAT(answer_of(server.port(), "/a"), EndsWith("/a !"));
    EXPECT_LT(takers[0]->to_the_end().size(), size_t{32} << 20);
}

TEST(HttpConnections, ALargeAnswerArrivesWhole) {
    const Server server(few(8));
    const std::string got = answer_of(server.port(), "/large");
    EXPECT_EQ(got.size() - got.find("\r\n\r\n") - 4, size_t{32} << 20);
}

}  // namespace
}  // namespace openfab::testing
