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
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "runtime/pipeline/print_hash.h"

namespace openfab::tools {

namespace {

using stream::Kind;
using stream::Mode;
using stream::StopCode;

constexpr size_t kMostClients = 16;
constexpr size_t kMostOut = 64 << 10;  ///< of answers that a client does not take
constexpr double kByeSeconds = 60;     ///< how long a sender may take to hear that all is kept
constexpr double kDeafSeconds = 2;     ///< for the last words to a client

/// An error that ends the print, as against one of a client, which ends its line.
bool is_ours(const Error& error) {
    return error.code == ErrorCode::kOutside || error.code == ErrorCode::kInternal;
}

}  // namespace

Receiver::Client::Client(stream::Line line)
    : line(std::move(line)), since(seconds_now()), said(since) {}

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

int64_t Receiver::slice_bytes(const pipeline::PrintInfo& info) const {
    return static_cast<int64_t>(backends::packed_row_bytes(info.size.x, info.bits)) * info.size.y;
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
        clients_.emplace_back(stream::Line(std::move(socket), std::move(session)));
    }
}

void Receiver::close_sink() {
    if (sink_ != nullptr) (void)sink_->finish({});
    sink_.reset();
}

Result<void> Receiver::open(Client* client, const stream::Message& message) {
    Result<stream::Open> open = stream::read_open(message.bytes);
    if (!open) {
        stop(client, StopCode::kProtocol, open.error().text());
        return {};
    }
    if (!is_token(open->token)) {
        ++refused_;
        say("a sender came with a wrong token\n");
        stop(client, StopCode::kToken, "the token is wrong or missing");
        return {};
    }
    Result<pipeline::PrintInfo> info = ofr::read_header(open->header);
    if (!info) {
        stop(client, StopCode::kProtocol, info.error().text());
        return {};
    }
    if (2 * slice_bytes(*info) > options_.memory_bytes) {
        stop(client, StopCode::kProtocol,
             fmt::format("slices of {} take too much memory", format_bytes(slice_bytes(*info))));
        return {};
    }
    // A print whose line was cut is kept for its sender for as long as that looks for this end; one
    // that was killed leaves it to whoever prints the same.
    Client* const other = sender();
    const bool is_held = sink_ != nullptr && seconds_now() < held_until_ &&
                         !(open->mode == Mode::kSendBack && open->header == header_);
    if (open->sender != sender_ && (other != nullptr || is_held)) {
        ++refused_;
        say("a second sender was refused\n");
        stop(client, StopCode::kBusy, "another print is under way");
        return {};
    }
    if (other != nullptr) other->closing = true;  // its line was cut, and this end has not noticed
    return begin_print(client, *open, *info);
}

Result<void> Receiver::begin_print(Client* client, const stream::Open& open,
                                   const pipeline::PrintInfo& info) {
    client->is_sender = true;
    client->line.allow(std::max<size_t>(
        ofr::kSliceHeadBytes + ofr::most_frame_bytes(static_cast<size_t>(slice_bytes(info))),
        12 * static_cast<size_t>(info.size.z) + 4096));
    const bool goes_on = open.mode == Mode::kGoOn && (sink_ != nullptr || complete_) &&
                         open.sender == sender_ && open.header == header_;
    if (!goes_on) {
        close_sink();
        bool line_is_there = true;
        const Result<int32_t> kept = open_output(client, open, info, &line_is_there);
        if (!line_is_there) {
            close_sink();
            client->closing = true;
            return {};
        }
        if (!kept) {
            close_sink();
            if (is_ours(kept.error())) {
                stop(client, StopCode::kDisk, "it cannot write its output");
                return kept.error();
            }
            // Who sends has no business with what this end's files are called.
            say(fmt::format("a print was refused: {}\n", printable(kept.error().text())));
            stop(client, StopCode::kOtherPrint, "it holds another print, or a complete one");
            return {};
        }
        header_ = open.header;
        info_ = info;
        rows_.resize(static_cast<size_t>(slice_bytes(info)));
        next_ = info.slice_begin + *kept;
        complete_ = false;
        clock_.begin(info.slice_end - info.slice_begin, *kept);
        say(fmt::format("`{}`: {} slices, from slice {}\n", printable(info.title),
                        info.slice_end - info.slice_begin, next_));
    }
    sender_ = open.sender;
    acknowledged_ = next_;
    send(client,
         stream::frame_ready({next_, static_cast<uint32_t>(window()), complete_ ? 1U : 0U}));
    return {};
}

