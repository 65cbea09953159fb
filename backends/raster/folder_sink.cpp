// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/folder_sink.h"

#include "backends/raster/grey_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <system_error>

#include "backends/common/messages.h"
#include "backends/common/resume_check.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/messages.h"
#include "backends/raster/png_slice.h"
#include "base/check.h"
#include "base/near_miss.h"
#include "base/units.h"

namespace openfab::raster {

namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kHandoff = "HANDOFF.txt";

/// Reads a file; empty where it does not exist, an error where it cannot be read.
Result<std::vector<uint8_t>> read_bytes(const std::filesystem::path& file) {
    std::error_code status;
    if (!std::filesystem::exists(file, status)) return std::vector<uint8_t>();
    std::ifstream in(file, std::ios::binary);
    std::vector<uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
    if (!in || in.bad()) return outside_error(fmt::format(messages::kCannotRead, file.string()));
    return bytes;
}

}  // namespace

bool is_folder_file(const std::string& name) {
    return is_slice_name(name) || name.starts_with(kManifest) || name.starts_with(kHandoff);
}

Result<std::unique_ptr<pipeline::SliceSink>> FolderSink::open(const std::filesystem::path& folder,
                                                              FolderOptions options,
                                                              bool reopened) {
    std::error_code status;
    if (std::filesystem::exists(folder, status) && !std::filesystem::is_directory(folder, status)) {
        return user_error(fmt::format(messages::kOutputIsFile, folder.string()));
    }
    std::filesystem::create_directories(folder, status);
    if (status) {
        return outside_error(
            fmt::format(messages::kCannotCreateFolder, folder.string(), status.message()));
    }
    Result<backends::OutputFolder> opened = backends::OutputFolder::open(folder);
    if (!opened) return opened.error();
    std::unique_ptr<FolderSink> sink(new FolderSink(std::move(*opened), std::move(options)));
    const Result<std::vector<std::string>> files = sink->files();
    if (!files) return files.error();
    sink->resumed_ = reopened;
    sink->earlier_ = reopened && !files->empty();
    return std::unique_ptr<pipeline::SliceSink>(std::move(sink));
}

Result<std::unique_ptr<pipeline::SliceSink>> FolderSink::create(const std::filesystem::path& folder,
                                                                FolderOptions options) {
    return open(folder, std::move(options), false);
}

Result<std::unique_ptr<pipeline::SliceSink>> FolderSink::reopen(const std::filesystem::path& folder,
                                                                FolderOptions options) {
    return open(folder, std::move(options), true);
}

Result<std::vector<std::string>> FolderSink::files() const {
    std::vector<std::string> ours;
    std::error_code status;
    for (std::filesystem::directory_iterator entry(folder_.path(), status), end;
         !status && entry != end; entry.increment(status)) {
        const std::string name = entry->path().filename().string();
        if (!is_folder_file(name)) {
            return user_error(fmt::format(messages::kNotOfPrint, folder_.path().string(), name));
        }
        ours.push_back(name);
    }
    if (status) {
        return outside_error(
            fmt::format(messages::kCannotReadFolder, folder_.path().string(), status.message()));
    }
    return ours;
}

Result<void> FolderSink::clear() {
    Result<std::vector<std::string>> names = files();
    if (!names) return names.error();
    std::set<std::string> planned;
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        for (size_t i = 0; i < files_a_slice(info_, options_); ++i)
            planned.insert(slice_file_name(z, i, info_, options_));
    }
    // The notes first: what they say is no longer true.
    std::partition(names->begin(), names->end(),
                   [](const std::string& name) { return !is_slice_name(name); });
    for (const std::string& name : *names) {
        const bool again = planned.contains(name);
        const Result<void> gone = again ? folder_.set_aside(name) : folder_.remove(name);
        if (!gone) return gone;
        if (again) set_aside_.insert(name);
    }
    return {};
}

