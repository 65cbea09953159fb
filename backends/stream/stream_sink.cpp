// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/stream/stream_sink.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <utility>

#include "backends/common/messages.h"
#include "backends/common/tee_sink.h"
#include "backends/ofr/slice_codec.h"
#include "backends/stream/messages.h"
#include "base/clock.h"

namespace openfab::stream {

namespace {

constexpr int kMostAgain = 3;  ///< a slice that comes damaged so often is not the line's fault

std::chrono::duration<double> seconds(double s) {
    return std::chrono::duration<double>(s);
}

/// Decodes a slice that came back into `rows` and passes it on.
Result<bool> show_slice(std::span<const uint8_t> bytes, const pipeline::PrintInfo& info, int32_t z,
                        std::vector<uint8_t>* rows,
                        const std::function<bool(const pipeline::SliceView&)>& show) {
    const size_t row_bytes = backends::packed_row_bytes(info.size.x, info.bits);
    rows->resize(row_bytes * static_cast<size_t>(info.size.y));
    if (bytes.size() < ofr::kSliceHeadBytes) return user_error(messages::kSliceDamaged);
    Result<ofr::SliceHead> head = ofr::read_slice_head(bytes.first(ofr::kSliceHeadBytes));
    if (!head || head->z != z || z >= info.slice_end) return user_error(messages::kSliceDamaged);
    const Result<void> decoded =
        ofr::decode_frame(*head, bytes.subspan(ofr::kSliceHeadBytes), *rows);
    if (!decoded) return user_error(messages::kSliceDamaged);
    return show({z, rows->data(), row_bytes, info.size.x, info.size.y});
}

}  // namespace

StreamSink::StreamSink(Address address, std::string token, std::unique_ptr<TlsContext> tls,
                       bool resumed, const std::atomic<bool>* interrupt)
    : address_(std::move(address)),
      token_(std::move(token)),
      tls_(std::move(tls)),
      resumed_(resumed),
      interrupt_(interrupt),
      line_(Socket()),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    std::random_device random;
    sender_ = static_cast<uint64_t>(random()) << 32 | random();
}

StreamSink::~StreamSink() {
    {
        const std::lock_guard lock(mutex_);
        quit_ = true;
    }
    (void)::eventfd_write(wake_, 1);
    if (thread_.joinable()) thread_.join();
    if (wake_ >= 0) ::close(wake_);
}

Error StreamSink::stopped(const Stop& stop) const {
    const std::string text = fmt::format(messages::kReceiverSays, address_.text, stop.text);
    switch (stop.code) {
        case StopCode::kToken:
            return user_error(text, messages::kGiveToken);
        case StopCode::kOtherPrint:
            return user_error(text);
        default:
            return outside_error(text);
    }
}

Result<Line> StreamSink::connect(Mode mode) const {
    Result<Socket> socket = connect_to(address_, kConnectSeconds);
    if (!socket) return socket.error();
    std::unique_ptr<TlsSession> session;
    if (tls_ != nullptr) {
        auto connected = tls_->connect(*socket, address_, kConnectSeconds);
        if (!connected) return connected.error();
        session = std::move(*connected);
    }
    Line line(std::move(*socket), std::move(session));
    const size_t raw =
        backends::packed_row_bytes(info_.size.x, info_.bits) * static_cast<size_t>(info_.size.y);
    line.allow(ofr::kSliceHeadBytes + ofr::most_frame_bytes(raw) + 1024);
    if (!line.send_all(frame_open({mode, sender_, token_, header_})))
        return outside_error(fmt::format(messages::kLineCut, address_.text));
    return line;
}

