// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/byte_stream.h"

#include <zlib.h>

#include <algorithm>

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
            if (state_.avail_in == 0) {
                const Result<size_t> got = ByteStream::next(buffer_.data(), buffer_.size());
                if (!got) return got.error();
                state_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
                state_.avail_in = static_cast<uInt>(*got);
            }
            const int done = ready_ ? inflate(&state_, Z_NO_FLUSH) : Z_MEM_ERROR;
            ended_ = done == Z_STREAM_END;
            // Without input it makes no progress: the data is truncated.
            if (done != Z_OK && !ended_) return user_error(messages::kCompressedOfOtherSize);
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
    z_stream state_{};
    bool ready_ = false;
    bool ended_ = false;
    std::vector<char> buffer_ = std::vector<char>(kAtOnce);
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

}  // namespace openfab::tools
