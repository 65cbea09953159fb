// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/stream/address.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "backends/stream/messages.h"
#include "base/input_file.h"

namespace openfab::stream {

namespace {

constexpr std::string_view kTcp = "tcp://";
constexpr std::string_view kTls = "tls://";
constexpr std::string_view kUnix = "unix:";

Error system_error(const char* what, const Address& address, const char* why) {
    return outside_error(fmt::format("{} {}: {}", what, address.text, why));
}

using Found = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Result<Found> look_up(const Address& address) {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    const int code = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found);
    if (code != 0) return system_error(messages::kCannotFind, address, gai_strerror(code));
    return Found(found, &freeaddrinfo);
}

sockaddr_un unix_name(const Address& address) {
    sockaddr_un name{};
    name.sun_family = AF_UNIX;
    std::memcpy(name.sun_path, address.path.data(), address.path.size());
    return name;
}

Socket make_socket(int family) {
    return Socket(::socket(family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
}

/// Returns 0 or the error's number.
int connect_within(const Socket& socket, const sockaddr* name, socklen_t bytes, double seconds) {
    if (!socket.is_open()) return errno;
    if (::connect(socket.fd(), name, bytes) == 0) return 0;
    if (errno != EINPROGRESS) return errno;
    pollfd polled{socket.fd(), POLLOUT, 0};
    if (::poll(&polled, 1, static_cast<int>(seconds * 1000)) <= 0) return ETIMEDOUT;
    int code = 0;
    socklen_t size = sizeof(code);
    ::getsockopt(socket.fd(), SOL_SOCKET, SO_ERROR, &code, &size);
    return code;
}

Result<Socket> listen_on(Socket socket, const sockaddr* name, socklen_t bytes,
                         const Address& address) {
    constexpr int kBacklog = 16;
    const int yes = 1;
    if (!socket.is_open())
        return system_error(messages::kCannotListen, address, std::strerror(errno));
    ::setsockopt(socket.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    if (::bind(socket.fd(), name, bytes) != 0 || ::listen(socket.fd(), kBacklog) != 0)
        return system_error(messages::kCannotListen, address, std::strerror(errno));
    return socket;
}

Result<Socket> listen_at_path(const Address& address) {
    const sockaddr_un name = unix_name(address);
    const auto* const generic = reinterpret_cast<const sockaddr*>(&name);
    struct stat there {};
    if (::lstat(address.path.c_str(), &there) == 0) {
        if (!S_ISSOCK(there.st_mode)) {
            return user_error(fmt::format(messages::kPathTaken, address.path));
        }
        if (connect_within(make_socket(AF_UNIX), generic, sizeof(name), 1) != ECONNREFUSED)
            return system_error(messages::kCannotListen, address, messages::kAnotherListens);
        ::unlink(address.path.c_str());
    }
    const mode_t mask = ::umask(077);
    Result<Socket> socket = listen_on(make_socket(AF_UNIX), generic, sizeof(name), address);
    ::umask(mask);
    return socket;
}

bool is_loopback(const sockaddr* name) {
    if (name->sa_family == AF_INET) {
        sockaddr_in v4{};
        std::memcpy(&v4, name, sizeof(v4));
        return (ntohl(v4.sin_addr.s_addr) >> 24) == 127;
    }
    sockaddr_in6 v6{};
    std::memcpy(&v6, name, sizeof(v6));
    return name->sa_family == AF_INET6 && IN6_IS_ADDR_LOOPBACK(&v6.sin6_addr);
}

}  // namespace

bool is_address(const std::string& text) {
    return text.starts_with(kTcp) || text.starts_with(kTls) || text.starts_with(kUnix);
}

Result<Address> parse_address(const std::string& text) {
    Address address;
    address.text = text;
    if (text.starts_with(kUnix)) {
        address.path = text.substr(kUnix.size());
        if (address.path.empty() || address.path.size() >= sizeof(sockaddr_un::sun_path)) {
            return usage_error(
                fmt::format(messages::kSocketPathLength, text, sizeof(sockaddr_un::sun_path) - 1));
        }
        return address;
    }
    address.is_tls = text.starts_with(kTls);
    static_assert(kTcp.size() == kTls.size());
    const std::string rest =
        address.is_tls || text.starts_with(kTcp) ? text.substr(kTcp.size()) : "";
    const size_t colon = rest.find_last_of(':');
    if (colon != std::string::npos) {
        address.host = rest.substr(0, colon);
        address.port = rest.substr(colon + 1);
        if (address.host.size() > 2 && address.host.front() == '[' && address.host.back() == ']')
            address.host = address.host.substr(1, address.host.size() - 2);
    }
    const bool digits = !address.port.empty() && address.port.size() <= 5 &&
                        address.port.find_first_not_of("0123456789") == std::string::npos;
    if (address.host.empty() || !digits || std::atoi(address.port.c_str()) > 65535) {
        return usage_error(fmt::format(messages::kNoAddress, text));
    }
    return address;
}

Result<bool> is_local(const Address& address) {
    if (address.host.empty()) return true;
    Result<Found> found = look_up(address);
    if (!found) return found.error();
    for (const addrinfo* at = found->get(); at != nullptr; at = at->ai_next) {
        if (!is_loopback(at->ai_addr)) return false;
    }
    return true;
}

Socket::Socket(Socket&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

Socket& Socket::operator=(Socket&& other) noexcept {
    if (this == &other) return *this;
    close();
    fd_ = std::exchange(other.fd_, -1);
    return *this;
}

void Socket::close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
}

Result<Socket> connect_to(const Address& address, double seconds) {
    int code = 0;
    if (address.host.empty()) {
        const sockaddr_un name = unix_name(address);
        Socket socket = make_socket(AF_UNIX);
        code =
            connect_within(socket, reinterpret_cast<const sockaddr*>(&name), sizeof(name), seconds);
        if (code == 0) return socket;
        return system_error(messages::kCannotConnect, address, std::strerror(code));
    }
    Result<Found> found = look_up(address);
    if (!found) return found.error();
    for (const addrinfo* at = found->get(); at != nullptr; at = at->ai_next) {
        Socket socket = make_socket(at->ai_family);
        code = connect_within(socket, at->ai_addr, at->ai_addrlen, seconds);
        if (code != 0) continue;
        const int yes = 1;
        ::setsockopt(socket.fd(), IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
        return socket;
    }
    return system_error(messages::kCannotConnect, address, std::strerror(code));
}

Result<Socket> listen_at(const Address& address) {
    if (address.host.empty()) return listen_at_path(address);
    Result<Found> found = look_up(address);
    if (!found) return found.error();
    const addrinfo& first = **found;
    return listen_on(make_socket(first.ai_family), first.ai_addr, first.ai_addrlen, address);
}

std::string listening_text(const Socket& socket, const Address& address) {
    if (address.host.empty()) return address.text;
    sockaddr_storage name{};
    socklen_t bytes = sizeof(name);
    char host[NI_MAXHOST], port[NI_MAXSERV];
    auto* const generic = reinterpret_cast<sockaddr*>(&name);
    if (::getsockname(socket.fd(), generic, &bytes) != 0 ||
        ::getnameinfo(generic, bytes, host, sizeof(host), port, sizeof(port),
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return address.text;
    const bool v6 = std::strchr(host, ':') != nullptr;
    return fmt::format("{}{}{}{}:{}", address.is_tls ? kTls : kTcp, v6 ? "[" : "", host,
                       v6 ? "]" : "", port);
}

std::string other_end(const Socket& socket) {
    sockaddr_storage name{};
    socklen_t bytes = sizeof(name);
    auto* const generic = reinterpret_cast<sockaddr*>(&name);
    if (::getpeername(socket.fd(), generic, &bytes) != 0) return "nowhere";
    if (name.ss_family == AF_UNIX) {
        ucred who{};
        socklen_t size = sizeof(who);
        const bool known = ::getsockopt(socket.fd(), SOL_SOCKET, SO_PEERCRED, &who, &size) == 0;
        return known ? fmt::format(messages::kUserNumber, who.uid) : messages::kThisMachine;
    }
    std::array<char, NI_MAXHOST> host{};
    std::array<char, NI_MAXSERV> port{};
    if (::getnameinfo(generic, bytes, host.data(), host.size(), port.data(), port.size(),
                      NI_NUMERICHOST | NI_NUMERICSERV) != 0)
        return "nowhere";
    return fmt::format("{}:{}", host.data(), port.data());
}

Result<std::string> load_token(const std::string& file) {
    std::string token;
    if (!file.empty()) {
        Result<InputFile> opened = InputFile::open(file);
        if (!opened)
            return with_context(opened.error(), fmt::format(messages::kCannotReadBefore, file));
        Result<std::string> text = opened->read_all(kMostTokenBytes * 4);
        if (!text)
            return with_context(text.error(), fmt::format(messages::kCannotReadBefore, file));
        token = text->substr(0, text->find_first_of("\r\n"));
        if (token.empty()) return user_error(fmt::format(messages::kNoToken, file));
    } else if (const char* set = std::getenv("OPENFAB_TOKEN"); set != nullptr) {
        token = set;
    }
    if (token.size() > kMostTokenBytes) {
        return user_error(fmt::format(messages::kTokenLength, token.size(), kMostTokenBytes));
    }
    return token;
}

}  // namespace openfab::stream
