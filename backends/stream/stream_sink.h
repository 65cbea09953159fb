// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Streams a print to a receiver over a line (docs/streaming.md). A thread of its own sends what
// commit puts into its queue, hears acknowledgements, and looks for the receiver again when the
// line is cut, so that the print goes on meanwhile. The queue holds what was not acknowledged: never
// more than the receiver's window, nor than kMostQueuedBytes where that is more than one slice.

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "backends/ofr/format.h"
#include "backends/stream/address.h"
#include "backends/stream/message.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::stream {

class StreamSink : public pipeline::SliceSink {
  public:
    static constexpr size_t kMostQueuedBytes = 32 << 20;

    /// Makes a sink; nothing is connected before begin. `tls`: null where the address has none. With
    /// `resumed` the receiver is asked for what it has kept of an earlier print of the same. Once
    /// `interrupt` is set, if there is one, it waits no longer for a receiver that takes nothing.
    StreamSink(Address address, std::string token, std::unique_ptr<TlsContext> tls, bool resumed,
               const std::atomic<bool>* interrupt);
    ~StreamSink() override;

    Result<void> begin(const pipeline::PrintInfo& info) override;
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override;
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    /// Waits while the queue is full.
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    /// Waits until the receiver has kept everything; after a print that ended early only for a
    /// moment.
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    /// Slices are sent when there are so many, or so many bytes, or the first one has waited for so long:
    /// sending wakes the thread, and then the receiver. A slab comes all at once.
    static constexpr size_t kEnoughSlices = 8;
    static constexpr size_t kEnoughBytes = 64 << 10;
    static constexpr double kLongestWaitSeconds = 0.002;

    struct Item {
        int32_t z = 0;
        bool last = false;
        std::vector<uint8_t> message;
    };

    /// Connects and asks for `mode`; the answer is still to be read.
    Result<Line> connect(Mode mode) const;
    /// Reads until the receiver is ready; `show` gets the slices that come back before. The
    /// outcome is empty where the line was cut.
    Result<std::optional<Ready>> hear_ready(
        Line* line, const std::function<bool(const pipeline::SliceView&)>& show,
        int32_t* shown) const;
    Error stopped(const Stop& stop) const;
    Error interrupted(int32_t z) const;
    bool push(Item item);
    void start(const Ready& ready);

    // The thread's.
    void run();
    void serve();
    bool may_send() const;
    bool has_enough() const;
    bool should_send() const;
    void send_queued();
    bool hear();
    void handle(const Message& message);
    bool reconnect();
    void fail(Error error);
    void take_ready(const Ready& ready);
    void pop_to(int32_t next);

    /// Waits for what `ready` says; returns false where the print is interrupted before.
    bool wait(std::unique_lock<std::mutex>* lock, const std::function<bool()>& ready);

    Address address_;
    std::string token_;
    std::unique_ptr<TlsContext> tls_;
    bool resumed_;
    const std::atomic<bool>* interrupt_;
    uint64_t sender_ = 0;
    pipeline::PrintInfo info_;
    std::vector<uint8_t> header_;
    Line line_;
    int32_t next_ = 0;  ///< slices below are kept by the receiver
    std::vector<ofr::IndexEntry> entries_;
    uint64_t offset_ = 0;  ///< in the .ofr file that the stream is
    std::thread thread_;
    int wake_ = -1;             ///< an eventfd: the queue has something new
    std::vector<uint8_t> out_;  ///< the thread's: items that are being sent
    size_t out_begin_ = 0;

    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<Item> queue_;  ///< not acknowledged, in order
    size_t queued_bytes_ = 0;
    size_t sent_ = 0;          ///< of the queue's items, on this line, or in out_
    size_t unsent_bytes_ = 0;  ///< of the others
    double unsent_since_ = 0;
    uint32_t window_ = 1;
    double alive_ = 0;   ///< when something was sent last
    int again_ = 0;      ///< how often the same slice came damaged
    bool done_ = false;  ///< all of it is kept
    bool quit_ = false;
    bool failed_ = false;
    Error error_;
};

}  // namespace openfab::stream
