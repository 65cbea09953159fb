// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/zarr_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "base/input_file.h"
#include "texture/nrrd_header.h"
#include "texture/pyramid_file.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/zarr_chunks.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using texture::ZarrArray;
using texture::ZarrVolume;

/// Axes of a volume: x, y, z and channels. Those that the array has not, as others of one place, lie at 0.
constexpr size_t kAxes = 4;
constexpr size_t kZ = 2;

NumberFormat format_of(const ZarrVolume& volume) {
    using Kind = NumberFormat::Kind;
    const ZarrArray& array = volume.array;
    NumberFormat out;
    out.kind = array.kind == 'f'   ? Kind::kFloat
               : array.kind == 'i' ? Kind::kSigned
                                   : Kind::kUnsigned;
    out.bytes = array.bytes;
    out.swapped = array.big_endian && array.bytes > 1;
    out.as_stored = volume.labels || volume.print || array.kind == 'b';
    return out;
}

class ZarrReader final : public VolumeReader {
  public:
    ZarrReader(fs::path file, ZarrVolume volume, const texture::ReadLimits& limits)
        : file_(std::move(file)),
          limits_(limits),
          volume_(std::move(volume)),
          format_(format_of(volume_)) {}

    Result<void> open() {
        const ZarrArray& array = volume_.array;
        const std::array<int64_t, kAxes> sides = volume_.sides();
        for (int a = 0; a < 3; ++a)
            size[a] = static_cast<int32_t>(std::min<int64_t>(sides[static_cast<size_t>(a)],
                                                             std::numeric_limits<int32_t>::max()));
        channels = static_cast<int32_t>(sides[3]);
        spacing = volume_.spacing;
        origin = volume_.origin;
        no_nan = array.kind != 'f';
        no_lengths = !volume_.lengths;
        resampled = !volume_.levels_mm.empty();
        if (Result<void> fits = check_size(); !fits) return fits;
        const Result<std::vector<int64_t>> counts = texture::zarr_file_counts(volume_);
        if (!counts) return counts.error();
        files_ = *counts;
        for (size_t a = 0; a < kAxes; ++a) {
            const std::optional<size_t> axis = axis_of(a);
            chunk_[a] = axis ? array.chunk[*axis] : 1;
            in_file_[a] = axis ? array.file[*axis] / array.chunk[*axis] : 1;
            sides_[a] = sides[a];
        }
        int64_t stride = 1;
        for (size_t o = array.order.size(); o-- > 0;) {
            for (size_t a = 0; a < kAxes; ++a) {
                if (axis_of(a) == array.order[o]) strides_[a] = stride * array.bytes;
            }
            stride *= array.chunk[array.order[o]];
        }
        NumberFormat stored = format_;
        stored.swapped = false;
        fill_ = read_number(stored, array.fill.data());
        if (volume_.lengths && !volume_.unit_given) tell(messages::kZarrNoUnit);
        return {};
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        if (z >= layer_end_) {
            if (Result<void> read = read_layer(z); !read) return read;
        }
        const float* const slice = layer_.data() + (z - layer_begin_) * slice_floats();
        std::copy_n(slice, slice_floats(), out);
        wrote(4 * slice_floats());
        if (z + 1 == size.z && !any_) tell(messages::kZarrNoChunks);
        return {};
    }

  private:
    std::optional<size_t> axis_of(size_t a) const {
        return a < 3 ? std::optional<size_t>(volume_.axes[a]) : volume_.channels;
    }

    /// A store may have far more than there is memory for: says what would fit.
    Result<void> check_size() const {
        const texture::VolumeDomain domain;
        const Result<texture::PyramidLayout> layout =
            texture::volume_layout(size, channels, domain);
        Result<void> fits =
            layout ? check_memory(texture::pyramid_file_bytes(*layout), limits_.memory_bytes)
                   : Result<void>(layout.error());
        if (fits) return check_memory(volume_.array.chunk_bytes(), limits_.memory_bytes / 4);
        const std::vector<double>& levels = volume_.levels_mm;
        if (levels.size() < 2) return fits;
        const double coarsest = *std::max_element(levels.begin(), levels.end());
        Error error = fits.error();
        error.message = fmt::format(messages::kZarrTooLarge, error.message, levels.size(),
                                    levels[volume_.level], coarsest);
        return error;
    }

    /// Decodes the chunks around a slice: all their slices, or as many as a third of the memory holds.
    Result<void> read_layer(int32_t z) {
        const int64_t chunk_z = chunk_[kZ];
        const int64_t row = z / chunk_z;
        const int64_t end = std::min<int64_t>((row + 1) * chunk_z, size.z);
        const int64_t most = std::max<int64_t>(1, limits_.memory_bytes / 3 / (4 * slice_floats()));
        layer_begin_ = z;
        layer_end_ = static_cast<int32_t>(std::min<int64_t>(end, z + most));
        layer_.resize(static_cast<size_t>((layer_end_ - layer_begin_) * slice_floats()));
        std::vector<int64_t> counts = files_, at(files_.size(), 0);
        const size_t z_axis = volume_.axes[kZ];
        const int64_t file_z = row / in_file_[kZ];
        counts[z_axis] = 1;
        do {
            std::vector<int64_t> place = at;
            place[z_axis] = file_z;
            if (Result<void> read = read_file(place, row % in_file_[kZ]); !read) return read;
        } while (texture::next_place(counts, &at));
        return {};
    }

