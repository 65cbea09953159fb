// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/zarr/slab.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>

#include "backends/common/messages.h"
#include "backends/common/tee_sink.h"
#include "backends/zarr/coarser.h"
#include "backends/zarr/shard.h"

namespace openfab::zarr {

namespace {

constexpr uint8_t kMixed = 255;

/// Part of a plane that one chunk covers.
struct Tile {
    int32_t x = 0, y = 0, width = 0, height = 0;
};

Tile tile_of(const Level& level, size_t chunk) {
    const auto across = static_cast<size_t>(level.tiles_x());
    Tile tile;
    tile.x = static_cast<int32_t>(chunk % across) * kTile;
    tile.y = static_cast<int32_t>(chunk / across) * kTile;
    tile.width = std::min(kTile, level.size.x - tile.x);
    tile.height = std::min(kTile, level.size.y - tile.y);
    return tile;
}

/// Returns whether all of a row are the byte `code`.
bool is_all(const uint8_t* row, size_t bytes, uint8_t code) {
    return bytes == 0 || (row[0] == code && std::memcmp(row, row + 1, bytes - 1) == 0);
}

size_t tile_row_bytes(const Tile& tile, int32_t bits) {
    return backends::packed_row_bytes(tile.width, bits);
}

/// Returns the one code of a tile, or kMixed.
uint8_t code_of(const pipeline::SliceView& slice, const Tile& tile, int32_t bits) {
    const size_t at = static_cast<size_t>(tile.x) * static_cast<size_t>(bits) / 8;
    const uint8_t code = slice.code(tile.x, tile.y, bits);
    const auto byte = static_cast<uint8_t>(bits == 8 ? code : code | code << 4);
    // The unused half of a row's last byte is 0.
    const bool odd = bits == 4 && tile.width % 2 != 0;
    const size_t whole = tile_row_bytes(tile, bits) - (odd ? 1 : 0);
    for (int32_t y = tile.y; y < tile.y + tile.height; ++y) {
        const uint8_t* const row = slice.data + static_cast<size_t>(y) * slice.row_bytes + at;
        if (!is_all(row, whole, byte) || (odd && row[whole] != code)) return kMixed;
    }
    return code;
}

/// Where the tiles of a slice lie in its bytes.
struct Tiles {
    std::span<const uint8_t> bytes;
    std::vector<size_t> offsets;  ///< of those that are mixed

    Tiles(std::span<const uint8_t> of, const Level& level, int32_t bits) : bytes(of) {
        size_t at = level.chunks();
        for (size_t chunk = 0; chunk < level.chunks(); ++chunk) {
            offsets.push_back(at);
            const Tile tile = tile_of(level, chunk);
            if (bytes[chunk] == kMixed)
                at += tile_row_bytes(tile, bits) * static_cast<size_t>(tile.height);
        }
    }
    uint8_t code(size_t chunk) const { return bytes[chunk]; }

    /// Unpacks a tile into rows of kTile codes.
    void unpack(size_t chunk, const Tile& tile, int32_t bits, uint8_t* codes) const {
        if (code(chunk) != kMixed) {
            std::fill_n(codes, kTile * kTile, code(chunk));
            return;
        }
        const size_t row_bytes = tile_row_bytes(tile, bits);
        const pipeline::SliceView view{0, bytes.data() + offsets[chunk], row_bytes, tile.width,
                                       tile.height};
        for (int32_t y = 0; y < tile.height; ++y)
            backends::unpack_row(view, y, bits, codes + static_cast<size_t>(y) * kTile);
    }
};

/// Frames of chunks of one code each, made once.
class PlainFrames {
  public:
    explicit PlainFrames(const Level& level) : bytes_(level.chunk_bytes()) {}
    std::vector<uint8_t> make(uint8_t code) {
        if (code == 0) return {};
        if (code != code_ || frame_.empty()) {
            frame_ = compress_chunk(std::vector<uint8_t>(bytes_, code));
            code_ = code;
        }
        return frame_;
    }

  private:
    size_t bytes_;
    uint8_t code_ = 0;
    std::vector<uint8_t> frame_;
};

/// Calls `work` for ranges of chunks, each with what it keeps from chunk to chunk.
template <typename Keep, typename Work>
void for_chunks(const Level& level, const Work& work) {
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(tbb::blocked_range<size_t>(0, level.chunks()), [&](const auto& range) {
            Keep keep(level);
            for (size_t chunk = range.begin(); chunk < range.end(); ++chunk)
                work(chunk, &keep);
        });
    });
}

