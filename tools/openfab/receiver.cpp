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
constexpr size_t kMostHosts = 256;     ///< whose wrong tokens are remembered
constexpr double kFirstPause = 0.25;  ///< seconds after a wrong token; doubled for each further one
constexpr double kLongestPause = 8;   ///< below kOpenSeconds

/// An error that ends the print, as against one of a client, which ends its line.
bool is_ours(const Error& error) {
    return error.code == ErrorCode::kOutside || error.code == ErrorCode::kInternal;
}

size_t slice_bytes(const pipeline::PrintInfo& info) {
    return backends::packed_row_bytes(info.size.x, info.bits) * static_cast<size_t>(info.size.y);
}

/// The most that a print takes: a slice's message in the line's buffer and out of it, its rows, and
/// what the sink makes of them; and each slice's place in the output.
int64_t most_bytes(const pipeline::PrintInfo& info) {
    constexpr int64_t kProgram = 32 << 20;
    constexpr int64_t kPlace = 64;
    const auto rows = static_cast<int64_t>(slice_bytes(info));
    const auto framed = static_cast<int64_t>(ofr::most_frame_bytes(slice_bytes(info)));
    return kProgram + rows + 3 * framed + kPlace * info.size.z;
}

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

void Receiver::close_sink() {
    kept_.reset();
    if (sink_ != nullptr) (void)sink_->finish({});
    sink_.reset();
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
            stop(&client, StopCode::kToken, "the token is wrong or missing");
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
        say(fmt::format("a sender came with a wrong token from {}\n", client->from));
        return {};
    }
    wrong_tokens_.erase(host);
    Result<pipeline::PrintInfo> info = ofr::read_header(open->header);
    if (!info) {
        stop(client, StopCode::kProtocol, info.error().text());
        return {};
    }
    if (most_bytes(*info) > options_.memory_bytes) {
        say(
            fmt::format("a print from {} was refused: slices of {} x {} voxels take {} to receive, "
                        "and `--memory` allows {}\n",
                        client->from, info->size.x, info->size.y, format_bytes(most_bytes(*info)),
                        format_bytes(options_.memory_bytes)));
        stop(client, StopCode::kProtocol,
             fmt::format("slices of {} take {} of memory, which is more than is allowed here",
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
        say(fmt::format("a second sender, from {}, was refused\n", client->from));
        stop(client, StopCode::kBusy, "another print is under way");
        return {};
    }
    if (other != nullptr) other->closing = true;  // its line was cut, and this end has not noticed
    say(fmt::format("a sender came from {}\n", client->from));
    return begin_print(client, *open, *info);
}

Result<void> Receiver::begin_print(Client* client, const stream::Open& open,
                                   const pipeline::PrintInfo& info) {
    client->is_sender = true;
    client->line.allow(
        std::max<size_t>(ofr::kSliceHeadBytes + ofr::most_frame_bytes(slice_bytes(info)),
                         12 * static_cast<size_t>(info.size.z) + 4096));
    const bool goes_on = open.mode == Mode::kGoOn &&
                         ((sink_ != nullptr && kept_ == nullptr) || complete_) &&
                         open.sender == sender_ && open.header == header_;
    if (!goes_on) return open_output(client, open, info);
    get_ready(client);
    return {};
}

void Receiver::get_ready(Client* client) {
    acknowledged_ = next_;
    send(client,
         stream::frame_ready({next_, static_cast<uint32_t>(window()), complete_ ? 1U : 0U}));
}

/// Opens the sink and begins to read what it has of this print.
Result<void> Receiver::open_output(Client* client, const stream::Open& open,
                                   const pipeline::PrintInfo& info) {
    close_sink();
    Result<std::unique_ptr<pipeline::SliceSink>> sink = open_sink_(info, open.mode != Mode::kAnew);
    if (!sink) return refuse_output(client, sink.error());
    sink_ = std::move(*sink);
    if (Result<void> begun = sink_->begin(info); !begun)
        return refuse_output(client, begun.error());
    sender_ = open.sender;
    header_ = open.header;
    info_ = info;
    rows_.resize(slice_bytes(info));
    next_ = acknowledged_ = info.slice_begin;
    complete_ = false;
    is_unfinished_ = true;
    kept_ = std::make_unique<KeptSlices>(sink_.get(), open.mode == Mode::kSendBack);
    return {};
}

/// The hold of a print that was cut before stays as it was.
Result<void> Receiver::refuse_output(Client* client, const Error& error) {
    close_sink();
    if (is_ours(error)) {
        stop(client, StopCode::kDisk, "it cannot write its output");
        return error;
    }
    // Who sends has no business with what this end's files are called.
    say(fmt::format("a print from {} was refused: {}\n", client->from, printable(error.text())));
    stop(client, StopCode::kOtherPrint, "it holds another print, or a complete one");
    return {};
}

/// Hands on what was kept, one slice after the other as the sender takes them, and tells it when all
/// are there. The others are heard meanwhile.
Result<void> Receiver::read_back() {
    if (kept_ == nullptr) return {};
    Client* const client = sender();
    if (client == nullptr) {
        close_sink();
        return {};
    }
    flush(client);
    if (client->out.empty()) {
        if (std::optional<std::vector<uint8_t>> frame = kept_->take()) {
            client->said = seconds_now();
            client->out = std::move(*frame);
            flush(client);
        }
    }
    // A slice may be more than what may wait of answers: READY comes once it is gone.
    if (!client->out.empty()) return {};
    const std::optional<KeptSlices::End> end = kept_->end();
    if (!end) return {};
    kept_.reset();
    if (!end->kept) return refuse_output(client, end->kept.error());
    next_ = info_.slice_begin + *end->kept;
    hash_ = end->hash;
    clock_.begin(info_.slice_end - info_.slice_begin, *end->kept);
    say(fmt::format("`{}`: {} slices, from slice {}\n", printable(info_.title),
                    info_.slice_end - info_.slice_begin, next_));
    get_ready(client);
    return {};
}

/// Slices into a file that was deleted would be lost, and acknowledged.
Result<void> Receiver::check_output() {
    constexpr double kLooksEach = 1;
    const double now = seconds_now();
    if (sink_ == nullptr || !options_.output_is_there || now - looked_at_ < kLooksEach) return {};
    looked_at_ = now;
    if (options_.output_is_there()) return {};
    if (Client* const client = sender()) stop(client, StopCode::kDisk, "its output was deleted");
    return outside_error(
        "the output was deleted or replaced while a print came into it: its slices are gone");
}

int32_t Receiver::window() const {
    constexpr auto kMost = static_cast<int32_t>(stream::kMostWindow);
    return options_.layer_seconds > 0 ? std::clamp(options_.buffer, 1, kMost) : kMost;
}

Result<void> Receiver::take_slice(Client* client, std::vector<uint8_t> bytes) {
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
    const auto counts = ofr::count_codes(rows_, info_.bits);
    if (std::any_of(counts.begin() + 1 + static_cast<std::ptrdiff_t>(info_.materials.size()),
                    counts.end(), [](int64_t count) { return count > 0; })) {
        return damaged(fmt::format("it has codes beyond the {} materials of the header",
                                   info_.materials.size()));
    }
    const pipeline::SliceView slice{next_, rows_.data(),
                                    backends::packed_row_bytes(info_.size.x, info_.bits),
                                    info_.size.x, info_.size.y};
    const Result<void> kept =
        sink_->commit(next_, options_.keeps_frames ? std::move(bytes) : sink_->encode(slice));
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
        is_unfinished_ = false;
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

Result<void> Receiver::handle(Client* client, stream::Message* message) {
    if (!client->is_sender) {
        if (message->kind == Kind::kOpen && client->waits_until == 0) return open(client, message);
        ++refused_;
        stop(client, StopCode::kProtocol, "this is a receiver of prints");
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

/// The line is gone; the print waits for its sender.
void Receiver::lose(Client* client) {
    if (client->is_sender && !client->closing && !complete_) {
        ++cuts_;
        held_until_ = seconds_now() + stream::kLostSeconds;
        say(fmt::format("the line was cut before slice {}\n", next_));
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
    double wait = std::clamp(clock_.due() - seconds_now(), 0.0, 1.0);
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
