// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/part_file.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "backends/common/messages.h"
#include "base/replace_file.h"

namespace openfab::backends {

namespace {

constexpr size_t kBuffer = 1 << 18;

}  // namespace

PartFile::PartFile(OutputFile file, std::filesystem::path path)
    : file_(std::move(file)), path_(std::move(path)), listed_([this] { return temporary_path(); }) {
    waiting_.reserve(kBuffer);
}

PartFile::~PartFile() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove(temporary_path(), ignored);
}

Result<std::unique_ptr<PartFile>> PartFile::create(const std::filesystem::path& path) {
    if (Result<void> file = check_replaceable(path); !file) return file.error();
    Result<OutputFile> file = OutputFile::create(path.string() + ".part");
    if (!file) return file.error();
    // Libraries may write it by its name: what was left of an earlier one goes now.
    if (Result<void> emptied = file->write({}); !emptied) return emptied.error();
    return std::unique_ptr<PartFile>(new PartFile(std::move(*file), path));
}

Result<void> PartFile::write(std::span<const uint8_t> bytes) {
    if (waiting_.size() + bytes.size() > kBuffer) {
        if (Result<OutputFile*> file = flushed(); !file) return file.error();
        if (bytes.size() > kBuffer) return file_.write(bytes);
    }
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    return {};
}

Result<OutputFile*> PartFile::flushed() {
    Result<void> written = file_.write(waiting_);
    waiting_.clear();
    if (!written) return written.error();
    return &file_;
}

Result<void> PartFile::sync() {
    if (Result<OutputFile*> file = flushed(); !file) return file.error();
    return file_.sync();
}

Result<void> PartFile::keep() {
    if (Result<void> synced = sync(); !synced) return synced;
    // Renamed before the lock is released, so that no other process truncates it in between.
    std::error_code code;
    std::filesystem::rename(temporary_path(), path_, code);
    if (code)
        return outside_error(
            fmt::format(messages::kCannotCreatePart, path_.string(), code.message()));
    kept_ = true;
    return file_.close(false);
}

}  // namespace openfab::backends
