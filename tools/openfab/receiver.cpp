// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/receiver.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "backends/common/tee_sink.h"
#include "backends/ofr/format.h"
#include "backends/ofr/slice_codec.h"
#include "base/clock.h"
#include "base/messages.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "runtime/pipeline/print_hash.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

using stream::Kind;
using stream::Mode;
using stream::StopCode;

constexpr size_t kMostClients = 16;
constexpr size_t kMostOut = 64 << 10;  ///< of answers that a client does not take
constexpr double kByeSeconds = 60;     ///< how long a sender may take to hear that all is kept
constexpr double kDeafSeconds = 2;     ///< for the last words to a client
constexpr size_t kMostHosts = 256;     ///< whose wrong tokens are remembered
constexpr double kFirstPause = 0.25;  ///< seconds after a wrong token; doubled for each further one
constexpr double kInterruptSeconds = 0.2;  ///< until an interrupt is seen
constexpr double kLongestPause = 8;        ///< below kOpenSeconds

/// Processes of this machine are one host.
std::string host_of(const std::string& from) {
    return from.substr(0, from.find_last_of(':'));
}

}  // namespace

Receiver::Client::Client(stream::Line line, std::string from)
    : line(std::move(line)), from(std::move(from)), since(seconds_now()), said(since) {}

Receiver::Receiver(stream::Socket listening, ReceiverOptions options, OpenSink open_sink)
    : listening_(std::move(listening)),
      options_(std::move(options)),
      open_sink_(std::move(open_sink)),
      clock_(options_.layer_seconds, options_.buffer) {}

/// Compares all bytes, so that the time does not tell how many are right.
bool Receiver::is_token(const std::string& given) const {
    if (options_.token.empty()) return true;
    unsigned different = given.size() == options_.token.size() ? 0 : 1;
    for (size_t i = 0; i < given.size(); ++i)
        different |=
            static_cast<unsigned char>(given[i] ^ options_.token[i % options_.token.size()]);
    return different == 0;
}

Receiver::Client* Receiver::sender() {
    for (Client& client : clients_) {
        if (client.is_sender && !client.closing) return &client;
    }
    return nullptr;
}

void Receiver::send(Client* client, const std::vector<uint8_t>& message) {
    client->said = seconds_now();
    client->out.insert(client->out.end(), message.begin(), message.end());
    if (client->out.size() > kMostOut) client->closing = true;  // it does not listen
}

void Receiver::stop(Client* client, StopCode code, const std::string& text) {
    send(client, stream::frame_stop(code, text));
    client->closing = true;
}

