// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/bmp_slice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "backends/common/tee_sink.h"

namespace openfab::raster {

namespace {

constexpr size_t kHeaderBytes = 14 + 40 + 2 * 4;  // file header, info header, palette

size_t stride_of(const pipeline::PrintInfo& info) {
    return (static_cast<size_t>(info.size.x) + 31) / 32 * 4;
}

void put16(uint8_t* out, uint32_t value) {
    out[0] = static_cast<uint8_t>(value);
    out[1] = static_cast<uint8_t>(value >> 8);
}
void put32(uint8_t* out, uint32_t value) {
    put16(out, value);
    put16(out + 2, value >> 16);
}

std::array<uint8_t, kHeaderBytes> header_of(const pipeline::PrintInfo& info) {
    const auto per_metre = [](double pitch_mm) {
        return static_cast<uint32_t>(std::lround(1000 / pitch_mm));
    };
    std::array<uint8_t, kHeaderBytes> h{};
    h[0] = 'B', h[1] = 'M';
    put32(&h[2], static_cast<uint32_t>(bmp_file_bytes(info)));
    put32(&h[10], kHeaderBytes);
    put32(&h[14], 40);
    put32(&h[18], static_cast<uint32_t>(info.size.x));
    put32(&h[22], static_cast<uint32_t>(info.size.y));
    put16(&h[26], 1);  // planes
    put16(&h[28], 1);  // bits a pixel
    put32(&h[34], static_cast<uint32_t>(bmp_file_bytes(info) - kHeaderBytes));
    put32(&h[38], per_metre(info.pitch_mm.x));
    put32(&h[42], per_metre(info.pitch_mm.y));
    put32(&h[46], 2);  // colours
    put32(&h[54], 0x00ffffff);
    put32(&h[58], 0x00000000);
    return h;
}

}  // namespace

size_t bmp_file_bytes(const pipeline::PrintInfo& info) {
    return kHeaderBytes + stride_of(info) * static_cast<size_t>(info.size.y);
}

std::vector<uint8_t> encode_bmp_slice(const pipeline::SliceView& slice,
                                      const pipeline::PrintInfo& info, bool flip_x) {
    const size_t file = bmp_file_bytes(info);
    const size_t stride = stride_of(info);
    const std::array<uint8_t, kHeaderBytes> header = header_of(info);
    std::vector<uint8_t> out(file * info.materials.size());
    for (size_t m = 0; m < info.materials.size(); ++m)
        std::copy(header.begin(), header.end(),
                  out.begin() + static_cast<std::ptrdiff_t>(m * file));
    const auto width = static_cast<size_t>(slice.width);
    // Eight voxels at a time are a byte of each material's row; those beyond the row are void.
    std::vector<uint8_t> codes((width + 7) / 8 * 8);
    for (int32_t y = 0; y < slice.height; ++y) {
        backends::unpack_row(slice, y, info.bits, codes.data());
        if (flip_x) std::reverse(codes.begin(), codes.begin() + slice.width);
        uint8_t* row = out.data() + kHeaderBytes + stride * static_cast<size_t>(y);
        for (size_t i = 0; i < codes.size(); i += 8) {
            uint64_t eight = 0;
            std::memcpy(&eight, &codes[i], 8);
            if (eight == 0) continue;
            if (eight == codes[i] * 0x0101010101010101u) {
                row[file * (codes[i] - 1u) + i / 8] = 0xff;
                continue;
            }
            for (size_t k = 0; k < 8; ++k) {
                if (codes[i + k] == 0) continue;
                uint8_t& byte = row[file * (codes[i + k] - 1u) + i / 8];
                byte = static_cast<uint8_t>(byte | 0x80 >> k);
            }
        }
    }
    return out;
}

std::vector<uint8_t> decode_bmp_slice(std::span<const uint8_t> files,
                                      const pipeline::PrintInfo& info) {
    const size_t file = bmp_file_bytes(info);
    const size_t stride = stride_of(info);
    const auto width = static_cast<size_t>(info.size.x);
    const auto height = static_cast<size_t>(info.size.y);
    const std::array<uint8_t, kHeaderBytes> header = header_of(info);
    if (files.size() != file * info.materials.size()) return {};
    std::vector<uint8_t> codes(width * height);
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const std::span<const uint8_t> one = files.subspan(m * file, file);
        if (!std::equal(header.begin(), header.end(), one.begin())) return {};
        for (size_t y = 0; y < height; ++y) {
            const uint8_t* row = one.data() + kHeaderBytes + stride * y;
            for (size_t x = 0; x < 8 * stride; ++x) {
                if ((row[x / 8] & 0x80 >> x % 8) == 0) continue;
                // A drop beyond the row, or of two materials.
                if (x >= width || codes[width * y + x] != 0) return {};
                codes[width * y + x] = static_cast<uint8_t>(m + 1);
            }
        }
    }
    return codes;
}

}  // namespace openfab::raster