    /// Takes the chunks of a file that lie in the layer. `row`: of them along z in the file.
    Result<void> read_file(const std::vector<int64_t>& place, int64_t row) {
        const std::string name = volume_.path + volume_.array.file_name(place);
        const auto fail = [&](const Error& error) {
            return with_context(error, fmt::format(messages::kZarrOfFile, name));
        };
        std::error_code unknown;
        std::optional<ZarrFile> chunks;
        const fs::file_status status = fs::symlink_status(file_.parent_path() / name, unknown);
        if (status.type() != fs::file_type::not_found) {
            Result<InputFile> opened = texture::open_data_file(file_, name, limits_);
            if (!opened) return opened.error();
            Result<ZarrFile> read = ZarrFile::open(std::move(*opened), volume_.array);
            if (!read) return fail(read.error());
            chunks.emplace(std::move(*read));
        }
        std::array<int64_t, kAxes> first{};
        for (size_t a = 0; a < kAxes; ++a) {
            const std::optional<size_t> axis = axis_of(a);
            first[a] = axis ? place[*axis] * in_file_[a] : 0;
        }
        std::vector<char> bytes;
        for (int64_t c = 0; c < in_file_[3]; ++c) {
            for (int64_t y = 0; y < in_file_[1]; ++y) {
                for (int64_t x = 0; x < in_file_[0]; ++x) {
                    const std::array<int64_t, kAxes> within{x, y, row, c};
                    std::array<int64_t, kAxes> begin{};
                    bool inside = true;
                    for (size_t a = 0; a < kAxes; ++a) {
                        begin[a] = (first[a] + within[a]) * chunk_[a];
                        inside = inside && begin[a] < sides_[a];
                    }
                    if (!inside) continue;
                    bool there = false;
                    if (chunks) {
                        const Result<bool> read = chunks->read(number_in_file(within), &bytes);
                        if (!read) return fail(read.error());
                        there = *read;
                    }
                    any_ = any_ || there;
                    place_chunk(begin, there ? bytes.data() : nullptr);
                }
            }
        }
        return {};
    }

    /// Returns which chunk of its shard lies there, the last axis fastest.
    int64_t number_in_file(const std::array<int64_t, kAxes>& within) const {
        const ZarrArray& array = volume_.array;
        int64_t number = 0;
        for (size_t d = 0; d < array.shape.size(); ++d) {
            int64_t at = 0;
            for (size_t a = 0; a < kAxes; ++a) {
                if (axis_of(a) == d) at = within[a];
            }
            number = number * (array.file[d] / array.chunk[d]) + at;
        }
        return number;
    }

    /// Puts the numbers of a chunk, or the fill value where there is none, where the layer has them.
    void place_chunk(const std::array<int64_t, kAxes>& begin, const char* bytes) {
        std::array<int64_t, kAxes> from{}, end{};
        for (size_t a = 0; a < kAxes; ++a) {
            from[a] = begin[a];
            end[a] = std::min(begin[a] + chunk_[a], sides_[a]);
        }
        from[kZ] = std::max<int64_t>(from[kZ], layer_begin_);
        end[kZ] = std::min<int64_t>(end[kZ], layer_end_);
        const bool may_round = format_.kind != NumberFormat::Kind::kFloat && format_.bytes > 2;
        for (int64_t z = from[kZ]; z < end[kZ]; ++z) {
            for (int64_t y = from[1]; y < end[1]; ++y) {
                for (int64_t x = from[0]; x < end[0]; ++x) {
                    float* const to = layer_.data() + (z - layer_begin_) * slice_floats() +
                                      y * row_floats() + x * channels;
                    for (int64_t c = from[3]; c < end[3]; ++c) {
                        if (bytes == nullptr) {
                            to[c] = fill_;
                            continue;
                        }
                        const char* const number =
                            bytes + (x - begin[0]) * strides_[0] + (y - begin[1]) * strides_[1] +
                            (z - begin[kZ]) * strides_[kZ] + (c - begin[3]) * strides_[3];
                        to[c] = read_number(format_, number);
                        rounded = rounded || (may_round && is_rounded(format_, number));
                    }
                }
            }
        }
    }

    fs::path file_;
    texture::ReadLimits limits_;
    ZarrVolume volume_;
    NumberFormat format_;
    float fill_ = 0;
    std::vector<int64_t> files_;  ///< along each axis of the array
    std::array<int64_t, kAxes> sides_{}, chunk_{}, in_file_{}, strides_{};
    std::vector<float> layer_;
    int32_t layer_begin_ = 0, layer_end_ = 0;
    bool any_ = false;  ///< chunk was there
};

}  // namespace

MadeReader open_zarr(const fs::path& file, ZarrVolume volume, const texture::ReadLimits& limits) {
    auto reader = std::make_unique<ZarrReader>(file, std::move(volume), limits);
    if (Result<void> opened = reader->open(); !opened) return opened.error();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