Result<std::optional<Ready>> StreamSink::hear_ready(
    Line* line, const std::function<bool(const pipeline::SliceView&)>& show, int32_t* shown) const {
    Message message;
    std::vector<uint8_t> rows;
    for (;;) {
        Result<bool> got = line->wait(&message);
        if (!got) return with_context(got.error(), address_.text + ": ");
        if (!*got) return std::optional<Ready>();
        if (message.kind == Kind::kStop) return stopped(read_stop(message.bytes));
        if (message.kind == Kind::kBack && show) {
            Result<bool> more =
                show_slice(message.bytes, info_, info_.slice_begin + *shown, &rows, show);
            if (!more) return with_context(more.error(), address_.text + ": ");
            if (!*more) return Error{ErrorCode::kInterrupted, messages::kInterruptedComingBack};
            ++*shown;
            continue;
        }
        if (message.kind != Kind::kReady)
            return outside_error(address_.text + messages::kNoReceiver);
        Result<Ready> ready = read_ready(message.bytes);
        if (!ready) return with_context(ready.error(), address_.text + ": ");
        if (ready->next < info_.slice_begin || ready->next > info_.slice_end)
            return outside_error(address_.text + messages::kNoSuchSlice);
        return std::optional<Ready>(*ready);
    }
}

Result<void> StreamSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    header_ = ofr::write_header(info);
    offset_ = header_.size();
    next_ = info.slice_begin;
    if (wake_ < 0) return outside_error(messages::kNoEventfd);
    for (int tries = 0; tries < kMostAgain; ++tries) {
        Result<Line> line = connect(resumed_ ? Mode::kSendBack : Mode::kAnew);
        if (!line) return line.error();
        line_ = std::move(*line);
        if (resumed_) return {};  // what is kept comes back first
        Result<std::optional<Ready>> ready = hear_ready(&line_, {}, nullptr);
        if (!ready) return ready.error();
        if (!*ready) continue;
        start(**ready);
        return {};
    }
    return outside_error(address_.text + messages::kLineCutAtFirst);
}

Result<int32_t> StreamSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!resumed_) return 0;
    int32_t shown = 0;
    const auto count = [&](const pipeline::SliceView& slice) {
        const std::vector<uint8_t> bytes = encode(slice);
        entries_.push_back({slice.z, offset_});
        offset_ += bytes.size();
        return show(slice);
    };
    Result<std::optional<Ready>> ready = hear_ready(&line_, count, &shown);
    if (!ready) return ready.error();
    if (!*ready) return outside_error(address_.text + messages::kLineCutComingBack);
    // A front end that keeps no slices sends none back: they are made again and not sent.
    if (shown != 0 && info_.slice_begin + shown != (*ready)->next)
        return outside_error(address_.text + messages::kNotAllCameBack);
    start(**ready);
    return shown;
}

void StreamSink::start(const Ready& ready) {
    {
        const std::lock_guard lock(mutex_);
        take_ready(ready);
    }
    thread_ = std::thread([this] { run(); });
}

std::vector<uint8_t> StreamSink::encode(const pipeline::SliceView& slice) const {
    return ofr::encode_slice(slice);
}

bool StreamSink::wait(std::unique_lock<std::mutex>* lock, const std::function<bool()>& ready) {
    constexpr std::chrono::milliseconds kPoll(50);
    while (!changed_.wait_for(*lock, kPoll, ready)) {
        if (interrupt_ != nullptr && interrupt_->load()) return false;
    }
    return true;
}

Error StreamSink::interrupted(int32_t z) const {
    return {ErrorCode::kInterrupted, fmt::format(messages::kInterruptedNoRoom, address_.text, z)};
}

Result<void> StreamSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    if (bytes.empty())
        return internal_error(fmt::format(backends::messages::kSliceNotCompressed, z));
    entries_.push_back({z, offset_});
    offset_ += bytes.size();
    std::unique_lock lock(mutex_);
    const bool has_room = wait(&lock, [&] {
        return failed_ || queue_.empty() ||
               (queue_.size() < window_ && queued_bytes_ + bytes.size() <= kMostQueuedBytes);
    });
    if (failed_) return error_;
    if (!has_room) return interrupted(z);
    if (z < next_) return {};
    const bool wakes = push({z, false, frame(Kind::kSlice, bytes)});
    lock.unlock();
    if (wakes) (void)::eventfd_write(wake_, 1);
    return {};
}

/// Adds to the queue; returns whether the thread must be woken. The caller has the lock.
bool StreamSink::push(Item item) {
    const size_t bytes = item.message.size();
    const bool first = unsent_bytes_ == 0;
    const bool had_enough = has_enough();
    if (first) unsent_since_ = seconds_now();
    queue_.push_back(std::move(item));
    queued_bytes_ += bytes;
    unsent_bytes_ += bytes;
    return first || (has_enough() && !had_enough);
}

