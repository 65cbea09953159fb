// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/hdf5/data_set.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include "tools/hdf5/hdf5_handle.h"
#include "tools/hdf5/messages.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

/// What writers call a filter, https://github.com/HDFGroup/hdf5_plugins, which a file may not name.
std::string filter_name(H5Z_filter_t filter, const std::string& said) {
    struct Name {
        H5Z_filter_t filter;
        const char* name;
    };
    constexpr std::array<Name, 13> kNames{{{H5Z_FILTER_SZIP, "szip"},
                                           {307, "bzip2"},
                                           {32000, "LZF"},
                                           {32001, "Blosc"},
                                           {32004, "LZ4"},
                                           {32008, "bitshuffle"},
                                           {32013, "ZFP"},
                                           {32014, "fpzip"},
                                           {32015, "Zstandard"},
                                           {32017, "SZ"},
                                           {32019, "JPEG"},
                                           {32024, "SZ3"},
                                           {32026, "Blosc2"}}};
    for (const Name& known : kNames) {
        if (known.filter == filter) return known.name;
    }
    return said.empty() ? "an unknown filter" : said;
}

class SetNumbers final : public ArrayNumbers {
  public:
    Result<void> open(const InputFile& file, const std::string& set,
                      const std::vector<int64_t>& wanted,
                      const std::optional<texture::XdmfSlab>& slab) {
        file_ = open_hdf5(file);
        if (!file_.ok()) return user_error(messages::kNotHdf5);
        const Hdf5Handle access = within_file(H5P_DATASET_ACCESS);
        set_ = {H5Dopen2(file_, set.c_str(), access), H5Dclose};
        if (!set_.ok() && leads_elsewhere(set))
            return user_error(fmt::format(messages::kNumbersElsewhere, set),
                              messages::kNumbersElsewhereHelp);
        if (!set_.ok()) return user_error(fmt::format(messages::kNoDataSetOfName, set));
        const Hdf5Handle layout(H5Dget_create_plist(set_), H5Pclose);
        if (!layout.ok() || H5Pget_layout(layout) == H5D_VIRTUAL ||
            H5Pget_external_count(layout) != 0)
            return user_error(fmt::format(messages::kNumbersElsewhere, set),
                              messages::kNumbersElsewhereHelp);
        const Hdf5Handle type(H5Dget_type(set_), H5Tclose);
        // Truth values of Python are an enumeration of integers.
        const H5T_class_t said = H5Tget_class(type);
        const Hdf5Handle numbers =
            said == H5T_ENUM ? Hdf5Handle(H5Tget_super(type), H5Tclose) : Hdf5Handle();
        const H5T_class_t kind = said == H5T_ENUM ? H5Tget_class(numbers) : said;
        if (kind != H5T_INTEGER && kind != H5T_FLOAT)
            return user_error(fmt::format(messages::kDataSetWithoutNumbers, set));
        space_ = {H5Dget_space(set_), H5Sclose};
        const int rank = H5Sget_simple_extent_ndims(space_);
        sizes_.resize(static_cast<size_t>(std::max(rank, 0)));
        const bool has_sides =
            rank >= 1 && H5Sget_simple_extent_dims(space_, sizes_.data(), nullptr) == rank;
        const hssize_t all = H5Sget_simple_extent_npoints(space_);
        start_.assign(sizes_.size(), 0);
        stride_.assign(sizes_.size(), 1);
        if (slab) {
            if (!has_sides ||
                !std::equal(sizes_.begin(), sizes_.end(), slab->sizes.begin(), slab->sizes.end())) {
                return user_error(fmt::format(messages::kDataSetSides, set, fmt::join(sizes_, " "),
                                              fmt::join(slab->sizes, " ")));
            }
            start_.assign(slab->start.begin(), slab->start.end());
            stride_.assign(slab->stride.begin(), slab->stride.end());
            sizes_.assign(slab->count.begin(), slab->count.end());
        } else if (Result<void> fits = check_sides(set, all, has_sides, wanted); !fits) {
            return fits;
        }
        if (Result<void> known = check_filters(layout, set); !known) return known;
        if (Result<void> stored = check_stored(layout, type, set, static_cast<uint64_t>(all));
            !stored)
            return stored;
        integers_ = kind == H5T_INTEGER;
        is_signed_ = integers_ && H5Tget_sign(numbers.ok() ? numbers : type) != H5T_SGN_NONE;
        plan(layout);
        return {};
    }

