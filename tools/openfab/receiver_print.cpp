// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The print that a receiver takes: its output, what it has of it, its slices and its index.

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "backends/common/tee_sink.h"
#include "backends/ofr/format.h"
#include "backends/ofr/slice_codec.h"
#include "base/clock.h"
#include "base/say.h"
#include "base/text.h"
#include "runtime/pipeline/print_hash.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/receiver.h"

namespace openfab::tools {

namespace {

using stream::Kind;
using stream::Mode;
using stream::StopCode;

/// An error that ends the print, as against one of a client, which ends its line.
bool is_ours(const Error& error) {
    return error.code == ErrorCode::kOutside || error.code == ErrorCode::kInternal;
}

}  // namespace

size_t Receiver::slice_bytes(const pipeline::PrintInfo& info) {
    return backends::packed_row_bytes(info.size.x, info.bits) * static_cast<size_t>(info.size.y);
}

int64_t Receiver::most_bytes(const pipeline::PrintInfo& info) {
    constexpr int64_t kProgram = 32 << 20;
    constexpr int64_t kPlace = 64;
    const auto rows = static_cast<int64_t>(slice_bytes(info));
    const auto framed = static_cast<int64_t>(ofr::most_frame_bytes(slice_bytes(info)));
    return kProgram + rows + 3 * framed + kPlace * info.size.z;
}

void Receiver::close_sink() {
    kept_.reset();
    if (sink_ != nullptr) (void)sink_->finish({});
    sink_.reset();
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
    Result<std::unique_ptr<pipeline::SliceSink>> sink =
        open_sink_(info, open.mode != Mode::kAnew, client->from);
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
        stop(client, StopCode::kDisk, messages::kCannotWriteOutput);
        return error;
    }
    // Who sends has no business with what this end's files are called.
    tell("refused", client->from,
         fmt::format(messages::kPrintRefused, client->from, printable(error.text())));
    stop(client, StopCode::kOtherPrint, messages::kHoldsAnotherPrint);
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
    tell("print", client->from,
         fmt::format(messages::kPrintFromSlice, printable(info_.title),
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
    if (Client* const client = sender()) stop(client, StopCode::kDisk, messages::kOutputDeleted);
    return outside_error(messages::kOutputDeletedMeanwhile);
}

int32_t Receiver::window() const {
    constexpr auto kMost = static_cast<int32_t>(stream::kMostWindow);
    return options_.layer_seconds > 0 ? std::clamp(options_.buffer, 1, kMost) : kMost;
}

Result<void> Receiver::take_slice(Client* client, std::vector<uint8_t> bytes) {
    const std::span<const uint8_t> all(bytes);
    const auto damaged = [&](const std::string& why) {
        ++checksum_errors_;
        say(fmt::format(messages::kAskedForAgain, next_, why));
        stop(client, StopCode::kAgain, fmt::format(messages::kSliceDamaged, next_));
        return Result<void>();
    };
    if (bytes.size() < ofr::kSliceHeadBytes) return damaged(messages::kTooShort);
    const Result<ofr::SliceHead> head = ofr::read_slice_head(all.first(ofr::kSliceHeadBytes));
    if (!head) return damaged(head.error().text());
    if (head->z != next_ || next_ == info_.slice_end) {
        ++order_errors_;
        say(fmt::format(messages::kSliceOutOfOrder, head->z, next_));
        stop(client, StopCode::kAgain, fmt::format(messages::kSliceWasNext, next_));
        return {};
    }
    if (head->frame_bytes != bytes.size() - ofr::kSliceHeadBytes)
        return damaged(messages::kLengthWrong);
    const Result<void> decoded = ofr::decode_frame(*head, all.subspan(ofr::kSliceHeadBytes), rows_);
    if (!decoded) return damaged(decoded.error().text());
    const auto counts = ofr::count_codes(rows_, info_.bits);
    if (std::any_of(counts.begin() + 1 + static_cast<std::ptrdiff_t>(info_.materials.size()),
                    counts.end(), [](int64_t count) { return count > 0; })) {
        return damaged(fmt::format(messages::kCodesBeyondMaterials, info_.materials.size()));
    }
    const pipeline::SliceView slice{next_, rows_.data(),
                                    backends::packed_row_bytes(info_.size.x, info_.bits),
                                    info_.size.x, info_.size.y};
    const Result<void> kept =
        sink_->commit(next_, options_.keeps_frames ? std::move(bytes) : sink_->encode(slice));
    if (!kept) {
        stop(client, StopCode::kDisk, messages::kCannotWriteOutput);
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
        stop(client, StopCode::kProtocol, messages::kIndexDoesNotFit);
        return {};
    }
    if (!complete_) {
        index->totals.complete = true;
        const Result<void> finished = sink_->finish(index->totals);
        sink_.reset();
        is_unfinished_ = false;
        if (!finished) {
            stop(client, StopCode::kDisk, messages::kCannotWriteOutput);
            return finished;
        }
        complete_ = true;
        complete_at_ = seconds_now();
        if (options_.log != nullptr) {
            options_.log->add("complete", client->from, info_.title, next_,
                              fmt::format("hash {:016x}", hash_));
        }
    }
    send(client, stream::frame(Kind::kDone, {}));
    return {};
}

}  // namespace openfab::tools