Result<void> StreamSink::finish(const pipeline::PrintTotals& totals) {
    if (!thread_.joinable()) return {};  // never began
    constexpr double kMomentSeconds = 2;
    std::unique_lock lock(mutex_);
    if (totals.complete && !failed_ && !done_) {
        const std::vector<uint8_t> index = ofr::write_index({entries_, totals}, offset_);
        push({info_.slice_end, true, frame(Kind::kDone, index)});
        (void)::eventfd_write(wake_, 1);
        if (!wait(&lock, [&] { return failed_ || done_; })) {
            failed_ = true;
            error_ = interrupted(queue_.front().z);
        }
    } else if (!totals.complete) {
        changed_.wait_for(lock, seconds(kMomentSeconds), [&] { return failed_ || queue_.empty(); });
    }
    quit_ = true;
    const bool reported = !totals.complete;  // the cause of the end is known already
    const Result<void> result = failed_ && !reported ? Result<void>(error_) : Result<void>();
    lock.unlock();
    (void)::eventfd_write(wake_, 1);
    thread_.join();
    if (line_.is_open() && out_.empty() && !line_.is_mid_send())
        line_.send_all(frame_stop(StopCode::kBye, messages::kSenderLeaves), kMomentSeconds);
    line_.close();
    return result;
}

void StreamSink::fail(Error error) {
    const std::lock_guard lock(mutex_);
    failed_ = true;
    error_ = std::move(error);
    changed_.notify_all();
}

void StreamSink::run() {
    for (;;) {
        {
            const std::lock_guard lock(mutex_);
            if (quit_ || failed_ || done_) return;
        }
        if (line_.is_open()) {
            serve();
        } else if (!reconnect()) {
            return;
        }
    }
}

/// Returns whether an item waits that the window has room for; the caller has the lock.
bool StreamSink::may_send() const {
    return sent_ < std::min<size_t>(queue_.size(), window_);
}

/// Returns whether what waits is worth being sent by itself; the caller has the lock.
bool StreamSink::has_enough() const {
    return queue_.size() - sent_ >= kEnoughSlices || unsent_bytes_ >= kEnoughBytes ||
           (!queue_.empty() && queue_.back().last);
}

/// Returns whether to send now; the caller has the lock.
bool StreamSink::should_send() const {
    return may_send() && (has_enough() || seconds_now() - unsent_since_ >= kLongestWaitSeconds);
}

/// One turn of the line: sends and hears what can be at once, else waits.
void StreamSink::serve() {
    constexpr int kTurnMs = 1000;
    int wait_ms = kTurnMs;
    bool more = !out_.empty();
    {
        const std::lock_guard lock(mutex_);
        more = more || should_send();
        if (!more && may_send()) wait_ms = static_cast<int>(std::ceil(1e3 * kLongestWaitSeconds));
    }
    std::array<pollfd, 2> polled{
        {{line_.fd(), static_cast<int16_t>(POLLIN | (more ? POLLOUT : 0)), 0}, {wake_, POLLIN, 0}}};
    ::poll(polled.data(), polled.size(), wait_ms);
    if ((polled[1].revents & POLLIN) != 0) {
        eventfd_t ignored = 0;
        (void)::eventfd_read(wake_, &ignored);
    }
    if ((polled[0].revents & (POLLIN | POLLERR | POLLHUP)) != 0 && !hear()) return line_.close();
    send_queued();
    if (!line_.is_open()) return;
    const double now = seconds_now();
    if (now - line_.heard() > kSilentSeconds) return line_.close();
    // Between whole messages only.
    if (now - alive_ > kAliveSeconds && out_.empty() && !line_.is_mid_send()) {
        alive_ = now;
        if (!line_.send_all(frame(Kind::kAlive, {}), 1)) line_.close();
    }
}

