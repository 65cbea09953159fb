// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/ofr/ofr_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "backends/common/messages.h"
#include "backends/common/resume_check.h"
#include "backends/ofr/messages.h"
#include "backends/ofr/slice_codec.h"
#include "base/check.h"
#include "base/units.h"

namespace openfab::ofr {

Result<std::unique_ptr<pipeline::SliceSink>> OfrSink::create(const std::string& path) {
    Result<backends::OutputFile> file = backends::OutputFile::create(path);
    if (!file) return file.error();
    return std::unique_ptr<pipeline::SliceSink>(new OfrSink(std::move(*file), State::kWriting));
}

Result<std::unique_ptr<pipeline::SliceSink>> OfrSink::reopen(const std::string& path) {
    Result<backends::OutputFile> file = backends::OutputFile::reopen(path);
    if (!file) return file.error();
    return std::unique_ptr<pipeline::SliceSink>(new OfrSink(std::move(*file), State::kReading));
}

Error OfrSink::with_resume_state(const Error& error) const {
    std::string message =
        fmt::format(backends::messages::kWholeSlicesBefore, error.text(), entries_.size());
    const auto left = static_cast<double>(info_.slice_end - info_.slice_begin) -
                      static_cast<double>(entries_.size());
    if (!entries_.empty() && left > 0) {
        const double bytes = static_cast<double>(file_.bytes_written()) /
                             static_cast<double>(entries_.size()) * left;
        message +=
            fmt::format(backends::messages::kRestTakes, format_bytes(static_cast<int64_t>(bytes)));
    }
    return {error.code, std::move(message)};
}

Result<void> OfrSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    const std::vector<uint8_t> header = write_header(info);
    if (state_ == State::kReading) {
        std::vector<uint8_t> there(header.size());
        std::ifstream in(file_.name(), std::ios::binary);
        in.read(reinterpret_cast<char*>(there.data()), static_cast<std::streamsize>(there.size()));
        there.resize(static_cast<size_t>(in.gcount()));
        // The print was killed right at its start: nothing is lost by starting over.
        const bool begun =
            there.size() < header.size() && std::equal(there.begin(), there.end(), header.begin());
        if (!begun) {
            Result<std::unique_ptr<OfrReader>> reader = OfrReader::open(file_.name());
            if (!reader) return reader.error();
            const std::string why = backends::first_difference((*reader)->info(), info);
            if (!why.empty()) return backends::resume_refused(file_.name(), why);
            earlier_ = std::move(*reader);
            return {};
        }
        if (Result<void> emptied = file_.continue_at(0); !emptied) return emptied;
        state_ = State::kWriting;
    }
    return file_.write(header);
}

Result<int32_t> OfrSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (earlier_ == nullptr) return 0;
    const std::unique_ptr<OfrReader> reader = std::move(earlier_);
    Result<bool> more = true;
    while ((more = reader->next()) && *more) {
        if (!show(reader->slice()))
            return Error{ErrorCode::kInterrupted,
                         fmt::format(backends::messages::kInterruptedReading, file_.name())};
    }
    if (!more && reader->disk_failed())
        return outside_error(fmt::format(messages::kCannotReadUnchanged, file_.name()));
    entries_ = reader->entries();
    if (more) {
        state_ = State::kComplete;
        return reader->whole_slices();
    }
    const Result<void> cut = file_.continue_at(static_cast<int64_t>(reader->slices_end()));
    if (!cut) return cut.error();
    state_ = State::kWriting;
    return reader->whole_slices();
}

std::vector<uint8_t> OfrSink::encode(const pipeline::SliceView& slice) const {
    return encode_slice(slice);
}

Result<void> OfrSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    if (bytes.empty())
        return internal_error(fmt::format(backends::messages::kSliceNotCompressed, z));
    OPENFAB_CHECK(entries_.empty() || entries_.back().z + 1 == z);
    const int64_t offset = file_.bytes_written();
    if (Result<void> written = file_.write(bytes); !written) {
        broken_ = true;
        file_.cut_back_to(offset);
        return with_resume_state(written.error());
    }
    entries_.push_back({z, static_cast<uint64_t>(offset)});
    return {};
}

Result<void> OfrSink::finish(const pipeline::PrintTotals& totals) {
    // Without an index the file says itself that it is not complete.
    if (totals.complete && !broken_ && state_ == State::kWriting) {
        const int64_t offset = file_.bytes_written();
        const std::vector<uint8_t> index =
            write_index({entries_, totals}, static_cast<uint64_t>(offset));
        if (Result<void> written = file_.write(index); !written) {
            file_.cut_back_to(offset);
            return with_resume_state(written.error());
        }
    }
    Result<void> closed = file_.close();
    // An earlier error has been reported already and caused this one, too.
    return broken_ ? Result<void>() : closed;
}

}  // namespace openfab::ofr