/// What a thread needs for a chunk.
struct Keep {
    explicit Keep(const Level& level) : plain(level) {}
    PlainFrames plain;
    std::vector<uint8_t> codes;
};

class FramesOfLevel {
  public:
    explicit FramesOfLevel(const Level& level) : frames_(level.chunks()) {}
    void set(size_t chunk, std::vector<uint8_t> frame) {
        if (frame.empty()) failed_ = true;
        frames_[chunk] = std::move(frame);
    }
    void set_plain(size_t chunk, uint8_t code, PlainFrames* plain) {
        if (code != 0) set(chunk, plain->make(code));
    }
    Result<std::vector<uint8_t>> join() const {
        if (failed_) return outside_error(backends::messages::kOutOfMemory);
        const std::vector<std::span<const uint8_t>> views(frames_.begin(), frames_.end());
        return join_frames(views);
    }

  private:
    std::vector<std::vector<uint8_t>> frames_;
    std::atomic<bool> failed_ = false;
};

/// Halves the planes of one chunk, rows of kTile codes, into planes of the next level.
void halve_chunk(const Tile& tile, size_t planes, const uint8_t* codes, const Level& to,
                 uint8_t* out) {
    const auto row = [&](int32_t z, int32_t y) {
        return codes + (static_cast<size_t>(z) * kTile + static_cast<size_t>(y)) * kTile;
    };
    const auto count = static_cast<int32_t>(planes);
    for (int32_t z = 0; z < (count + 1) / 2; ++z) {
        const int32_t above = second_of_pair(z, count);
        for (int32_t y = 0; y < (tile.height + 1) / 2; ++y) {
            const int32_t next = second_of_pair(y, tile.height);
            uint8_t* const to_row =
                out + z * to.plane() + int64_t{tile.y / 2 + y} * to.size.x + tile.x / 2;
            halve_rows({row(2 * z, 2 * y), row(2 * z, next), row(above, 2 * y), row(above, next)},
                       tile.width, to_row);
        }
    }
}

void fill_chunk(const Tile& tile, size_t planes, uint8_t code, const Level& to, uint8_t* out) {
    for (size_t z = 0; z < (planes + 1) / 2; ++z) {
        for (int32_t y = 0; y < (tile.height + 1) / 2; ++y) {
            uint8_t* const row = out + static_cast<int64_t>(z) * to.plane() +
                                 int64_t{tile.y / 2 + y} * to.size.x + tile.x / 2;
            std::fill_n(row, (tile.width + 1) / 2, code);
        }
    }
}

}  // namespace

std::vector<uint8_t> split_tiles(const pipeline::SliceView& slice, int32_t bits) {
    const Level level{{slice.width, slice.height, 1}, kSlab};
    std::vector<uint8_t> bytes(level.chunks());
    size_t mixed = 0;
    for (size_t chunk = 0; chunk < bytes.size(); ++chunk) {
        const Tile tile = tile_of(level, chunk);
        bytes[chunk] = code_of(slice, tile, bits);
        if (bytes[chunk] == kMixed)
            mixed += tile_row_bytes(tile, bits) * static_cast<size_t>(tile.height);
    }
    const size_t chunks = bytes.size();
    bytes.reserve(chunks + mixed);
    for (size_t chunk = 0; chunk < chunks; ++chunk) {
        if (bytes[chunk] != kMixed) continue;
        const Tile tile = tile_of(level, chunk);
        const size_t at = static_cast<size_t>(tile.x) * static_cast<size_t>(bits) / 8;
        for (int32_t y = tile.y; y < tile.y + tile.height; ++y) {
            const uint8_t* const row = slice.data + static_cast<size_t>(y) * slice.row_bytes + at;
            bytes.insert(bytes.end(), row, row + tile_row_bytes(tile, bits));
        }
    }
    return bytes;
}