    Result<void> next(double* out, size_t count) override {
        while (count > 0) {
            if (at_ == held_.size()) {
                if (Result<void> more = fill(); !more) return more;
            }
            const size_t n = std::min(count, held_.size() - at_);
            std::copy_n(held_.begin() + static_cast<std::ptrdiff_t>(at_), n, out);
            at_ += n;
            out += n;
            count -= n;
        }
        return {};
    }

    bool are_integers() const override { return integers_; }
    bool has_lost() const override { return has_lost_; }

  private:
    /// Refuses a set whose numbers are not in the order of an array of the sides that the XDMF file states.
    Result<void> check_sides(const std::string& set, hssize_t all, bool has_sides,
                             const std::vector<int64_t>& wanted) const {
        int64_t count = 1;
        for (const int64_t side : wanted)
            count *= side;
        if (!has_sides || all != count)
            return user_error(fmt::format(messages::kDataSetCount, set, count));
        if (are_in_one_order({sizes_.begin(), sizes_.end()}, wanted)) return {};
        return user_error(fmt::format(messages::kDataSetSides, set, fmt::join(sizes_, " "),
                                      fmt::join(wanted, " ")),
                          messages::kDataSetSidesHelp);
    }
    /// Whether a link on the way to a set leads to another file.
    bool leads_elsewhere(const std::string& set) const {
        for (size_t end = set.find('/', 1);; end = set.find('/', end + 1)) {
            H5L_info_t link{};
            const std::string part = set.substr(0, end);
            if (H5Lget_info(file_, part.c_str(), &link, H5P_DEFAULT) < 0) return false;
            if (link.type == H5L_TYPE_EXTERNAL) return true;
            if (end == std::string::npos) return false;
        }
    }
    /// Names a filter that the library does not have, as none is loaded.
    static Result<void> check_filters(hid_t layout, const std::string& set) {
        const int count = H5Pget_layout(layout) == H5D_CHUNKED ? H5Pget_nfilters(layout) : 0;
        for (int i = 0; i < count; ++i) {
            unsigned flags = 0, config = 0;
            size_t values = 0;
            std::array<char, 80> name{};
            const H5Z_filter_t filter =
                H5Pget_filter2(layout, static_cast<unsigned>(i), &flags, &values, nullptr,
                               name.size() - 1, name.data(), &config);
            if (filter < 0) return user_error(messages::kDataSetDamaged);
            if (H5Zfilter_avail(filter) > 0) continue;
            return user_error(fmt::format(messages::kFilterNotRead, set,
                                          filter_name(filter, name.data()), int{filter}),
                              messages::kFilterNotReadHelp);
        }
        return {};
    }

    /// Checks that what is stored is enough for the chunks that were written; all others have the set's fill
    /// value. How much a small file may claim so is bounded by the memory of who reads it.
    Result<void> check_stored(hid_t layout, hid_t type, const std::string& set,
                              uint64_t all) const {
        uint64_t written = all, chunks = 1, of_written = 1;
        std::array<hsize_t, H5S_MAX_RANK> chunk{};
        const uint64_t stored = H5Dget_storage_size(set_);
        if (H5Pget_layout(layout) == H5D_CHUNKED) {
            const int rank = H5Pget_chunk(layout, H5S_MAX_RANK, chunk.data());
            if (rank != H5Sget_simple_extent_ndims(space_))
                return user_error(messages::kDataSetDamaged);
            std::array<hsize_t, H5S_MAX_RANK> sides{};
            H5Sget_simple_extent_dims(space_, sides.data(), nullptr);
            hsize_t numbers = 1, has = 0;
            for (size_t a = 0; a < static_cast<size_t>(rank); ++a) {
                if (chunk[a] < 1) return user_error(messages::kDataSetDamaged);
                chunks *= (sides[a] + chunk[a] - 1) / chunk[a];
                numbers *= std::min(chunk[a], sides[a]);
            }
            if (H5Dget_num_chunks(set_, space_, &has) < 0)
                return user_error(messages::kDataSetDamaged);
            of_written = has;
            written = std::min<uint64_t>(all, has < all ? has * numbers : all);
        } else if (stored == 0) {
            written = of_written = 0;
        }
        constexpr uint64_t kDensest = 1032;  // of deflate: bytes per compressed byte
        if (stored < written / kDensest * H5Tget_size(type))
            return user_error(messages::kArrayCutShort);
        if (of_written >= chunks) return {};
        H5D_fill_value_t fill = H5D_FILL_VALUE_ERROR;
        if (H5Pfill_value_defined(layout, &fill) < 0 || fill == H5D_FILL_VALUE_UNDEFINED ||
            fill == H5D_FILL_VALUE_ERROR)
            return user_error(
                fmt::format(messages::kChunksNotWritten, chunks - of_written, chunks, set));
        tell(fmt::format(messages::kChunksAreFill, chunks - of_written, chunks, set));
        return {};
    }

