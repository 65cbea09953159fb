// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/byte_stream.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kAtOnce = 1 << 16;

class UnpackedStream final : public ByteStream {
  public:
    UnpackedStream(InputFile file, int64_t begin) : ByteStream(std::move(file), begin) {
        constexpr int kGzipOrZlib = 32;
        ready_ = inflateInit2(&state_, kGzipOrZlib + MAX_WBITS) == Z_OK;
    }
    ~UnpackedStream() override { inflateEnd(&state_); }
    UnpackedStream(const UnpackedStream&) = delete;
    UnpackedStream& operator=(const UnpackedStream&) = delete;

    Result<size_t> next(char* out, size_t bytes) override {
        state_.next_out = reinterpret_cast<Bytef*>(out);
        state_.avail_out = static_cast<uInt>(bytes);
        while (state_.avail_out > 0 && !ended_) {
            if (Result<void> filled = fill(1); !filled) return filled.error();
            const int done = ready_ ? inflate(&state_, Z_NO_FLUSH) : Z_MEM_ERROR;
            // Without input it makes no progress: the data is truncated.
            if (done != Z_OK && done != Z_STREAM_END)
                return user_error(messages::kCompressedOfOtherSize);
            if (done != Z_STREAM_END) continue;
            const Result<bool> more = next_member();
            if (!more) return more.error();
            ended_ = !*more;
        }
        return bytes - state_.avail_out;
    }
    Result<void> skip(int64_t bytes) override {
        std::vector<char> unused(kAtOnce);
        while (bytes > 0) {
            const auto step = static_cast<size_t>(std::min<int64_t>(bytes, kAtOnce));
            const Result<size_t> got = next(unused.data(), step);
            if (!got) return got.error();
            if (*got < step) return user_error(messages::kCompressedOfOtherSize);
            bytes -= static_cast<int64_t>(step);
        }
        return {};
    }
    int64_t left() const override {
        constexpr int64_t kDensest = 1032;  // of deflate: bytes per compressed byte
        return ByteStream::left() * kDensest;
    }

  private:
    /// Holds at least `least` bytes of input, as far as the file has them.
    Result<void> fill(size_t least) {
        size_t held = state_.avail_in;
        if (held >= least) return {};
        if (held > 0) std::memmove(buffer_.data(), state_.next_in, held);
        while (held < least) {
            const Result<size_t> got =
                ByteStream::next(buffer_.data() + held, buffer_.size() - held);
            if (!got) return got.error();
            if (*got == 0) break;
            held += *got;
        }
        state_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
        state_.avail_in = static_cast<uInt>(held);
        return {};
    }
    /// Goes on to the next member, of which a gzip file may have any number (RFC 1952, 2.2); anything else
    /// behind the last is left out, as gzip does.
    Result<bool> next_member() {
        constexpr std::array<uint8_t, 3> kMember{0x1f, 0x8b, 8};
        if (Result<void> filled = fill(kMember.size()); !filled) return filled.error();
        if (state_.avail_in < kMember.size() ||
            !std::equal(kMember.begin(), kMember.end(), state_.next_in))
            return false;
        return inflateReset(&state_) == Z_OK;
    }

    z_stream state_{};
    bool ready_ = false;
    bool ended_ = false;
    std::vector<char> buffer_ = std::vector<char>(kAtOnce);
};

/// The data of several files, each with its share of the bytes.
class ChainedStream final : public ByteStream {
  public:
    ChainedStream(InputFile first, std::vector<OpenPart> parts, int64_t share, int64_t bytes)
        : ByteStream(std::move(first), 0), parts_(std::move(parts)), share_(share), bytes_(bytes) {}

    Result<size_t> next(char* out, size_t bytes) override {
        size_t done = 0;
        while (done < bytes) {
            if (left_ == 0) {
                if (part_ == parts_.size()) break;
                Result<std::unique_ptr<ByteStream>> opened = parts_[part_++]();
                if (!opened) return opened.error();
                stream_ = std::move(*opened);
                left_ = share_;
            }
            const auto step =
                static_cast<size_t>(std::min<int64_t>(left_, static_cast<int64_t>(bytes - done)));
            const Result<size_t> got = stream_->next(out + done, step);
            if (!got) return got.error();
            if (*got < step)
                return user_error(fmt::format(messages::kPartCutShort, part_, parts_.size()));
            done += step;
            left_ -= static_cast<int64_t>(step);
        }
        return done;
    }
    int64_t left() const override { return bytes_; }

  private:
    std::vector<OpenPart> parts_;
    int64_t share_, bytes_;
    size_t part_ = 0;   ///< the next one
    int64_t left_ = 0;  ///< of the share of the one at hand
    std::unique_ptr<ByteStream> stream_;
};

}  // namespace

Result<size_t> ByteStream::next(char* out, size_t bytes) {
    Result<size_t> got = file_.read(at_, out, bytes);
    if (got) at_ += static_cast<int64_t>(*got);
    return got;
}

Result<void> ByteStream::skip(int64_t bytes) {
    at_ += std::max<int64_t>(bytes, 0);
    return {};
}

std::unique_ptr<ByteStream> open_bytes(InputFile file, int64_t begin) {
    return std::make_unique<ByteStream>(std::move(file), begin);
}

std::unique_ptr<ByteStream> open_packed_bytes(InputFile file, int64_t begin) {
    return std::make_unique<UnpackedStream>(std::move(file), begin);
}

Result<std::unique_ptr<ByteStream>> chain_bytes(InputFile first, std::vector<OpenPart> parts,
                                                int64_t share) {
    int64_t most = 0;
    for (const OpenPart& part : parts) {
        const Result<std::unique_ptr<ByteStream>> opened = part();
        if (!opened) return opened.error();
        most += std::min((*opened)->left(), share);
    }
    return std::unique_ptr<ByteStream>(
        std::make_unique<ChainedStream>(std::move(first), std::move(parts), share, most));
}

}  // namespace openfab::tools
