// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/common/package.h"

#include <fmt/format.h>
#include <minizip/zip.h>

#include <algorithm>

#include "backends/common/messages.h"
#include "base/check.h"

namespace openfab::backends {

namespace {

// Midnight of the first day that ZIP knows, 1 January 1980.
constexpr uLong kNoTime = 1 << 21 | 1 << 16;
// Larger sizes need ZIP64; leaves room for headers.
constexpr int64_t kLarge = 0xfff00000;

}  // namespace

struct Package::Callbacks {
    static voidpf open(voidpf opaque, const void*, int) { return opaque; }
    static uLong read(voidpf, voidpf, void*, uLong) { return 0; }
    static uLong write(voidpf opaque, voidpf, const void* data, uLong size) {
        auto* s = static_cast<Stream*>(opaque);
        std::span<const uint8_t> bytes(static_cast<const uint8_t*>(data), size);
        Result<void> done;
        if (s->at < s->file->bytes_written()) {
            const auto before = static_cast<size_t>(
                std::min<int64_t>(static_cast<int64_t>(size), s->file->bytes_written() - s->at));
            done = s->file->overwrite(s->at, bytes.first(before));
            s->at += static_cast<int64_t>(before);
            bytes = bytes.subspan(before);
        }
        if (done && !bytes.empty()) done = s->file->write(bytes);
        if (!done) {
            if (!s->error) s->error = done.error();
            return 0;
        }
        s->at += static_cast<int64_t>(bytes.size());
        return size;
    }
    static ZPOS64_T tell(voidpf opaque, voidpf) {
        return static_cast<ZPOS64_T>(static_cast<Stream*>(opaque)->at);
    }
    static long seek(voidpf opaque, voidpf, ZPOS64_T offset, int origin) {
        auto* s = static_cast<Stream*>(opaque);
        const int64_t from = origin == ZLIB_FILEFUNC_SEEK_CUR   ? s->at
                             : origin == ZLIB_FILEFUNC_SEEK_END ? s->file->bytes_written()
                                                                : 0;
        s->at = from + static_cast<int64_t>(offset);
        return 0;
    }
    static int close(voidpf, voidpf) { return 0; }
    static int error(voidpf opaque, voidpf) { return static_cast<Stream*>(opaque)->error ? 1 : 0; }
};

Result<std::unique_ptr<Package>> Package::create(OutputFile* file) {
    std::unique_ptr<Package> package(new Package());
    package->stream_->file = file;
    zlib_filefunc64_def functions{&Callbacks::open,  &Callbacks::read,      &Callbacks::write,
                                  &Callbacks::tell,  &Callbacks::seek,      &Callbacks::close,
                                  &Callbacks::error, package->stream_.get()};
    package->zip_ = zipOpen2_64("", APPEND_STATUS_CREATE, nullptr, &functions);
    if (package->zip_ == nullptr) return outside_error(messages::kOutOfMemory);
    return package;
}

Package::~Package() {
    // Frees minizip's state; the file is not a valid package then, and is removed.
    if (zip_ != nullptr) zipClose(zip_, nullptr);
}

Result<void> Package::checked(int status, const char* what) {
    if (stream_->error) return *stream_->error;
    if (status == ZIP_OK) return {};
    return internal_error(fmt::format(messages::kPackageFailed, what, status));
}

Result<void> Package::open(const std::string& name, bool packed, bool large, bool deflated) {
    zip_fileinfo info{};
    info.dosDate = kNoTime;
    return checked(zipOpenNewFileInZip2_64(zip_, name.c_str(), &info, nullptr, 0, nullptr, 0,
                                           nullptr, deflated ? Z_DEFLATED : 0,
                                           Z_DEFAULT_COMPRESSION, packed ? 1 : 0, large ? 1 : 0),
                   messages::kAddingTo);
}

Result<void> Package::add(const std::string& name, std::string_view text) {
    Result<void> done = open(name, false, false);
    if (done) {
        done = checked(zipWriteInFileInZip(zip_, text.data(), static_cast<unsigned>(text.size())),
                       messages::kWritingTo);
    }
    return done ? checked(zipCloseFileInZip(zip_), messages::kAddingTo) : done;
}

Result<void> Package::begin(const std::string& name, int64_t bytes) {
    // Readers refuse large entries that unpack to many times their size, as an empty volume does.
    constexpr int64_t kMostDeflated = 16 << 20;
    return open(name, false, bytes >= kLarge, bytes <= kMostDeflated);
}

Result<void> Package::end() {
    return checked(zipCloseFileInZip(zip_), messages::kAddingTo);
}

Result<void> Package::begin_packed(const std::string& name, int64_t most_bytes) {
    return open(name, true, most_bytes >= kLarge);
}

Result<void> Package::write_packed(std::span<const uint8_t> bytes) {
    return checked(zipWriteInFileInZip(zip_, bytes.data(), static_cast<unsigned>(bytes.size())),
                   messages::kWritingTo);
}

Result<void> Package::end_packed(const TextSum& sum) {
    return checked(
        zipCloseFileInZipRaw64(zip_, static_cast<ZPOS64_T>(sum.bytes), static_cast<uLong>(sum.crc)),
        messages::kAddingTo);
}

Result<void> Package::close() {
    OPENFAB_CHECK(zip_ != nullptr);
    return checked(zipClose(std::exchange(zip_, nullptr), nullptr), "closing");
}

}  // namespace openfab::backends
