// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/vdb/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "backends/common/tee_sink.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/npy.h"
#include "backends/raster/npy_sink.h"
#include "base/input_file.h"
#include "base/json.h"
#include "base/units.h"
#include "tools/vdb/messages.h"
#include "tools/vdb/sparse_grids.h"

namespace openfab::tools {

namespace {

constexpr int32_t kSide = 8;

static_assert(std::endian::native == std::endian::little, "arrays are read as they lie");

int32_t padded(int32_t side) {
    return (side + kSide - 1) / kSide * kSide;
}

/// The codes of eight slices, one a byte, rows and their number padded to whole blocks.
class CodeSlab {
  public:
    explicit CodeSlab(const pipeline::PrintInfo& info)
        : bits_(info.bits),
          width_(padded(info.size.x)),
          height_(padded(info.size.y)),
          codes_(bytes(info)) {}

    static size_t bytes(const pipeline::PrintInfo& info) {
        return static_cast<size_t>(padded(info.size.x)) * static_cast<size_t>(padded(info.size.y)) *
               kSide;
    }
    void add(const pipeline::SliceView& slice) {
        for (int32_t y = 0; y < slice.height; ++y)
            backends::unpack_row(slice, y, bits_, codes_.data() + row(y, slice.z % kSide));
    }
    /// Adds its blocks to a grid, and clears it.
    Result<void> flush(int32_t z, size_t grid, SparseGrids* grids) {
        Result<void> done;
        for (int32_t y = 0; y < height_ && done; y += kSide) {
            for (int32_t x = 0; x < width_ && done; x += kSide) {
                if (gather(x, y)) done = grids->set(grid, {x, y, z}, block_);
            }
        }
        std::fill(codes_.begin(), codes_.end(), uint8_t{0});
        return done;
    }

  private:
    size_t row(int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(height_) + static_cast<size_t>(y)) *
               static_cast<size_t>(width_);
    }
    /// Returns false where all of the block is void.
    bool gather(int32_t x, int32_t y) {
        uint64_t any = 0;
        for (int32_t dz = 0; dz < kSide; ++dz) {
            for (int32_t dy = 0; dy < kSide; ++dy) {
                const uint8_t* const codes = codes_.data() + row(y + dy, dz) + x;
                uint64_t eight = 0;
                std::memcpy(&eight, codes, sizeof eight);
                any |= eight;
                for (int32_t dx = 0; dx < kSide; ++dx)
                    block_[place_in_block(dx, dy, dz)] = codes[dx];
            }
        }
        return any != 0;
    }

