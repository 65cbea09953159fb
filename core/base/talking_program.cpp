// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/talking_program.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>

#include "base/messages.h"
#include "base/text.h"

namespace openfab {

namespace {

constexpr const char* kDone = "done";
/// How long a program has, once its input has ended.
constexpr int32_t kLastMs = 500;
/// How often a waiting print looks whether it is to stop.
constexpr int64_t kLookMs = 100;

/// Returns where the line `done` begins in a text, whose lines before `from` are none; npos if there is none.
size_t find_done(const std::string& text, size_t from) {
    for (size_t at = from; at < text.size();) {
        const size_t end = text.find('\n', at);
        if (end == std::string::npos) return end;
        const size_t length = end > at && text[end - 1] == '\r' ? end - at - 1 : end - at;
        if (text.compare(at, length, kDone) == 0) return at;
        at = end + 1;
    }
    return std::string::npos;
}

std::function<int(const std::string&)>& line_opener() {
    static std::function<int(const std::string&)> opener;
    return opener;
}

}  // namespace

void set_line_opener(std::function<int(const std::string&)> open) {
    line_opener() = std::move(open);
}

TalkingProgram::TalkingProgram(std::vector<std::string> command, std::filesystem::path folder,
                               const Limits& limits)
    : command_(std::move(command)), folder_(std::move(folder)), limits_(limits) {
    name_ = command_[0];
    // `python3 trees.py` is called by both words, as people do.
    if (command_.size() > 1 && !command_[1].starts_with("-")) name_ += " " + command_[1];
    if (command_[0] == kThisProcess) name_ = messages::kTheGenerator;
    name_ = printable(name_);
}

TalkingProgram::~TalkingProgram() {
    end();
}

bool TalkingProgram::has_ended(int32_t ms) const {
    constexpr int32_t kStepMs = 5;
    for (int32_t waited = 0;; waited += kStepMs) {
        siginfo_t info{};
        const int got =
            ::waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT);
        if ((got != 0 && errno != EINTR) || info.si_pid != 0) return true;
        if (waited >= ms) return false;
        ::poll(nullptr, 0, kStepMs);
    }
}

int TalkingProgram::end_group() {
    // Before its leader is waited for: until then its number is nobody else's.
    ::kill(-process_, SIGKILL);
    running_.reset();
    int status = 0;
    while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = 0;
    watch_.reset();
    return status;
}

/// Its input ends, which ends most; then it is asked to end, and killed, with what it has started.
void TalkingProgram::end() {
    if (line_ >= 0) ::close(line_);
    line_ = -1;
    if (process_ <= 0) return;
    constexpr int32_t kAskedMs = 200;
    if (!has_ended(kLastMs)) {
        ::kill(-process_, SIGTERM);
        (void)has_ended(kAskedMs);
    }
    end_group();
}

Result<void> TalkingProgram::start() {
    if (command_[0] == kThisProcess) {
        if (line_opener() != nullptr && command_.size() > 1) line_ = line_opener()(command_[1]);
        if (line_ >= 0) return {};
        return user_error(messages::kOtherProcess, messages::kOtherProcessHelp);
    }
    // A socket, since what is sent to a closed one raises no signal.
    int ends[2];
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return outside_error(fmt::format(messages::kNoLine, name_, strerror(errno)));
    ProgramStart start;
    start.argv = command_;
    start.search = true;
    start.folder = folder_;
    start.in = start.out = ends[1];
    // It ends as a whole, and Ctrl-C reaches us alone, who end it.
    start.own_group = true;
    const int failed = start_program(start, &process_);
    ::close(ends[1]);
    line_ = ends[0];
    if (failed != 0) {
        process_ = 0;
        end();
        return user_error(fmt::format(messages::kDoesNotStart, name_, strerror(failed)),
                          messages::kDoesNotStartHelp);
    }
    running_ = std::make_unique<RunningGroup>(process_);
    watch_ = std::make_unique<GroupWatch>(process_);
    return {};
}