Result<std::vector<uint8_t>> make_shard(const Level& level, std::span<const uint8_t> planes) {
    FramesOfLevel frames(level);
    const auto plane = static_cast<size_t>(level.plane());
    const size_t count = planes.size() / plane;
    for_chunks<Keep>(level, [&](size_t chunk, Keep* keep) {
        const Tile tile = tile_of(level, chunk);
        const auto row_at = [&](size_t z, int32_t y) {
            return planes.data() + z * plane +
                   static_cast<size_t>(tile.y + y) * static_cast<size_t>(level.size.x) + tile.x;
        };
        const uint8_t first = *row_at(0, 0);
        const auto width = static_cast<size_t>(tile.width);
        bool plain = true;
        for (size_t z = 0; z < count && plain; ++z)
            for (int32_t y = 0; y < tile.height && plain; ++y)
                plain = is_all(row_at(z, y), width, first);
        if (plain) return frames.set_plain(chunk, first, &keep->plain);
        keep->codes.assign(level.chunk_bytes(), 0);
        for (size_t z = 0; z < count; ++z)
            for (int32_t y = 0; y < tile.height; ++y)
                std::copy_n(row_at(z, y), width,
                            keep->codes.data() + (z * kTile + static_cast<size_t>(y)) * kTile);
        frames.set(chunk, compress_chunk(keep->codes));
    });
    return frames.join();
}

std::vector<uint8_t> halve_planes(const Level& finer, std::span<const uint8_t> planes) {
    const auto plane = static_cast<size_t>(finer.plane());
    const auto count = static_cast<int32_t>(planes.size() / plane);
    const int32_t width = (finer.size.x + 1) / 2, height = (finer.size.y + 1) / 2;
    std::vector<uint8_t> half(static_cast<size_t>((count + 1) / 2) * static_cast<size_t>(height) *
                              static_cast<size_t>(width));
    const auto row = [&](int32_t z, int32_t y) {
        return planes.data() + static_cast<size_t>(z) * plane +
               static_cast<size_t>(y) * static_cast<size_t>(finer.size.x);
    };
    tbb::this_task_arena::isolate([&] {
        tbb::parallel_for(0, (count + 1) / 2 * height, [&](int32_t line) {
            const int32_t z = line / height, y = line % height;
            const int32_t above = second_of_pair(z, count);
            const int32_t next = second_of_pair(y, finer.size.y);
            halve_rows({row(2 * z, 2 * y), row(2 * z, next), row(above, 2 * y), row(above, next)},
                       finer.size.x, half.data() + int64_t{line} * width);
        });
    });
    return half;
}

Result<std::vector<std::vector<uint8_t>>> make_shards(std::span<const std::vector<uint8_t>> slices,
                                                      std::span<const Level> levels, int32_t bits) {
    const Level& finest = levels[0];
    std::vector<Tiles> tiles;
    for (const std::vector<uint8_t>& slice : slices)
        tiles.emplace_back(slice, finest, bits);
    const bool halved = levels.size() > 1;
    const size_t planes = (slices.size() + 1) / 2;
    std::vector<uint8_t> half(halved ? planes * static_cast<size_t>(levels[1].plane()) : 0);
    FramesOfLevel frames(finest);
    for_chunks<Keep>(finest, [&](size_t chunk, Keep* keep) {
        const Tile tile = tile_of(finest, chunk);
        const uint8_t code = tiles[0].code(chunk);
        const bool plain = code != kMixed && std::ranges::all_of(tiles, [&](const Tiles& slice) {
                               return slice.code(chunk) == code;
                           });
        if (plain) {
            frames.set_plain(chunk, code, &keep->plain);
            // `half` begins as void.
            if (halved && code != 0) fill_chunk(tile, slices.size(), code, levels[1], half.data());
            return;
        }
        // Beyond the grid chunks have zeros.
        keep->codes.assign(finest.chunk_bytes(), 0);
        for (size_t z = 0; z < tiles.size(); ++z)
            tiles[z].unpack(chunk, tile, bits, keep->codes.data() + z * kTile * kTile);
        frames.set(chunk, compress_chunk(keep->codes));
        if (halved) halve_chunk(tile, slices.size(), keep->codes.data(), levels[1], half.data());
    });
    std::vector<std::vector<uint8_t>> shards;
    Result<std::vector<uint8_t>> shard = frames.join();
    for (size_t level = 1; shard; ++level) {
        shards.push_back(std::move(*shard));
        if (level == levels.size() || level == kSlabLevels) return shards;
        shard = make_shard(levels[level], half);
        if (level + 1 < levels.size() && level + 1 < kSlabLevels)
            half = halve_planes(levels[level], half);
    }
    return shard.error();
}

}  // namespace openfab::zarr
