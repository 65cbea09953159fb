// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "base/json_text.h"
#include "base/text.h"
#include "tools/viewer/http_connections.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

/// Nothing but our own files runs or is fetched, and no other page frames this one.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

bool is_address(const std::string& text, int family) {
    std::array<unsigned char, sizeof(in6_addr)> bytes{};
    return ::inet_pton(family, text.c_str(), bytes.data()) == 1;
}

bool is_loopback(const std::string& address) {
    return address.starts_with("127.") || address == "::1";
}

std::string own_name() {
    std::array<char, 256> name{};
    return ::gethostname(name.data(), name.size() - 1) == 0 ? lower_ascii(std::string(name.data()))
                                                            : std::string();
}

/// Whether a Host header is one under which a user can have opened this server: a name of another
/// site that resolves to this machine is not. Addresses cannot be rebound, so beyond the loopback
/// any is fine.
bool is_own_host(const std::string& header, const std::string& address, int port) {
    const std::string end = fmt::format(":{}", port);
    if (!header.ends_with(end)) return false;
    std::string host = lower_ascii(header.substr(0, header.size() - end.size()));
    if (host == "localhost") return true;
    const bool v6 = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (v6) host = host.substr(1, host.size() - 2);
    if (host == address) return true;
    if (is_loopback(address)) return !v6 && address == "127.0.0.1" && host == "127.0.0.1";
    return is_address(host, v6 ? AF_INET6 : AF_INET) || (!host.empty() && host == own_name());
}

Result<std::string> make_token() {
    std::array<unsigned char, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        return outside_error(messages::kNoRandomNumbers);
    std::string token;
    for (const unsigned char byte : bytes)
        token += fmt::format("{:02x}", byte);
    return token;
}

/// In a time that does not tell how much of it is right.
bool same_secret(std::string_view a, std::string_view b) {
    if (a.size() != b.size()) return false;
    unsigned difference = 0;
    for (size_t i = 0; i < a.size(); ++i)
        difference |= static_cast<unsigned>(a[i] ^ b[i]);
    return difference == 0;
}

const char* type_of(std::string_view name) {
    if (name.ends_with(".html")) return "text/html; charset=utf-8";
    if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
    if (name.ends_with(".css")) return "text/css; charset=utf-8";
    return "image/svg+xml";
}