Error TalkingProgram::ended(const std::string& asked) {
    if (line_ >= 0) ::close(line_);
    line_ = -1;
    std::string how = messages::kHasEnded;
    if (process_ > 0) {
        // One that closes its output and goes on is not waited for.
        if (has_ended(kLastMs)) {
            const int status = end_group();
            if (WIFSIGNALED(status))
                how = fmt::format(messages::kEndedBySignal, WTERMSIG(status),
                                  strsignal(WTERMSIG(status)));
            if (WIFEXITED(status)) how = fmt::format(messages::kEndedWithCode, WEXITSTATUS(status));
        } else {
            how = messages::kClosedOutput;
        }
    }
    end();
    return user_error(fmt::format(messages::kEndedBeforeAnswer, name_, how, asked),
                      messages::kEndedBeforeAnswerHelp);
}

Result<std::string> TalkingProgram::ask(const std::string& line, const std::atomic<bool>* stop) {
    if (failed_) return user_error(fmt::format(messages::kFailedBefore, name_));
    failed_ = true;
    if (line_ < 0) {
        if (Result<void> started = start(); !started) return started.error();
    }
    pollfd early{line_, POLLIN, 0};
    if (::poll(&early, 1, 0) > 0 && (early.revents & POLLIN) != 0) {
        char text[60];
        const ssize_t n = ::recv(line_, text, sizeof text, MSG_DONTWAIT);
        if (n > 0) {
            end();
            return user_error(fmt::format(messages::kWroteUnasked, name_,
                                          printable({text, static_cast<size_t>(n)}), line),
                              messages::kWroteUnaskedHelp);
        }
    }
    if (Result<void> sent = send(line); !sent) return sent.error();
    Result<std::string> answer = receive(line, stop);
    failed_ = !answer.has_value();
    return answer;
}

/// A line is short: it fits the socket's buffer.
Result<void> TalkingProgram::send(const std::string& line) {
    const std::string text = line + "\n";
    for (size_t sent = 0; sent < text.size();) {
        const ssize_t n = ::send(line_, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return ended(line);
        sent += static_cast<size_t>(n);
    }
    return {};
}

Result<std::string> TalkingProgram::receive(const std::string& asked,
                                            const std::atomic<bool>* stop) {
    using Clock = std::chrono::steady_clock;
    const auto until = Clock::now() + std::chrono::milliseconds(limits_.answer_ms);
    received_.clear();
    size_t begun = 0;  // of the last line that is not whole
    std::vector<char> block(size_t{1} << 16);
    while (true) {
        if (stop != nullptr && stop->load(std::memory_order_relaxed)) {
            end();
            return Error{ErrorCode::kInterrupted, messages::kInterrupted, {}, {}};
        }
        const int64_t left =
            std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
        if (left <= 0) {
            end();
            return user_error(
                fmt::format(messages::kNoAnswerInTime, name_, asked, limits_.answer_ms / 1000.0),
                messages::kNoAnswerInTimeHelp);
        }
        pollfd line{line_, POLLIN, 0};
        if (::poll(&line, 1, static_cast<int>(std::min(left, kLookMs))) <= 0) continue;
        const ssize_t n = ::recv(line_, block.data(), block.size(), MSG_DONTWAIT);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) continue;
        if (n <= 0) return ended(asked);
        received_.append(block.data(), static_cast<size_t>(n));
        if (const size_t done = find_done(received_, begun); done != std::string::npos) {
            if (received_.find('\n', done) + 1 != received_.size()) {
                end();
                return user_error(fmt::format(messages::kWroteAfterDone, name_, asked),
                                  messages::kWroteAfterDoneHelp);
            }
            received_.resize(done);
            return std::move(received_);
        }
        const size_t last = received_.rfind('\n');
        begun = last == std::string::npos ? 0 : last + 1;
        if (received_.size() > limits_.most_bytes) {
            end();
            return user_error(
                fmt::format(messages::kAnswerTooLong, name_, limits_.most_bytes >> 20, asked),
                messages::kAnswerTooLongHelp);
        }
    }
}

}  // namespace openfab