    int32_t bits_, width_, height_;
    std::vector<uint8_t> codes_;
    VoxelBlock<int32_t> block_{};
};

/// An array of `--fractions`, and what the JSON beside it says.
struct Fractions {
    std::optional<InputFile> file;
    Vec3i size;
    int32_t first_slice = 0;
    size_t materials = 0;
    VoxelFrame frame;
    std::vector<std::string> names;
};

/// Reads `key` of an object, an array of three numbers.
bool read_three(const JsonValue& object, const char* key, std::array<double, 3>* out) {
    const JsonMember* member = object.find(key);
    if (member == nullptr || member->value.items.size() != 3) return false;
    for (size_t i = 0; i < 3; ++i) {
        if (!member->value.items[i].is(JsonValue::Kind::kNumber)) return false;
        (*out)[i] = member->value.items[i].number;
    }
    return true;
}

bool is_size(double number) {
    return number >= 1 && number <= INT32_MAX - kSide && number == std::floor(number);
}

bool read_description(const JsonValue& json, Fractions* out) {
    std::array<double, 3> shape{}, pitch{}, origin{};
    const JsonMember* const first = json.find("first_slice_z");
    const JsonMember* const materials = json.find("materials");
    if (!read_three(json, "shape_zyx", &shape) || !read_three(json, "pitch_mm", &pitch) ||
        !read_three(json, "origin_mm", &origin) || first == nullptr || materials == nullptr)
        return false;
    if (!std::all_of(shape.begin(), shape.end(), is_size) ||
        !std::all_of(pitch.begin(), pitch.end(), [](double mm) { return mm > 0; }) ||
        !(is_size(first->value.number + 1) && is_size(first->value.number + shape[0])))
        return false;
    out->size = {static_cast<int32_t>(shape[2]), static_cast<int32_t>(shape[1]),
                 static_cast<int32_t>(shape[0])};
    out->frame = {{origin[0], origin[1], origin[2]}, {pitch[0], pitch[1], pitch[2]}};
    out->first_slice = static_cast<int32_t>(first->value.number);
    for (const JsonValue& material : materials->value.items) {
        const JsonMember* const name = material.find("name");
        if (name == nullptr || name->value.text.empty()) return false;
        out->names.push_back(name->value.text);
    }
    return true;
}

Result<Fractions> open_fractions(const std::string& array) {
    const auto wrong = [&](const std::string& what) {
        return user_error(fmt::format("`{}` {}", array, what));
    };
    constexpr int64_t kMostJson = 1 << 20;
    const std::string beside = raster::array_json_path(array);
    Result<std::string> text = read_text_file(beside, kMostJson);
    if (!text) return text.error();
    Result<JsonValue> json = parse_json(*text, beside);
    if (!json) return json.error();
    Fractions out;
    if (!read_description(*json, &out))
        return user_error(fmt::format(messages::kNotAnArrayOfOpenFab, beside));
    const JsonMember* const complete = json->find("complete");
    if (complete == nullptr || !complete->value.boolean) return wrong(messages::kArrayOfEndedPrint);
    Result<InputFile> file = InputFile::open(array);
    if (!file) return with_context(file.error(), fmt::format(messages::kCannotReadArray, array));
    const double voxels = static_cast<double>(out.size.x) * out.size.y * out.size.z;
    const int64_t payload = file->bytes() - static_cast<int64_t>(raster::kNpyHeaderBytes);
    out.materials = static_cast<size_t>(
        std::clamp(static_cast<double>(payload) / (voxels * sizeof(float)), 0.0, 256.0));
    const std::array<int64_t, 4> shape{out.size.z, out.size.y, out.size.x,
                                       static_cast<int64_t>(out.materials)};
    std::vector<uint8_t> header(raster::kNpyHeaderBytes);
    const Result<size_t> got = file->read(0, header.data(), header.size());
    if (!got) return with_context(got.error(), fmt::format(messages::kCannotReadArray, array));
    if (out.materials == 0 || out.materials > out.names.size() ||
        header != raster::npy_header("<f4", shape))
        return wrong(fmt::format(messages::kNotTheDescribedArray, beside));
    out.file.emplace(std::move(*file));
    return out;
}

/// Passes blocks of fractions to the grids, row of blocks by row of blocks.
class FractionBlocks {
  public:
    FractionBlocks(const Fractions& fractions, const std::string& name)
        : f_(fractions),
          name_(name),
          row_values_(static_cast<size_t>(f_.size.x) * f_.materials),
          rows_(row_values_ * kSide * kSide) {}

    /// Sets the blocks of slices from `z` (a multiple of 8) and rows from `y` on.
    Result<void> set(int32_t z, int32_t y, SparseGrids* grids) {
        const int32_t rows = std::min(kSide, f_.size.y - y);
        const int32_t begin = std::max(z, f_.first_slice);
        const int32_t end = std::min(z + kSide, f_.first_slice + f_.size.z);
        std::fill(rows_.begin(), rows_.end(), 0.0F);
        for (int32_t slice = begin; slice < end; ++slice) {
            if (Result<void> done = read(slice - f_.first_slice, y, rows, slice - z); !done)
                return done;
        }
        if (std::all_of(rows_.begin(), rows_.end(), [](float v) { return v == 0; })) return {};
        Result<void> done;
        for (size_t m = 0; m < f_.materials; ++m) {
            for (int32_t x = 0; x < f_.size.x && done; x += kSide) {
                gather(x, m);
                done = grids->set(m, {x, y, z}, block_);
            }
        }
        return done;
    }