/// What every answer says of itself.
std::vector<std::pair<std::string, std::string>> headers(const std::string& type) {
    std::vector<std::pair<std::string, std::string>> made{
        {"Content-Security-Policy", kContentPolicy},
        {"X-Content-Type-Options", "nosniff"},
        {"Referrer-Policy", "no-referrer"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Cross-Origin-Opener-Policy", "same-origin"}};
    if (!type.empty()) made.emplace_back("Content-Type", type);
    return made;
}

Reply refuse(int status, const std::string& why) {
    return {status, headers("application/json"), error_json(why), {}};
}

/// A socket that listens at an address and port, 0: any; -1 where there is none, with errno.
int listen_at(const std::string& address, int port) {
    addrinfo hints{}, *place = nullptr;
    hints.ai_flags = AI_NUMERICHOST;
    hints.ai_socktype = SOCK_STREAM;
    if (::getaddrinfo(address.c_str(), std::to_string(port).c_str(), &hints, &place) != 0) {
        errno = EINVAL;
        return -1;
    }
    const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owned(place, ::freeaddrinfo);
    const int listening = ::socket(place->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (listening < 0) return -1;
    // Not SO_REUSEPORT: two servers at one port would share requests.
    const int yes = 1;
    ::setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (::bind(listening, place->ai_addr, place->ai_addrlen) == 0 &&
        ::listen(listening, SOMAXCONN) == 0)
        return listening;
    const int why = errno;
    ::close(listening);
    errno = why;
    return -1;
}

int port_of(int listening) {
    sockaddr_storage place{};
    socklen_t size = sizeof place;
    if (::getsockname(listening, reinterpret_cast<sockaddr*>(&place), &size) != 0) return 0;
    return ntohs(place.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(place).sin6_port
                                             : reinterpret_cast<sockaddr_in&>(place).sin_port);
}

/// As many connections as the descriptors of this process allow beside the files that it opens.
ConnectionLimits limits() {
    ConnectionLimits made;
    rlimit descriptors{};
    constexpr size_t kFewest = 8;
    if (::getrlimit(RLIMIT_NOFILE, &descriptors) == 0)
        made.connections = std::clamp<size_t>(descriptors.rlim_cur / 4, kFewest, made.connections);
    return made;
}

}  // namespace

struct HttpServer::Implementation {
    ServerOptions options;
    Handler handler;
    std::string token;
    int port = 0;
    std::unique_ptr<Connections> connections;

    /// What needs no more than the head of a request: the page, and refusals.
    std::optional<Reply> admit(const RequestHead& head) const {
        if (!is_own_host(std::string(head.header("host")), options.address, port))
            return refuse(421, messages::kOtherName);
        if (head.method != "GET" && head.method != "POST")
            return refuse(405, messages::kOnlyGetAndPost);
        if (head.method == "GET") {
            if (std::optional<Reply> page = page_file(head.path)) return page;
        }
        // A page of another site says so; it could not know the token.
        const std::string_view origin = head.header("origin");
        if (!origin.empty() && lower_ascii(std::string(origin)) !=
                                   "http://" + lower_ascii(std::string(head.header("host"))))
            return refuse(403, messages::kOtherSites);
        if (!same_secret(head.header("x-openfab-token"), token)) {
            return refuse(403, messages::kTokenWrong);
        }
        return {};
    }

    std::optional<Reply> page_file(const std::string& path) const {
        const std::string_view name =
            path == "/" ? std::string_view("index.html") : std::string_view(path).substr(1);
        const auto found =
            std::find_if(options.page.begin(), options.page.end(),
                         [&](const EmbeddedText& file) { return file.name == name; });
        if (found == options.page.end()) return {};
        Reply reply{200, headers(type_of(name)), {}, found->text};
        reply.headers.emplace_back("Cache-Control", "no-cache");
        return reply;
    }

    Reply answer(const RequestHead& head, const std::string& body) const {
        Answer answer = handler({head.path, head.method == "POST", head.query, body});
        Reply reply{answer.status, headers(answer.type), std::move(answer.body), {}};
        if (answer.step >= 0)
            reply.headers.emplace_back("X-OpenFab-Step", std::to_string(answer.step));
        reply.headers.emplace_back(
            "Cache-Control", answer.lasting ? "private, max-age=3600, immutable" : "no-store");
        // What a browser keeps is this server's: another one's prints have the same numbers.
        reply.headers.emplace_back("Vary", "X-OpenFab-Token");
        return reply;
    }
};

HttpServer::HttpServer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
HttpServer::~HttpServer() = default;

Result<std::unique_ptr<HttpServer>> HttpServer::listen(const ServerOptions& options,
                                                       Handler handler, std::string* url) {
    const bool v6 = is_address(options.address, AF_INET6);
    if (!v6 && !is_address(options.address, AF_INET)) {
        return usage_error(fmt::format(messages::kNotAnAddressHere, options.address));
    }
    Result<std::string> token = make_token();
    if (!token) return token.error();
    const int listening = listen_at(options.address, options.port);
    if (listening < 0) {
        const std::string why = errno == EADDRINUSE ? messages::kIsItTaken : std::strerror(errno);
        const std::string port = options.port == 0 ? "" : fmt::format(", port {}", options.port);
        return outside_error(fmt::format(messages::kCannotListen, options.address, port, why));
    }
    auto made = std::make_unique<Implementation>();
    made->options = options;
    made->handler = std::move(handler);
    made->token = std::move(*token);
    made->port = port_of(listening);
    const Implementation& server = *made;
    made->connections = std::make_unique<Connections>(
        listening,
        Service{[&server](const RequestHead& head) { return server.admit(head); },
                [&server](const RequestHead& head, const std::string& body) {
                    return server.answer(head, body);
                },
                refuse},
        limits());
    const std::string any = v6 ? "[::1]" : "127.0.0.1";
    const bool all = options.address == "0.0.0.0" || options.address == "::";
    const std::string host = all  ? any
                             : v6 ? fmt::format("[{}]", options.address)
                                  : options.address;
    *url = fmt::format("http://{}:{}/#{}", host, made->port, made->token);
    return std::unique_ptr<HttpServer>(new HttpServer(std::move(made)));
}

Result<void> HttpServer::serve() {
    return implementation_->connections->run();
}

}  // namespace openfab::viewer