void StreamSink::send_queued() {
    for (;;) {
        if (out_.empty()) {
            const std::lock_guard lock(mutex_);
            if (!should_send()) return;
            do {
                const std::vector<uint8_t>& message = queue_[sent_++].message;
                out_.insert(out_.end(), message.begin(), message.end());
                unsent_bytes_ -= message.size();
            } while (may_send() && out_.size() < kEnoughBytes);
            unsent_since_ = seconds_now();
        }
        const int64_t n = line_.send_some(std::span<const uint8_t>(out_).subspan(out_begin_));
        if (n < 0) return line_.close();
        if (n == 0) return;
        alive_ = seconds_now();
        out_begin_ += static_cast<size_t>(n);
        if (out_begin_ < out_.size()) continue;
        out_.clear();
        out_begin_ = 0;
    }
}

/// Reads and handles what has arrived; returns whether the line is still there.
bool StreamSink::hear() {
    if (!line_.receive()) return false;
    Message message;
    for (;;) {
        Result<bool> got = line_.next(&message);
        if (!got) {
            fail(with_context(got.error(), address_.text + ": "));
            return false;
        }
        if (!*got) return line_.is_open();
        handle(message);
        const std::lock_guard lock(mutex_);
        if (failed_) return false;
    }
}

void StreamSink::handle(const Message& message) {
    if (message.kind == Kind::kAcknowledge) {
        const Result<int32_t> z = read_acknowledge(message.bytes);
        const std::lock_guard lock(mutex_);
        // Only what was sent can have been kept.
        const int32_t most = std::min(next_ + static_cast<int32_t>(sent_), info_.slice_end);
        if (z && *z >= next_ && *z < most) {
            again_ = 0;
            pop_to(*z + 1);
        }
    } else if (message.kind == Kind::kDone) {
        const std::lock_guard lock(mutex_);
        // It keeps all, also what its printer has no room for yet.
        done_ = !queue_.empty() && queue_.back().last && sent_ == queue_.size();
        changed_.notify_all();
    } else if (message.kind == Kind::kStop) {
        const Stop stop = read_stop(message.bytes);
        if (stop.code == StopCode::kAgain && ++again_ <= kMostAgain) return line_.close();
        fail(stopped(stop));
    }
}

/// Slices below `next` are kept; the caller has the lock.
void StreamSink::pop_to(int32_t next) {
    while (!queue_.empty() && !queue_.front().last && queue_.front().z < next) {
        const size_t bytes = queue_.front().message.size();
        queued_bytes_ -= bytes;
        if (sent_ > 0) {
            --sent_;
        } else {
            unsent_bytes_ -= bytes;
        }
        queue_.pop_front();
    }
    next_ = std::max(next_, next);
    changed_.notify_all();
}

/// Begins on a new line; the caller has the lock.
void StreamSink::take_ready(const Ready& ready) {
    sent_ = out_begin_ = 0;
    out_.clear();
    unsent_bytes_ = queued_bytes_;
    unsent_since_ = 0;
    window_ = std::clamp<uint32_t>(ready.window, 1, kMostWindow);
    alive_ = seconds_now();
    pop_to(ready.next);
    if (ready.complete != 0 && ready.next == info_.slice_end) done_ = true;
}

/// Looks for the receiver until it answers, refuses, or was away for too long.
bool StreamSink::reconnect() {
    const double lost = seconds_now();
    Error last = outside_error(address_.text + messages::kLineCutAfter);
    for (double pause = 0.05; seconds_now() - lost < kLostSeconds;
         pause = std::min(2 * pause, 2.0)) {
        {
            std::unique_lock lock(mutex_);
            if (changed_.wait_for(lock, seconds(pause), [&] { return quit_; })) return false;
        }
        Result<Line> line = connect(Mode::kGoOn);
        if (!line) {
            last = line.error();
            continue;
        }
        Result<std::optional<Ready>> ready = hear_ready(&*line, {}, nullptr);
        if (!ready) {
            fail(ready.error());
            return false;
        }
        if (!*ready) continue;
        const std::lock_guard lock(mutex_);
        if ((*ready)->next < next_) {
            failed_ = true;
            error_ = outside_error(
                fmt::format(messages::kSlicesLost, address_.text, (*ready)->next, next_ - 1));
            changed_.notify_all();
            return false;
        }
        line_ = std::move(*line);
        take_ready(**ready);
        return true;
    }
    fail(outside_error(fmt::format(messages::kNoOtherLine, last.text(), kLostSeconds)));
    return false;
}

}  // namespace openfab::stream