void Receiver::accept_clients() {
    for (;;) {
        stream::Socket socket(
            ::accept4(listening_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        if (!socket.is_open()) return;
        if (clients_.size() >= kMostClients) {
            // The oldest stranger makes room, so that a crowd of them keeps no sender out.
            const auto stranger = std::find_if(clients_.begin(), clients_.end(),
                                               [](const Client& c) { return !c.is_sender; });
            if (stranger == clients_.end()) continue;
            clients_.erase(stranger);
        }
        std::unique_ptr<stream::TlsSession> session;
        if (options_.tls != nullptr) session = options_.tls->accept(socket);
        if (options_.tls != nullptr && session == nullptr) continue;
        std::string from = stream::other_end(socket);
        clients_.emplace_back(stream::Line(std::move(socket), std::move(session)), std::move(from));
    }
}

/// A host that came with wrong tokens waits before its next one is looked at, and before it is told,
/// so that tokens cannot be tried out at any rate.
Result<void> Receiver::open(Client* client, stream::Message* message) {
    const auto wrong = wrong_tokens_.find(host_of(client->from));
    if (wrong != wrong_tokens_.end() && seconds_now() < wrong->second.until) {
        client->waiting = std::move(*message);
        client->waits_until = wrong->second.until;
        return {};
    }
    return open_now(client, *message);
}

Result<void> Receiver::answer_waiting() {
    for (Client& client : clients_) {
        if (client.waits_until == 0 || client.closing || seconds_now() < client.waits_until)
            continue;
        client.waits_until = 0;
        client.since = seconds_now();
        if (client.has_wrong_token) {
            stop(&client, StopCode::kToken, messages::kTokenWrong);
        } else {
            stream::Message message = std::move(client.waiting);
            if (Result<void> opened = open(&client, &message); !opened) return opened;
        }
    }
    return {};
}

Result<void> Receiver::open_now(Client* client, const stream::Message& message) {
    Result<stream::Open> open = stream::read_open(message.bytes);
    if (!open) {
        stop(client, StopCode::kProtocol, open.error().text());
        return {};
    }
    const std::string host = host_of(client->from);
    if (!is_token(open->token)) {
        ++refused_;
        if (wrong_tokens_.size() >= kMostHosts && wrong_tokens_.count(host) == 0)
            wrong_tokens_.erase(wrong_tokens_.begin());
        WrongTokens& wrong = wrong_tokens_[host];
        const double pause = std::min(kFirstPause * std::exp2(wrong.count), kLongestPause);
        ++wrong.count;
        wrong.until = client->waits_until = seconds_now() + pause;
        client->has_wrong_token = true;
        tell("wrong token", client->from, fmt::format(messages::kWrongTokenFrom, client->from));
        return {};
    }
    wrong_tokens_.erase(host);
    Result<pipeline::PrintInfo> info = ofr::read_header(open->header);
    if (!info) {
        stop(client, StopCode::kProtocol, info.error().text());
        return {};
    }
    if (most_bytes(*info) > options_.memory_bytes) {
        tell("refused", client->from,
             fmt::format(messages::kPrintRefusedMemory, client->from, info->size.x, info->size.y,
                         format_bytes(most_bytes(*info)), format_bytes(options_.memory_bytes)));
        stop(client, StopCode::kProtocol,
             fmt::format(messages::kSlicesTakeTooMuch,
                         format_bytes(static_cast<int64_t>(slice_bytes(*info))),
                         format_bytes(most_bytes(*info))));
        return {};
    }
    // A print whose line was cut is kept for its sender for as long as that looks for this end; one
    // that was killed leaves it to whoever prints the same.
    Client* const other = sender();
    const bool is_held = is_unfinished_ && seconds_now() < held_until_ &&
                         !(open->mode == Mode::kSendBack && open->header == header_);
    if (open->sender != sender_ && (other != nullptr || is_held)) {
        ++refused_;
        tell("refused", client->from, fmt::format(messages::kSecondSender, client->from));
        stop(client, StopCode::kBusy, messages::kAnotherPrint);
        return {};
    }
    if (other != nullptr) other->closing = true;  // its line was cut, and this end has not noticed
    tell("sender", client->from, fmt::format(messages::kSenderCame, client->from));
    return begin_print(client, *open, *info);
}

Result<void> Receiver::handle(Client* client, stream::Message* message) {
    if (!client->is_sender) {
        if (message->kind == Kind::kOpen && client->waits_until == 0) return open(client, message);
        ++refused_;
        stop(client, StopCode::kProtocol, messages::kReceiverOfPrints);
        return {};
    }
    switch (message->kind) {
        case Kind::kAlive:
            return {};
        case Kind::kSlice:
            if (!complete_ && kept_ == nullptr)
                return take_slice(client, std::move(message->bytes));
            break;
        case Kind::kDone:
            if (kept_ == nullptr) return take_index(client, message->bytes);
            break;
        case Kind::kStop:
            bye_ = complete_;
            held_until_ = 0;
            client->closing = true;
            return {};
        default:
            break;
    }
    ++order_errors_;
    say(fmt::format(messages::kUnexpectedMessage, next_));
    stop(client, StopCode::kAgain, messages::kMessageNotExpected);
    return {};
}

/// Sends acknowledgements of what the printer has room for.
void Receiver::acknowledge() {
    clock_.advance(seconds_now());
    const int32_t may = std::min(next_, info_.slice_begin + clock_.room());
    Client* const client = sender();
    if (client == nullptr || may <= acknowledged_) return;
    acknowledged_ = may;
    send(client, stream::frame_acknowledge(may - 1));
}

/// A sender that sends more than its window has to wait.
bool Receiver::may_read(const Client& client) const {
    return !client.closing && !(client.is_sender && next_ - acknowledged_ > window());
}

/// The line is gone; the print waits for its sender.
void Receiver::lose(Client* client) {
    if (client->is_sender && !client->closing && !complete_) {
        ++cuts_;
        held_until_ = seconds_now() + stream::kLostSeconds;
        tell("cut", client->from, fmt::format(messages::kLineCut, next_));
    }
    client->line.close();
}

Result<void> Receiver::hear(Client* client) {
    if (!client->line.receive()) {
        lose(client);
        return {};
    }
    stream::Message message;
    while (!client->closing) {
        Result<bool> got = client->line.next(&message);
        if (!got && client->is_sender) {
            ++checksum_errors_;
            say(fmt::format(messages::kMessageDamagedAt, next_));
            stop(client, StopCode::kAgain, messages::kMessageDamaged);
            return {};
        }
        if (!got) {
            ++refused_;
            stop(client, StopCode::kProtocol, messages::kReceiverOfPrints);
            return {};
        }
        if (!*got) return {};
        if (Result<void> handled = handle(client, &message); !handled) return handled;
    }
    return {};
}

void Receiver::flush(Client* client) {
    if (client->out.empty() || !client->line.is_open()) return;
    const int64_t n = client->line.send_some(client->out);
    if (n < 0) return lose(client);
    if (n > 0) client->said = seconds_now();
    client->out.erase(client->out.begin(), client->out.begin() + static_cast<std::ptrdiff_t>(n));
}

/// Tells senders that this end is there, and closes lines that are done or were silent for too
/// long.
void Receiver::tidy() {
    const double now = seconds_now();
    for (Client& client : clients_) {
        if (client.is_sender && !client.closing && client.out.empty() &&
            now - client.said > stream::kAliveSeconds)
            send(&client, stream::frame(Kind::kAlive, {}));
        flush(&client);
        const bool takes_nothing =
            !client.out.empty() && now - client.said > stream::kSilentSeconds;
        // Who waits for what was kept has nothing to say.
        const bool is_silent = kept_ == nullptr && may_read(client) &&
                               now - client.line.heard() > stream::kSilentSeconds;
        if (client.is_sender && !client.closing && (takes_nothing || is_silent)) lose(&client);
    }
    clients_.remove_if([&](const Client& client) {
        if (!client.line.is_open()) return true;
        if (client.closing) return client.out.empty() || now - client.said > kDeafSeconds;
        return !client.is_sender && client.waits_until == 0 &&
               now - client.since > stream::kOpenSeconds;
    });
}

Result<void> Receiver::turn() {
    std::vector<pollfd> polled{{listening_.fd(), POLLIN, 0}};
    std::vector<Client*> clients;
    for (Client& client : clients_) {
        const int wants = (may_read(client) ? POLLIN : 0) | (client.out.empty() ? 0 : POLLOUT);
        polled.push_back({client.line.fd(), static_cast<int16_t>(wants), 0});
        clients.push_back(&client);
    }
    if (kept_ != nullptr) polled.push_back({kept_->fd(), POLLIN, 0});
    // A signal may reach another thread.
    const double most = options_.interrupt != nullptr ? kInterruptSeconds : 1.0;
    double wait = std::clamp(clock_.due() - seconds_now(), 0.0, most);
    for (const Client& client : clients_) {
        if (client.waits_until != 0)
            wait = std::clamp(client.waits_until - seconds_now(), 0.0, wait);
    }
    ::poll(polled.data(), polled.size(), static_cast<int>(std::ceil(wait * 1000)));
    for (size_t i = 0; i < clients.size(); ++i) {
        if ((polled[i + 1].revents & (POLLIN | POLLERR | POLLHUP)) == 0) continue;
        if (Result<void> heard = hear(clients[i]); !heard) return heard;
    }
    if (Result<void> answered = answer_waiting(); !answered) return answered;
    if (Result<void> read = read_back(); !read) return read;
    if (Result<void> there = check_output(); !there) return there;
    if (kept_ == nullptr && (sink_ != nullptr || complete_)) acknowledge();
    if ((polled[0].revents & POLLIN) != 0) accept_clients();
    tidy();
    return {};
}

void Receiver::tell(const char* event, const std::string& from, const std::string& text) const {
    say(text);
    if (options_.log == nullptr) return;
    const size_t end = text.find_last_not_of('\n');
    options_.log->add(event, from, info_.title, next_,
                      end == std::string::npos ? "" : text.substr(0, end + 1));
}

void Receiver::summarise() const {
    std::string text =
        fmt::format(messages::kAllSlicesKept, info_.slice_end - info_.slice_begin, received_);
    if (options_.layer_seconds > 0) {
        text += fmt::format(messages::kPrinterWaited, clock_.starved(), clock_.starved_seconds());
    }
    say(fmt::format(messages::kLinesCut, text, cuts_, order_errors_, checksum_errors_, refused_));
}

Error Receiver::interrupted() const {
    const bool any = sink_ != nullptr || is_unfinished_;
    return {ErrorCode::kInterrupted,
            any ? fmt::format(messages::kInterruptedBeforeSlice, next_)
                : std::string(openfab::messages::kInterrupted),
            "",
            {}};
}

/// The story first: what follows may take longer than there is time after a signal.
void Receiver::end_early(const Error& why) {
    const std::string reason = options_.stopped ? options_.stopped(why) : why.text();
    if (options_.log != nullptr) options_.log->add("stop", "", info_.title, next_, reason);
    close_sink();
    const bool hurries = why.code == ErrorCode::kInterrupted;
    for (Client& client : clients_)
        client.line.send_all(client.out, hurries ? kInterruptSeconds : kDeafSeconds);
}

Result<void> Receiver::run() {
    for (;;) {
        const bool stops = options_.interrupt != nullptr && options_.interrupt->load();
        const Result<void> turned = stops ? Result<void>(interrupted()) : turn();
        if (!turned) {
            end_early(turned.error());
            return turned;
        }
        const bool heard = bye_ || seconds_now() - complete_at_ > kByeSeconds;
        if (!complete_ || !clock_.finished() || !heard) continue;
        summarise();
        return {};
    }
}

}  // namespace openfab::tools