int32_t Receiver::window() const {
    constexpr auto kMost = static_cast<int32_t>(stream::kMostWindow);
    return options_.layer_seconds > 0 ? std::clamp(options_.buffer, 1, kMost) : kMost;
}

/// Opens the sink and returns how many slices of this print it has. They are sent back where that
/// is asked for; else the sender hears now and then that this end is at work.
Result<int32_t> Receiver::open_output(Client* client, const stream::Open& open,
                                      const pipeline::PrintInfo& info, bool* line_is_there) {
    Result<std::unique_ptr<pipeline::SliceSink>> sink = open_sink_(info, open.mode != Mode::kAnew);
    if (!sink) return sink.error();
    sink_ = std::move(*sink);
    if (Result<void> begun = sink_->begin(info); !begun) return begun.error();
    hash_ = 0;
    double said = seconds_now();
    return sink_->resume([&](const pipeline::SliceView& slice) {
        hash_ += pipeline::slice_hash(slice.z, slice.data, slice.row_bytes, slice.height);
        if (open.mode == Mode::kSendBack) {
            *line_is_there =
                client->line.send_all(stream::frame(Kind::kBack, ofr::encode_slice(slice)));
        } else if (seconds_now() - said > 1) {
            said = seconds_now();
            *line_is_there = client->line.send_all(stream::frame(Kind::kAlive, {}));
        }
        return *line_is_there;
    });
}

Result<void> Receiver::take_slice(Client* client, const std::vector<uint8_t>& bytes) {
    const std::span<const uint8_t> all(bytes);
    const auto damaged = [&](const std::string& why) {
        ++checksum_errors_;
        say(fmt::format("slice {}: {}; it is asked for again\n", next_, why));
        stop(client, StopCode::kAgain, fmt::format("slice {} is damaged", next_));
        return Result<void>();
    };
    if (bytes.size() < ofr::kSliceHeadBytes) return damaged("it is too short");
    const Result<ofr::SliceHead> head = ofr::read_slice_head(all.first(ofr::kSliceHeadBytes));
    if (!head) return damaged(head.error().text());
    if (head->z != next_ || next_ == info_.slice_end) {
        ++order_errors_;
        say(fmt::format("slice {} came where {} was next; it is asked for again\n", head->z,
                        next_));
        stop(client, StopCode::kAgain, fmt::format("slice {} was next", next_));
        return {};
    }
    if (head->frame_bytes != bytes.size() - ofr::kSliceHeadBytes)
        return damaged("its length is wrong");
    const Result<void> decoded = ofr::decode_frame(*head, all.subspan(ofr::kSliceHeadBytes), rows_);
    if (!decoded) return damaged(decoded.error().text());
    const pipeline::SliceView slice{next_, rows_.data(),
                                    backends::packed_row_bytes(info_.size.x, info_.bits),
                                    info_.size.x, info_.size.y};
    const Result<void> kept =
        sink_->commit(next_, options_.keeps_frames ? bytes : sink_->encode(slice));
    if (!kept) {
        stop(client, StopCode::kDisk, "it cannot write its output");
        return kept;
    }
    hash_ += pipeline::slice_hash(slice.z, slice.data, slice.row_bytes, slice.height);
    ++next_;
    ++received_;
    clock_.add(seconds_now());
    return {};
}

Result<void> Receiver::take_index(Client* client, const std::vector<uint8_t>& bytes) {
    Result<ofr::Index> index = ofr::read_index(bytes);
    const bool fits = index && next_ == info_.slice_end && index->totals.hash == hash_;
    if (!fits) {
        ++checksum_errors_;
        say("the index does not fit the slices\n");
        stop(client, StopCode::kProtocol, "the index does not fit the slices");
        return {};
    }
    if (!complete_) {
        index->totals.complete = true;
        const Result<void> finished = sink_->finish(index->totals);
        sink_.reset();
        if (!finished) {
            stop(client, StopCode::kDisk, "it cannot write its output");
            return finished;
        }
        complete_ = true;
        complete_at_ = seconds_now();
    }
    send(client, stream::frame(Kind::kDone, {}));
    return {};
}

