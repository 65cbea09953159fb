// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/programs/viewer/viewer_client.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <future>

#include "base/text.h"
#include "tests/support/places/places.h"
#include "tests/support/says/says.h"

namespace openfab::testing {

namespace {

constexpr auto kPatience = std::chrono::seconds(300);  // which only a hang reaches

HttpAnswer parse(const std::string& bytes) {
    HttpAnswer answer;
    const size_t head = bytes.find("\r\n\r\n");
    if (head == std::string::npos || !bytes.starts_with("HTTP/1.1 ")) return answer;
    answer.status = std::stoi(bytes.substr(9, 3));
    answer.body = bytes.substr(head + 4);
    for (size_t from = bytes.find("\r\n") + 2; from < head + 2;) {
        const size_t to = bytes.find("\r\n", from);
        const std::string line = bytes.substr(from, to - from);
        const size_t colon = line.find(": ");
        if (colon != std::string::npos)
            answer.headers[lower_ascii(line.substr(0, colon))] = line.substr(colon + 2);
        from = to + 2;
    }
    return answer;
}

}  // namespace

JsonValue HttpAnswer::json() const {
    Result<JsonValue> read = parse_json(body, "answer");
    if (!read) ADD_FAILURE() << status << " " << read.error().text() << "\n" << body;
    return read ? std::move(*read) : JsonValue();
}

int connect_to(int port) {
    const int connection = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<uint16_t>(port));
    ::inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
    if (::connect(connection, reinterpret_cast<sockaddr*>(&to), sizeof to) == 0) return connection;
    ADD_FAILURE() << "no connection";
    return connection;
}

void send_bytes(int connection, const std::string& bytes) {
    for (size_t sent = 0; sent < bytes.size();) {
        const ssize_t n =
            ::send(connection, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
        if (n <= 0) break;
        sent += static_cast<size_t>(n);
    }
}

std::string send_raw(int port, const std::string& bytes) {
    const int connection = connect_to(port);
    send_bytes(connection, bytes);
    std::string got;
    std::array<char, 65536> buffer{};
    for (ssize_t n = 0; (n = ::recv(connection, buffer.data(), buffer.size(), 0)) > 0;)
        got.append(buffer.data(), static_cast<size_t>(n));
    ::close(connection);
    return got;
}

Viewer::Viewer(std::vector<std::string> arguments, const std::string& cache) {
    arguments.insert(arguments.begin(), {program("openfab"), "view"});
    std::promise<std::string> address;
    std::future<std::string> url = address.get_future();
    RunOptions options;
    if (!cache.empty()) options.environment = {{"OPENFAB_CACHE", cache}};
    bool told = false;
    options.interrupt_when = [this, told, &address](int, const Outcome& so_far) mutable {
        if (!told && so_far.out.find('\n') != std::string::npos) {
            told = true;
            address.set_value(so_far.out.substr(0, so_far.out.find('\n')));
        }
        return end_.load();
    };
    thread_ = std::thread([this, arguments, options] {
        outcome_ = run(arguments, options);
        ended_ = true;
    });
    const auto begin = std::chrono::steady_clock::now();
    while (url.wait_for(std::chrono::milliseconds(5)) != std::future_status::ready) {
        if (!ended_ && std::chrono::steady_clock::now() - begin < kPatience) continue;
        end_ = true;
        thread_.join();
        ADD_FAILURE() << "no address: " << outcome_.err;
        return;
    }
    url_ = url.get();
    const size_t colon = url_.rfind(':');
    const size_t hash = url_.find("/#");
    if (!url_.starts_with("http://") || hash == std::string::npos) {
        ADD_FAILURE() << "not an address: " << url_;
        return;
    }
    port_ = std::stoi(url_.substr(colon + 1));
    token_ = url_.substr(hash + 2);
}

Viewer::~Viewer() {
    if (!thread_.joinable()) return;
    end_ = true;
    thread_.join();
    EXPECT_EQ(outcome_.exit_code, 130) << outcome_.err;
    if (said_.empty()) {
        EXPECT_EQ(outcome_.err, "error: interrupted\n");
    } else {
        EXPECT_THAT(outcome_.err, testing::Says(said_));
    }
}

std::string Viewer::host_header() const {
    return "Host: 127.0.0.1:" + std::to_string(port_);
}

HttpAnswer Viewer::ask(const std::string& method, const std::string& path,
                       const std::vector<std::string>& headers, const std::string& body) const {
    std::string request = method + " " + path + " HTTP/1.1\r\nConnection: close\r\n";
    for (const std::string& header : headers)
        request += header + "\r\n";
    if (!body.empty()) request += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    return parse(send_raw(port_, request + "\r\n" + body));
}

HttpAnswer Viewer::get(const std::string& path) const {
    return ask("GET", path, {host_header(), token_header()});
}

HttpAnswer Viewer::post(const std::string& path, const std::string& body) const {
    return ask("POST", path, {host_header(), token_header(), "Content-Type: application/json"},
               body);
}

JsonValue Viewer::wait_for(const std::function<bool(const JsonValue& state)>& wanted) const {
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
        JsonValue state = get("/api/state").json();
        if (wanted(state)) return state;
        if (std::chrono::steady_clock::now() - begin > kPatience) {
            ADD_FAILURE() << "it did not come: " << get("/api/state").body;
            return state;
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

const JsonValue& member(const JsonValue& object, const std::string& key) {
    static const JsonValue nothing;
    const JsonMember* found = object.find(key);
    if (found == nullptr) ADD_FAILURE() << "there is no `" << key << "`";
    return found == nullptr ? nothing : found->value;
}

}  // namespace openfab::testing
