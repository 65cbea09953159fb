// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// MRC2014, https://www.ccpem.ac.uk/mrc-format/mrc2014, as microscopes and IMOD write it.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "base/input_file.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/scans.h"
#include "tools/texture/stored_grid.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kHeaderBytes = 1024;

/// The words of the header, of 4 bytes each, numbered from 1 as in its description.
class Words {
  public:
    Words(const char* bytes, bool swapped) : bytes_(bytes), swapped_(swapped) {}
    template <typename T>
    T word(int number) const {
        std::array<char, 4> raw{};
        std::memcpy(raw.data(), bytes_ + 4 * (number - 1), raw.size());
        if (swapped_) std::reverse(raw.begin(), raw.end());
        T value;
        std::memcpy(&value, raw.data(), raw.size());
        return value;
    }
    int64_t whole(int number) const { return word<int32_t>(number); }
    double real(int number) const { return static_cast<double>(word<float>(number)); }

  private:
    const char* bytes_;
    bool swapped_;
};

/// The kind of its numbers. IMOD's bytes may be unsigned, which it says in words of its own.
Result<NumberFormat> format_of(const Words& words, bool swapped) {
    using Kind = NumberFormat::Kind;
    constexpr int32_t kImod = 1146047817;
    const bool says = words.word<int32_t>(39) == kImod;
    const bool is_signed = !says || (words.whole(40) & 1) != 0;
    switch (words.whole(4)) {
        case 0:
            return NumberFormat{is_signed ? Kind::kSigned : Kind::kUnsigned, 1, swapped, true};
        case 1:
            return NumberFormat{Kind::kSigned, 2, swapped, true};
        case 2:
            return NumberFormat{Kind::kFloat, 4, swapped, true};
        case 6:
            return NumberFormat{Kind::kUnsigned, 2, swapped, true};
        case 12:
            return NumberFormat{Kind::kFloat, 2, swapped, true};
        default:
            return user_error(fmt::format(messages::kMrcMode, words.whole(4)),
                              messages::kMrcModeHelp);
    }
}

/// Where its texels lie, of lengths in Angstrom. The axes of the file are any of x, y and z.
Result<GridFrame> frame_of(const Words& words, const texture::VolumeOptions& options) {
    constexpr double kAngstrom = 1e-7;
    const double unit = options.unit.empty() ? kAngstrom : unit_mm(options);
    GridFrame frame;
    int seen = 0;
    for (int index = 0; index < 3; ++index) {
        const int64_t axis = words.whole(17 + index) - 1;
        if (axis < 0 || axis > 2) return user_error(messages::kMrcAxes);
        seen |= 1 << axis;
        const int64_t samples = words.whole(8 + static_cast<int>(axis));
        const double length = words.real(11 + static_cast<int>(axis));
        const double angle = words.real(14 + static_cast<int>(axis));
        if (angle != 0 && std::abs(angle - 90) > 1e-3) return user_error(messages::kMrcAngles);
        const bool known = samples > 0 && std::isfinite(length) && length > 0;
        const double step = known ? length / static_cast<double>(samples) * unit : 1;
        const int a = static_cast<int>(axis);
        frame.steps[static_cast<size_t>(index)][a] = step;
        frame.first[a] += static_cast<double>(words.whole(5 + index)) * step;
    }
    if (seen != 7) return user_error(messages::kMrcAxes);
    for (int a = 0; a < 3; ++a) {
        const double origin = words.real(50 + a);
        if (std::isfinite(origin)) frame.first[a] += origin * unit;
    }
    return frame;
}

/// Refuses images of which none is a slice, and volumes behind each other, by the space group and the sections
/// of a volume.
Result<void> check_kind(const Words& words) {
    constexpr int64_t kOfVolumes = 401;
    const int64_t sections = words.whole(3), in_volume = words.whole(10), group = words.whole(23);
    if (group == 0 && in_volume == 1 && sections > 1)
        return user_error(fmt::format(messages::kMrcImages, sections), messages::kMrcImagesHelp);
    const bool several = group >= kOfVolumes && in_volume > 0 && in_volume < sections;
    if (!several) return {};
    return user_error(fmt::format(messages::kMrcVolumes, sections / in_volume),
                      messages::kOneOfThemHelp);
}

}  // namespace

bool is_mrc(std::string_view head) {
    constexpr size_t kMark = 208;
    return head.size() >= kMark + 4 && head.substr(kMark, 4) == "MAP ";
}

MadeReader open_mrc(const fs::path& path, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits) {
    Result<InputFile> file = InputFile::open(path);
    if (!file) return file.error();
    std::array<char, kHeaderBytes> head{};
    const Result<size_t> got = file->read(0, head.data(), head.size());
    if (!got) return got.error();
    if (*got < head.size()) return user_error(messages::kCutShort);
    // The stamp says the order of bytes; where it is missing, the axes do, which are 1 to 3.
    const bool stamped = head[212] == 0x44 || head[212] == 0x11;
    const int64_t axis = Words(head.data(), false).whole(17);
    const bool swapped = stamped ? head[212] == 0x11 : axis < 1 || axis > 3;
    const Words words(head.data(), swapped);
    if (Result<void> fits = check_kind(words); !fits) return fits.error();
    StoredGrid grid;
    const Result<NumberFormat> format = format_of(words, swapped);
    if (!format) return format.error();
    grid.format = *format;
    if (Result<void> fits = set_sides({words.whole(1), words.whole(2), words.whole(3)}, 1, &grid);
        !fits)
        return fits.error();
    const int64_t extended = words.whole(24);
    if (extended < 0) return user_error(messages::kHeaderDamaged);
    const Result<GridFrame> frame = frame_of(words, options);
    if (!frame) return frame.error();
    grid.skip = static_cast<int64_t>(kHeaderBytes) + extended;
    grid.stream = open_bytes(std::move(*file), 0);
    MadeReader reader = open_stored_grid(std::move(grid), limits);
    if (!reader) return reader;
    return place_reader(std::move(*reader), *frame, options, limits);
}

}  // namespace openfab::tools