Result<void> Receiver::handle(Client* client, const stream::Message& message) {
    if (!client->is_sender) {
        if (message.kind == Kind::kOpen) return open(client, message);
        ++refused_;
        stop(client, StopCode::kProtocol, "this is a receiver of prints");
        return {};
    }
    switch (message.kind) {
        case Kind::kAlive:
            return {};
        case Kind::kSlice:
            if (!complete_) return take_slice(client, message.bytes);
            break;
        case Kind::kDone:
            return take_index(client, message.bytes);
        case Kind::kStop:
            bye_ = complete_;
            held_until_ = 0;
            client->closing = true;
            return {};
        default:
            break;
    }
    ++order_errors_;
    say(fmt::format("a message came that was not expected before slice {}\n", next_));
    stop(client, StopCode::kAgain, "this message was not expected");
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

Result<void> Receiver::hear(Client* client) {
    if (!client->line.receive()) {
        if (client->is_sender && !client->closing && !complete_) {
            ++cuts_;
            held_until_ = seconds_now() + stream::kLostSeconds;
            say(fmt::format("the line was cut before slice {}\n", next_));
        }
        client->line.close();
        return {};
    }
    stream::Message message;
    while (!client->closing) {
        Result<bool> got = client->line.next(&message);
        if (!got && client->is_sender) {
            ++checksum_errors_;
            say(fmt::format("a message was damaged before slice {}\n", next_));
            stop(client, StopCode::kAgain, "a message was damaged");
            return {};
        }
        if (!got) {
            ++refused_;
            stop(client, StopCode::kProtocol, "this is a receiver of prints");
            return {};
        }
        if (!*got) return {};
        if (Result<void> handled = handle(client, message); !handled) return handled;
    }
    return {};
}

void Receiver::flush(Client* client) {
    if (client->out.empty() || !client->line.is_open()) return;
    const int64_t n = client->line.send_some(client->out);
    if (n < 0) return client->line.close();
    client->out.erase(client->out.begin(), client->out.begin() + static_cast<std::ptrdiff_t>(n));
}

/// Tells senders that this end is there, and closes lines that are done or were silent for too
/// long.
void Receiver::tidy() {
    const double now = seconds_now();
    for (Client& client : clients_) {
        if (client.is_sender && !client.closing && now - client.said > stream::kAliveSeconds)
            send(&client, stream::frame(Kind::kAlive, {}));
        flush(&client);
    }
    clients_.remove_if([&](const Client& client) {
        if (!client.line.is_open()) return true;
        if (client.closing) return client.out.empty() || now - client.said > kDeafSeconds;
        return client.is_sender
                   ? may_read(client) && now - client.line.heard() > stream::kSilentSeconds
                   : now - client.since > stream::kOpenSeconds;
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
    const double wait = std::clamp(clock_.due() - seconds_now(), 0.0, 1.0);
    ::poll(polled.data(), polled.size(), static_cast<int>(std::ceil(wait * 1000)));
    for (size_t i = 0; i < clients.size(); ++i) {
        if ((polled[i + 1].revents & (POLLIN | POLLERR | POLLHUP)) == 0) continue;
        if (Result<void> heard = hear(clients[i]); !heard) return heard;
    }
    if (sink_ != nullptr || complete_) acknowledge();
    if ((polled[0].revents & POLLIN) != 0) accept_clients();
    tidy();
    return {};
}

void Receiver::summarise() const {
    std::string text = fmt::format("all {} slices are kept, {} received",
                                   info_.slice_end - info_.slice_begin, received_);
    if (options_.layer_seconds > 0) {
        text += fmt::format("; the printer waited for {} of them, {:.1f} s in all",
                            clock_.starved(), clock_.starved_seconds());
    }
    say(fmt::format(
        "{}; lines cut: {}, slices out of order: {}, damaged: {}, clients refused: {}\n", text,
        cuts_, order_errors_, checksum_errors_, refused_));
}

Result<void> Receiver::run() {
    for (;;) {
        if (Result<void> turned = turn(); !turned) {
            for (Client& client : clients_)
                client.line.send_all(client.out, kDeafSeconds);
            close_sink();
            return turned;
        }
        const bool heard = bye_ || seconds_now() - complete_at_ > kByeSeconds;
        if (!complete_ || !clock_.finished() || !heard) continue;
        summarise();
        return {};
    }
}

}  // namespace openfab::tools