    /// Finds along which axis it is read piece by piece, whole chunks each.
    void plan(hid_t layout) {
        while (axis_ + 1 < sizes_.size() && sizes_[axis_] == 1)
            ++axis_;
        row_ = 1;
        for (size_t a = axis_ + 1; a < sizes_.size(); ++a)
            row_ *= sizes_[a];
        constexpr hsize_t kAtOnce = 1 << 16;
        rows_ = std::max<hsize_t>(1, kAtOnce / row_);
        std::array<hsize_t, H5S_MAX_RANK> chunk{};
        if (H5Pget_layout(layout) == H5D_CHUNKED &&
            H5Pget_chunk(layout, H5S_MAX_RANK, chunk.data()) > static_cast<int>(axis_))
            rows_ = (rows_ + chunk[axis_] - 1) / chunk[axis_] * chunk[axis_];
    }

    Result<void> fill() {
        if (begin_ == sizes_[axis_]) return user_error(messages::kArrayCutShort);
        const hsize_t rows = std::min(rows_, sizes_[axis_] - begin_);
        std::vector<hsize_t> start = start_, size = sizes_;
        start[axis_] += begin_ * stride_[axis_];
        size[axis_] = rows;
        const hsize_t numbers = rows * row_;
        held_.resize(numbers);
        at_ = 0;
        const Hdf5Handle memory(H5Screate_simple(1, &numbers, nullptr), H5Sclose);
        if (H5Sselect_hyperslab(space_, H5S_SELECT_SET, start.data(), stride_.data(), size.data(),
                                nullptr) < 0 ||
            H5Dread(set_, H5T_NATIVE_DOUBLE, memory, space_, H5P_DEFAULT, held_.data()) < 0)
            return user_error(messages::kDataSetDamaged);
        begin_ += rows;
        return find_lost(memory);
    }

    /// Finds integers of 64 bits that are not the doubles that they became.
    Result<void> find_lost(hid_t memory) {
        constexpr double kExact = 9007199254740992;  // 2^53
        if (!integers_ || has_lost_ || std::none_of(held_.begin(), held_.end(), [](double value) {
                return std::abs(value) >= kExact;
            }))
            return {};
        std::vector<uint64_t> as_stored(held_.size());
        if (H5Dread(set_, is_signed_ ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, memory, space_,
                    H5P_DEFAULT, as_stored.data()) < 0)
            return user_error(messages::kDataSetDamaged);
        has_lost_ = std::any_of(as_stored.begin(), as_stored.end(), [this](uint64_t bits) {
            if (is_signed_ && bits >> 63 != 0) bits = 0 - bits;
            return std::bit_width(bits) - std::countr_zero(bits) >
                   std::numeric_limits<double>::digits;
        });
        return {};
    }

    Hdf5Handle file_, set_, space_;
    std::vector<hsize_t> sizes_;           ///< of what is read
    std::vector<hsize_t> start_, stride_;  ///< where that lies in the set
    size_t axis_ = 0;
    hsize_t row_ = 1, rows_ = 1;  ///< numbers of a row, and rows that are read at once
    hsize_t begin_ = 0;           ///< the next row
    bool integers_ = false, is_signed_ = false, has_lost_ = false;
    std::vector<double> held_;
    size_t at_ = 0;
};

}  // namespace

Result<std::unique_ptr<ArrayNumbers>> open_data_set(const InputFile& file, const std::string& set,
                                                    const std::vector<int64_t>& sizes,
                                                    const std::optional<texture::XdmfSlab>& slab) {
    auto out = std::make_unique<SetNumbers>();
    if (Result<void> opened = out->open(file, set, sizes, slab); !opened) return opened.error();
    return std::unique_ptr<ArrayNumbers>(std::move(out));
}

}  // namespace openfab::tools