  private:
    Result<void> read(int32_t slice, int32_t y, int32_t rows, int32_t dz) {
        const size_t bytes = row_values_ * static_cast<size_t>(rows) * sizeof(float);
        const int64_t row = int64_t{slice} * f_.size.y + y;
        const int64_t at = static_cast<int64_t>(raster::kNpyHeaderBytes) +
                           row * static_cast<int64_t>(row_values_ * sizeof(float));
        float* const to = rows_.data() + row_values_ * kSide * static_cast<size_t>(dz);
        const Result<size_t> got = f_.file->read(at, to, bytes);
        if (!got) return with_context(got.error(), fmt::format(messages::kCannotReadArray, name_));
        if (*got != bytes) return user_error(fmt::format(messages::kArrayFileCutShort, name_));
        return {};
    }
    void gather(int32_t x, size_t material) {
        const int32_t columns = std::min(kSide, f_.size.x - x);
        block_.fill(0);
        for (int32_t dz = 0; dz < kSide; ++dz) {
            for (int32_t dy = 0; dy < kSide; ++dy) {
                const float* const row =
                    rows_.data() + row_values_ * static_cast<size_t>(dz * kSide + dy);
                for (int32_t dx = 0; dx < columns; ++dx) {
                    block_[place_in_block(dx, dy, dz)] =
                        row[static_cast<size_t>(x + dx) * f_.materials + material];
                }
            }
        }
    }

    const Fractions& f_;
    const std::string& name_;
    size_t row_values_;
    std::vector<float> rows_;  ///< eight rows of each of eight slices
    VoxelBlock<float> block_{};
};

}  // namespace

Result<void> make_vdb_of_print(const std::string& print, const std::string& vdb,
                               int64_t memory_bytes) {
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(print, memory_bytes);
    if (!reader) return reader.error();
    const pipeline::PrintInfo& info = (*reader)->info();
    const int64_t left =
        memory_bytes - static_cast<int64_t>(CodeSlab::bytes(info)) - 2 * (*reader)->slice_bytes();
    if (left <= 0) {
        return user_error(fmt::format(messages::kEightSlicesTooLarge, print, info.size.x,
                                      info.size.y, format_bytes(memory_bytes)));
    }
    CodeSlab slab(info);
    SparseGrids grids({info.origin_mm, info.pitch_mm}, left);
    const size_t grid = grids.add_codes("material");
    for (size_t m = 0; m < info.materials.size(); ++m)
        grids.note(grid, fmt::format("material_{}", m + 1), info.materials[m].name);
    int32_t z = info.slice_begin / kSide * kSide;
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more) return more.error();
        const int32_t next = *more ? (*reader)->slice().z / kSide * kSide : z + kSide;
        if (next != z) {
            if (Result<void> done = slab.flush(z, grid, &grids); !done) return done;
            z = next;
        }
        if (!*more) return grids.write(vdb);
        slab.add((*reader)->slice());
    }
}

Result<void> make_vdb_of_fractions(const std::string& array, const std::string& vdb,
                                   int64_t memory_bytes) {
    Result<Fractions> fractions = open_fractions(array);
    if (!fractions) return fractions.error();
    const int64_t rows_bytes = int64_t{kSide} * kSide * fractions->size.x *
                               static_cast<int64_t>(fractions->materials * sizeof(float));
    if (rows_bytes >= memory_bytes) {
        return user_error(fmt::format(messages::kRowsTooLarge, array, fractions->size.x,
                                      format_bytes(memory_bytes)));
    }
    SparseGrids grids(fractions->frame, memory_bytes - rows_bytes);
    for (size_t m = 0; m < fractions->materials; ++m)
        grids.add_amounts(fractions->names[m]);
    FractionBlocks blocks(*fractions, array);
    const int32_t end = fractions->first_slice + fractions->size.z;
    for (int32_t z = fractions->first_slice / kSide * kSide; z < end; z += kSide) {
        for (int32_t y = 0; y < fractions->size.y; y += kSide) {
            if (Result<void> done = blocks.set(z, y, &grids); !done) return done;
        }
    }
    return grids.write(vdb);
}

}  // namespace openfab::tools
