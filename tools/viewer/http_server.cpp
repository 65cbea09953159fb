// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/http_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <httplib.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <exception>
#include <utility>

#include "base/json_text.h"
#include "base/text.h"

namespace openfab::viewer {

namespace {

/// Two browser windows keep six connections each.
constexpr size_t kThreads = 14;
constexpr size_t kLargestBody = 4 << 20;  ///< a fablet's source with its JSON
constexpr time_t kIdleSeconds = 2;
constexpr time_t kPatienceSeconds = 5;
constexpr size_t kRequestsAConnection = 10000;
constexpr size_t kMostHeaders = 64;

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
        return outside_error("the system gives no random numbers");
    std::string token;
    for (const unsigned char byte : bytes)
        token += fmt::format("{:02x}", byte);
    return token;
}

/// In a time that does not tell how much of it is right.
bool same_secret(const std::string& a, const std::string& b) {
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

void refuse(httplib::Response& response, int status, const std::string& why) {
    response.status = status;
    response.set_content(error_json(why), "application/json");
}

}  // namespace

struct HttpServer::Implementation {
    httplib::Server server;
    ServerOptions options;
    Handler handler;
    std::string token;
    int port = 0;

    using Handled = httplib::Server::HandlerResponse;

    /// What comes before a body is read.
    Handled admit(const httplib::Request& request, httplib::Response& response) const {
        // A server may ignore ranges (RFC 9110, 14.2). The library would answer thousands of
        // overlapping ones with as many copies. The request is its own, and not constant there.
        const_cast<httplib::Request&>(request).ranges.clear();
        if (!is_own_host(request.get_header_value("Host"), options.address, port)) {
            refuse(response, 421, "this server does not answer to that name");
            return Handled::Handled;
        }
        if (request.method != "GET" && request.method != "POST") {
            refuse(response, 405, "only GET and POST are answered");
            return Handled::Handled;
        }
        if (request.headers.size() > kMostHeaders) {
            refuse(response, 431, "too many headers");
            return Handled::Handled;
        }
        if (request.method == "GET" && send_page(request.path, response)) return Handled::Handled;
        if (!same_secret(request.get_header_value("X-OpenFab-Token"), token)) {
            refuse(response, 403,
                   "the token is wrong: open the address that `openfab view` has written");
            return Handled::Handled;
        }
        return Handled::Unhandled;
    }

    bool send_page(const std::string& path, httplib::Response& response) const {
        const std::string_view name =
            path == "/" ? std::string_view("index.html") : std::string_view(path).substr(1);
        const auto found =
            std::find_if(options.page.begin(), options.page.end(),
                         [&](const EmbeddedText& file) { return file.name == name; });
        if (found == options.page.end()) return false;
        response.set_content(found->text.data(), found->text.size(), type_of(name));
        response.set_header("Cache-Control", "no-cache");
        return true;
    }

    void answer(const httplib::Request& request, httplib::Response& response) const {
        Request ours{request.path, request.method == "POST", {}, request.body};
        for (const auto& [name, value] : request.params)
            ours.query.emplace(name, value);
        Answer answer = handler(ours);
        response.status = answer.status;
        if (answer.step >= 0) response.set_header("X-OpenFab-Step", std::to_string(answer.step));
        response.set_header("Cache-Control",
                            answer.lasting ? "private, max-age=3600, immutable" : "no-store");
        // What a browser keeps is this server's: another one's prints have the same numbers.
        response.set_header("Vary", "X-OpenFab-Token");
        if (answer.status != 204) response.set_content(answer.body, answer.type);
    }

    void set_up() {
        server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
        server.set_payload_max_length(kLargestBody);
        server.set_read_timeout(kPatienceSeconds);
        server.set_write_timeout(kPatienceSeconds);
        server.set_keep_alive_timeout(kIdleSeconds);
        server.set_keep_alive_max_count(kRequestsAConnection);
        server.set_tcp_nodelay(true);
        // Not SO_REUSEPORT, which the library sets: two servers at one port would share requests.
        server.set_socket_options([](socket_t socket) {
            const int yes = 1;
            ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
        });
        server.set_default_headers({{"Content-Security-Policy", kContentPolicy},
                                    {"X-Content-Type-Options", "nosniff"},
                                    {"Referrer-Policy", "no-referrer"},
                                    {"Cross-Origin-Resource-Policy", "same-origin"},
                                    {"Cross-Origin-Opener-Policy", "same-origin"}});
        server.set_pre_routing_handler(
            [this](const httplib::Request& request, httplib::Response& response) {
                return admit(request, response);
            });
        server.set_exception_handler(
            [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) {
                refuse(response, 500, "memory ran out");
            });
        const auto route = [this](const httplib::Request& request, httplib::Response& response) {
            answer(request, response);
        };
        server.Get(".*", route);
        server.Post(".*", route);
    }
};

HttpServer::HttpServer(std::unique_ptr<Implementation> implementation)
    : implementation_(std::move(implementation)) {}
HttpServer::~HttpServer() = default;

Result<std::unique_ptr<HttpServer>> HttpServer::listen(const ServerOptions& options,
                                                       Handler handler, std::string* url) {
    const bool v6 = is_address(options.address, AF_INET6);
    if (!v6 && !is_address(options.address, AF_INET)) {
        return usage_error(
            fmt::format("`--listen`: `{}` is not an address of this machine; write `--listen "
                        "0.0.0.0` for all of them",
                        options.address));
    }
    Result<std::string> token = make_token();
    if (!token) return token.error();
    auto made = std::make_unique<Implementation>();
    made->options = options;
    made->handler = std::move(handler);
    made->token = std::move(*token);
    made->set_up();
    if (options.port == 0) {
        made->port = made->server.bind_to_any_port(options.address);
    } else {
        made->port = made->server.bind_to_port(options.address, options.port) ? options.port : -1;
    }
    if (made->port <= 0) {
        return outside_error(options.port == 0
                                 ? fmt::format("cannot listen at `{}`", options.address)
                                 : fmt::format("cannot listen at `{}`, port {}: is it taken?",
                                               options.address, options.port));
    }
    const std::string any = v6 ? "[::1]" : "127.0.0.1";
    const bool all = options.address == "0.0.0.0" || options.address == "::";
    const std::string host = all  ? any
                             : v6 ? fmt::format("[{}]", options.address)
                                  : options.address;
    *url = fmt::format("http://{}:{}/#{}", host, made->port, made->token);
    return std::unique_ptr<HttpServer>(new HttpServer(std::move(made)));
}

Result<void> HttpServer::serve() {
    if (!implementation_->server.listen_after_bind())
        return outside_error("the server ended: its socket failed");
    return {};
}

}  // namespace openfab::viewer