Result<void> FolderSink::write_notes(const pipeline::PrintTotals& totals) {
    const auto write = [this](const char* name, const std::string& text) {
        return folder_.write(name, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    };
    Result<void> written = write(kManifest, manifest_json(info_, totals, written_, options_));
    return written ? write(kHandoff, handoff_text(info_, totals, written_, options_)) : written;
}

Result<void> FolderSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    if (is_grey(options_.format) && grey_material(info, options_) < 0) {
        std::vector<std::string> names;
        for (const pipeline::SliceMaterial& material : info.materials)
            names.push_back(material.name);
        return user_error(fmt::format(messages::kNoGreyMaterial, options_.grey_material,
                                      suggest(options_.grey_material, names)));
    }
    if (!earlier_) {
        if (Result<void> cleared = resumed_ ? Result<void>() : clear(); !cleared) return cleared;
        return write_notes({});  // a crash leaves it incomplete
    }
    const Result<std::vector<uint8_t>> manifest = read_bytes(folder_.path() / kManifest);
    if (!manifest) return manifest.error();
    if (manifest->empty()) {
        const Result<std::vector<std::string>> found = files();
        if (!found) return found.error();
        const bool slices = std::any_of(found->begin(), found->end(), is_slice_name);
        // The print was killed right at its start: nothing is lost by starting over.
        if (!slices) return {};
        return backends::resume_refused(folder_.path().string(),
                                        fmt::format(messages::kSlicesWithoutManifest, kManifest));
    }
    const std::string why =
        manifest_difference({manifest->begin(), manifest->end()}, info_, options_);
    if (!why.empty()) return backends::resume_refused(folder_.path().string(), why);
    if (options_.format == SliceFormat::kRgba && shares_a_color(info_)) {
        return backends::resume_refused(folder_.path().string(), messages::kMaterialsAlike);
    }
    return {};
}

Result<int32_t> FolderSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!earlier_) return 0;
    const size_t row_bytes = backends::packed_row_bytes(info_.size.x, info_.bits);
    std::set<std::string> kept{kManifest, kHandoff};
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        std::vector<std::string> of_slice;
        std::vector<uint8_t> bytes;
        for (size_t i = 0; i < files_a_slice(info_, options_); ++i) {
            of_slice.push_back(slice_file_name(z, i, info_, options_));
            const Result<std::vector<uint8_t>> file = read_bytes(folder_.path() / of_slice.back());
            if (!file) return file.error();
            bytes.insert(bytes.end(), file->begin(), file->end());
        }
        const std::vector<uint8_t> rows = decode_slice(bytes, info_, options_);
        if (rows.empty()) break;
        kept.insert(of_slice.begin(), of_slice.end());
        ++written_;
        if (!show({z, rows.data(), row_bytes, info_.size.x, info_.size.y})) {
            return Error{
                ErrorCode::kInterrupted,
                fmt::format(backends::messages::kInterruptedReading, folder_.path().string())};
        }
    }
    const bool complete = written_ == info_.slice_end - info_.slice_begin;
    const Result<std::vector<std::string>> found = files();
    if (!found) return found.error();
    for (const std::string& name : *found) {
        if (kept.contains(name)) continue;
        if (Result<void> removed = folder_.remove(name); !removed) return removed.error();
    }
    earlier_ = false;
    // The manifest of a complete print must not stay once slices of it are gone.
    if (!complete) {
        if (Result<void> noted = write_notes({}); !noted) return noted.error();
    }
    return written_;
}

std::vector<uint8_t> FolderSink::encode(const pipeline::SliceView& slice) const {
    return encode_slice(slice, info_, options_);
}

Error FolderSink::with_resume_state(const Error& error, size_t slice_bytes) const {
    const double left = info_.slice_end - info_.slice_begin - written_;
    return {error.code,
            fmt::format(backends::messages::kWholeSlicesBefore, error.text(), written_) +
                fmt::format(
                    backends::messages::kRestTakes,
                    format_bytes(static_cast<int64_t>(left * static_cast<double>(slice_bytes))))};
}

Result<void> FolderSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    if (bytes.empty())
        return internal_error(fmt::format(backends::messages::kSliceNotCompressed, z));
    OPENFAB_CHECK(z >= 0 && z < info_.size.z);
    const size_t files = files_a_slice(info_, options_);
    const size_t file_bytes = bytes.size() / files;
    for (size_t i = 0; i < files; ++i) {
        const std::string name = slice_file_name(z, i, info_, options_);
        const Result<void> written =
            folder_.write(name, std::span(bytes).subspan(i * file_bytes, file_bytes));
        set_aside_.erase(name);
        if (written) continue;
        broken_ = true;
        return with_resume_state(written.error(), bytes.size());
    }
    ++written_;
    return {};
}

Result<void> FolderSink::finish(const pipeline::PrintTotals& totals) {
    if (earlier_) return {};  // refused or interrupted before anything was changed
    pipeline::PrintTotals honest = totals;
    honest.complete = totals.complete && !broken_;
    // What an earlier print had, and this one did not come to.
    Result<void> done;
    for (const std::string& name : set_aside_) {
        if (Result<void> removed = folder_.remove(name + ".part"); done) done = removed;
    }
    set_aside_.clear();
    // The notes after the slices: a manifest that says that all are there must be true, whenever
    // the power fails. Those of an interrupted print that were kept are synced with the others.
    if (done) done = folder_.sync();
    if (done || broken_) done = write_notes(honest);
    if (done) done = folder_.sync();
    // An earlier error has been reported already, and is the cause of this one, too.
    return broken_ ? Result<void>() : done;
}

}  // namespace openfab::raster
