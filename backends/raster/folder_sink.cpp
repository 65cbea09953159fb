// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/folder_sink.h"

#include "backends/raster/grey_slice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <system_error>

#include "backends/common/messages.h"
#include "backends/common/resume_check.h"
#include "backends/common/tee_sink.h"
#include "backends/raster/messages.h"
#include "backends/raster/png_slice.h"
#include "base/check.h"
#include "base/input_file.h"
#include "base/near_miss.h"
#include "base/units.h"

namespace openfab::raster {

namespace {

constexpr const char* kManifest = "manifest.json";
constexpr const char* kHandoff = "HANDOFF.txt";

/// Reads a file; empty where it does not exist, an error where it cannot be read.
Result<std::string> read_bytes(const std::filesystem::path& file) {
    std::error_code status;
    const std::filesystem::file_status there = std::filesystem::status(file, status);
    if (!std::filesystem::exists(there)) return std::string();
    if (!std::filesystem::is_regular_file(there))
        return user_error(fmt::format(
            messages::kNotAFile, file.string(),
            std::filesystem::is_directory(there) ? messages::kIsAFolder : messages::kIsNoFile));
    const Result<InputFile> opened = InputFile::open(file);
    if (opened) {
        if (Result<std::string> bytes = opened->read_all(opened->bytes()); bytes) return bytes;
    }
    return outside_error(fmt::format(messages::kCannotRead, file.string()));
}

}  // namespace

bool is_folder_file(const std::string& name) {
    return is_slice_name(name) || name.starts_with(kManifest) || name.starts_with(kHandoff) ||
           name.starts_with(kDigestFile);
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

Result<void> FolderSink::write_notes(const pipeline::PrintTotals& totals, bool end) {
    std::string sums;
    const auto write = [&](const char* name, const std::string& text) {
        if (end) sums += digest_line(name, sha256(text));
        return folder_.write(name, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    };
    const std::span<const Sha256Digest> digests(digests_);
    Result<void> written = write(kManifest, manifest_json(info_, totals, written_, options_,
                                                          digests.first(end ? digests.size() : 0)));
    if (written) written = write(kHandoff, handoff_text(info_, totals, written_, options_));
    if (!written || !end) return written;
    const size_t files = files_a_slice(info_, options_);
    for (size_t i = 0; i < digests_.size(); ++i) {
        const auto z = info_.slice_begin + static_cast<int32_t>(i / files);
        sums += digest_line(slice_file_name(z, i % files, info_, options_), digests_[i]);
    }
    end = false;
    if (written = write(kDigestFile, sums); !written) return written;
    list_.reset();
    return folder_.remove(kDigestsSoFar);
}

Result<void> FolderSink::begin_digests() {
    std::string text = digests_head(manifest_json(info_, {}, 0, options_));
    const size_t files = files_a_slice(info_, options_);
    for (size_t i = 0; i < digests_.size(); ++i) {
        const auto z = info_.slice_begin + static_cast<int32_t>(i / files);
        const std::string name = slice_file_name(z, i % files, info_, options_);
        text += digest_line(name, seal_of(identity_, name, digests_[i]));
    }
    if (Result<void> gone = folder_.remove(kDigestFile); !gone) return gone;
    const Result<void> written =
        folder_.write(kDigestsSoFar, {reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    if (!written) return written;
    Result<backends::GrowingFile> list = folder_.grow(kDigestsSoFar);
    if (!list) return list.error();
    list_.emplace(std::move(*list));
    return {};
}

Result<void> FolderSink::read_digests(const std::string& manifest) {
    const Result<std::string> list = read_bytes(folder_.path() / kDigestsSoFar);
    if (!list) return list.error();
    earlier_seals_ = parse_digests(*list, digests_head(manifest_json(info_, {}, 0, options_)));
    // A run that came to its end, complete or not, has left no list of a running one.
    if (earlier_seals_.empty()) {
        earlier_seals_ = manifest_seals(manifest);
        if (manifest_is_complete(manifest)) earlier_hash_ = manifest_hash(manifest);
    }
    return {};
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
    identity_ = *print_identity(manifest_json(info_, {}, 0, options_));
    if (!earlier_) {
        if (Result<void> cleared = resumed_ ? Result<void>() : clear(); !cleared) return cleared;
        // A crash leaves it incomplete.
        if (Result<void> noted = write_notes({}, false); !noted) return noted;
        return begin_digests();
    }
    const Result<std::string> manifest = read_bytes(folder_.path() / kManifest);
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
    const std::string why = manifest_difference(*manifest, info_, options_);
    if (!why.empty()) return backends::resume_refused(folder_.path().string(), why);
    if (options_.format == SliceFormat::kRgba && shares_a_color(info_)) {
        return backends::resume_refused(folder_.path().string(), messages::kMaterialsAlike);
    }
    return read_digests(*manifest);
}

Result<bool> FolderSink::read_slice(int32_t z, KeptSlice* slice) const {
    for (size_t i = 0; i < files_a_slice(info_, options_); ++i) {
        const std::string name = slice_file_name(z, i, info_, options_);
        const auto recorded = earlier_seals_.find(name);
        if (recorded == earlier_seals_.end()) return false;
        const Result<std::string> file = read_bytes(folder_.path() / name);
        if (!file) return file.error();
        const Sha256Digest digest = sha256(*file);
        if (seal_of(identity_, name, digest) != recorded->second) return false;
        slice->names.push_back(name);
        slice->digests.push_back(digest);
        slice->bytes.insert(slice->bytes.end(), file->begin(), file->end());
    }
    return true;
}

Result<int32_t> FolderSink::keep_slices(
    const std::function<Result<bool>(int32_t z, const std::vector<uint8_t>& bytes)>& take) {
    std::set<std::string> kept{kManifest, kHandoff, kDigestsSoFar};
    for (int32_t z = info_.slice_begin; z < info_.slice_end; ++z) {
        KeptSlice slice;
        Result<bool> whole = read_slice(z, &slice);
        if (whole && *whole) whole = take(z, slice.bytes);
        if (!whole) return whole.error();
        if (!*whole) break;
        kept.insert(slice.names.begin(), slice.names.end());
        digests_.insert(digests_.end(), slice.digests.begin(), slice.digests.end());
        ++written_;
    }
    const Result<std::vector<std::string>> found = files();
    if (!found) return found.error();
    // First the list of what is kept, as the manifest of an earlier run, which may have one, is replaced.
    if (Result<void> begun = begin_digests(); !begun) return begun.error();
    // The manifest of a complete print must not stay once slices of it are gone.
    all_kept_ = written_ == info_.slice_end - info_.slice_begin;
    if (!all_kept_) {
        if (Result<void> noted = write_notes({}, false); !noted) return noted.error();
    }
    for (const std::string& name : *found) {
        if (kept.contains(name)) continue;
        if (Result<void> removed = folder_.remove(name); !removed) return removed.error();
    }
    earlier_ = false;
    return written_;
}

Result<int32_t> FolderSink::resume(const std::function<bool(const pipeline::SliceView&)>& show) {
    if (!earlier_) return 0;
    const size_t row_bytes = backends::packed_row_bytes(info_.size.x, info_.bits);
    return keep_slices([&](int32_t z, const std::vector<uint8_t>& bytes) -> Result<bool> {
        const std::vector<uint8_t> rows = decode_slice(bytes, info_, options_);
        if (rows.empty()) return false;
        if (show({z, rows.data(), row_bytes, info_.size.x, info_.size.y})) return true;
        return Error{ErrorCode::kInterrupted,
                     fmt::format(backends::messages::kInterruptedReading, folder_.path().string())};
    });
}

Result<int32_t> FolderSink::keep() {
    if (!earlier_) return 0;
    return keep_slices([](int32_t, const std::vector<uint8_t>&) -> Result<bool> { return true; });
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
    std::string lines;
    Result<void> written;
    for (size_t i = 0; i < files && written; ++i) {
        const std::string name = slice_file_name(z, i, info_, options_);
        const std::span<const uint8_t> file = std::span(bytes).subspan(i * file_bytes, file_bytes);
        written = folder_.write(name, file);
        set_aside_.erase(name);
        digests_.push_back(sha256(file));
        lines += digest_line(name, seal_of(identity_, name, digests_.back()));
    }
    if (written) written = list_->add(lines);
    if (!written) {
        broken_ = true;
        digests_.resize(static_cast<size_t>(written_) * files);
        return with_resume_state(written.error(), bytes.size());
    }
    ++written_;
    return {};
}

Result<void> FolderSink::check_hash(const pipeline::PrintTotals& totals) {
    const std::string hash = fmt::format("{:016x}", totals.hash);
    if (!all_kept_ || !totals.complete || earlier_hash_.empty() || earlier_hash_ == hash) return {};
    digests_.clear();
    written_ = 0;
    if (Result<void> noted = write_notes({}, true); !noted) return noted;
    return user_error(
        fmt::format(messages::kHashOfOther, folder_.path().string(), hash, earlier_hash_));
}

Result<void> FolderSink::finish(const pipeline::PrintTotals& totals) {
    if (earlier_) return {};  // refused or interrupted before anything was changed
    if (Result<void> checked = check_hash(totals); !checked) return checked;
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
    if (done || broken_) done = write_notes(honest, true);
    if (done) done = folder_.sync();
    // An earlier error has been reported already, and is the cause of this one, too.
    return broken_ ? Result<void>() : done;
}

}  // namespace openfab::raster
