// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/graph_compiler.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstring>
#include <optional>

#include "base/json_text.h"
#include "base/start_program.h"
#include "client/messages.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

constexpr int kAnswerMs = 20'000;
constexpr size_t kMostBytes = 64u << 20;
constexpr std::string_view kResult = "\"result\":";

/// Takes one message off the front of what was received, once it is whole.
std::optional<std::string> next_message(std::string* received) {
    constexpr std::string_view kHead = "Content-Length: ";
    const size_t end = received->find("\r\n\r\n");
    if (end == std::string::npos || !received->starts_with(kHead)) return std::nullopt;
    size_t length = 0;
    std::from_chars(received->data() + kHead.size(), received->data() + end, length);
    if (received->size() < end + 4 + length) return std::nullopt;
    std::string message = received->substr(end + 4, length);
    received->erase(0, end + 4 + length);
    return message;
}

}  // namespace

GraphCompiler::~GraphCompiler() {
    end();
}

void GraphCompiler::end() {
    if (line_ >= 0) ::close(line_);
    line_ = -1;
    received_.clear();
    if (process_ <= 0) return;
    // It may be at work on something that takes long.
    ::kill(process_, SIGTERM);
    while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
}

Result<void> GraphCompiler::start() {
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return outside_error(fmt::format(messages::kNoLineToCompiler, std::strerror(errno)));
    const std::string program = (programs_ / "openflc").string();
    ProgramStart start;
    start.argv = {program, "lsp"};
    start.in = start.out = ends[1];
    const int failed = start_program(start, &process_);
    ::close(ends[1]);
    line_ = ends[0];
    if (failed != 0) {
        process_ = 0;
        end();
        return outside_error(
            fmt::format(client::messages::kCannotStart, program, std::strerror(failed)));
    }
    const Result<std::string> begun =
        exchange(R"({"jsonrpc":"2.0","id":0,"method":"initialize","params":{}})");
    if (!begun) return begun.error();
    return {};
}

Result<std::string> GraphCompiler::exchange(const std::string& message) {
    const std::string framed = fmt::format("Content-Length: {}\r\n\r\n{}", message.size(), message);
    size_t sent = 0;
    while (true) {
        if (sent == framed.size()) {
            if (std::optional<std::string> answer = next_message(&received_)) return *answer;
        }
        pollfd line{line_, static_cast<short>(sent < framed.size() ? POLLIN | POLLOUT : POLLIN), 0};
        const int ready = ::poll(&line, 1, kAnswerMs);
        if (ready < 0 && errno == EINTR) continue;
        if (ready <= 0) {
            end();
            return user_error(messages::kCompilerTakesTooLong);
        }
        if ((line.revents & POLLOUT) != 0 && sent < framed.size()) {
            const ssize_t n = ::send(line_, framed.data() + sent, framed.size() - sent,
                                     MSG_NOSIGNAL | MSG_DONTWAIT);
            if (n > 0) sent += static_cast<size_t>(n);
        }
        if ((line.revents & (POLLIN | POLLHUP | POLLERR)) == 0) continue;
        char block[1 << 16];
        const ssize_t n = ::recv(line_, block, sizeof block, MSG_DONTWAIT);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
        if (n <= 0 || received_.size() > kMostBytes) {
            end();
            return internal_error(messages::kCompilerEndedDrawing);
        }
        received_.append(block, static_cast<size_t>(n));
    }
}

Result<std::string> GraphCompiler::ask(const std::string& method, const std::filesystem::path& path,
                                       const std::string& text, const JsonValue* action) {
    const std::lock_guard lock(mutex_);
    if (line_ < 0) {
        if (Result<void> started = start(); !started) return started.error();
    }
    JsonText out;
    out.begin_object().member("jsonrpc", "2.0").member("id", ++number_).member("method", method);
    out.key("params").begin_object().member("path", path.string()).member("text", text);
    if (action != nullptr) out.member("action", *action);
    out.end_object().end_object();
    Result<std::string> answer = exchange(out.take());
    if (!answer) return answer;
    const size_t result = answer->find(kResult);
    const size_t error = answer->find("\"error\":");
    if (result != std::string::npos && (error == std::string::npos || result < error))
        return answer->substr(result + kResult.size(),
                              answer->size() - result - kResult.size() - 1);
    const Result<JsonValue> json = parse_json(*answer, "openflc");
    const JsonValue* what = json ? member_of(*json, "error") : nullptr;
    const JsonValue* why = what == nullptr ? nullptr : member_of(*what, "message");
    return user_error(why == nullptr ? messages::kCompilerDidNotAnswer : why->text);
}

}  // namespace openfab::viewer
