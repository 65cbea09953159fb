// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NRRD, https://teem.sourceforge.net/nrrd/format.html, as far as scanners and simulations write it.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <sstream>
#include <string_view>

#include "base/input_file.h"
#include "base/text.h"
#include "texture/data_files.h"
#include "texture/named_length.h"
#include "texture/nrrd_header.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/stored_grid.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kAtOnce = 1 << 16;

bool number_format(const std::string& type, NumberFormat* out) {
    using Kind = NumberFormat::Kind;
    static const std::map<std::string, std::pair<Kind, int>> kTypes = {
        {"signed char", {Kind::kSigned, 1}},
        {"int8", {Kind::kSigned, 1}},
        {"int8_t", {Kind::kSigned, 1}},
        {"uchar", {Kind::kUnsigned, 1}},
        {"unsigned char", {Kind::kUnsigned, 1}},
        {"uint8", {Kind::kUnsigned, 1}},
        {"uint8_t", {Kind::kUnsigned, 1}},
        {"short", {Kind::kSigned, 2}},
        {"short int", {Kind::kSigned, 2}},
        {"signed short", {Kind::kSigned, 2}},
        {"signed short int", {Kind::kSigned, 2}},
        {"int16", {Kind::kSigned, 2}},
        {"int16_t", {Kind::kSigned, 2}},
        {"ushort", {Kind::kUnsigned, 2}},
        {"unsigned short", {Kind::kUnsigned, 2}},
        {"unsigned short int", {Kind::kUnsigned, 2}},
        {"uint16", {Kind::kUnsigned, 2}},
        {"uint16_t", {Kind::kUnsigned, 2}},
        {"int", {Kind::kSigned, 4}},
        {"signed int", {Kind::kSigned, 4}},
        {"int32", {Kind::kSigned, 4}},
        {"int32_t", {Kind::kSigned, 4}},
        {"uint", {Kind::kUnsigned, 4}},
        {"unsigned int", {Kind::kUnsigned, 4}},
        {"uint32", {Kind::kUnsigned, 4}},
        {"uint32_t", {Kind::kUnsigned, 4}},
        {"longlong", {Kind::kSigned, 8}},
        {"long long", {Kind::kSigned, 8}},
        {"long long int", {Kind::kSigned, 8}},
        {"signed long long", {Kind::kSigned, 8}},
        {"signed long long int", {Kind::kSigned, 8}},
        {"int64", {Kind::kSigned, 8}},
        {"int64_t", {Kind::kSigned, 8}},
        {"ulonglong", {Kind::kUnsigned, 8}},
        {"unsigned long long", {Kind::kUnsigned, 8}},
        {"unsigned long long int", {Kind::kUnsigned, 8}},
        {"uint64", {Kind::kUnsigned, 8}},
        {"uint64_t", {Kind::kUnsigned, 8}},
        {"float", {Kind::kFloat, 4}},
        {"double", {Kind::kFloat, 8}},
    };
    const auto found = kTypes.find(type);
    if (found == kTypes.end()) return false;
    out->kind = found->second.first;
    out->bytes = found->second.second;
    return true;
}

/// Parses `(1,0,0)`; returns false for `none` and anything else.
bool vector_of(const std::string& word, std::array<double, 3>* out) {
    char open = 0, first = 0, second = 0, close = 0;
    std::istringstream in(word);
    in.imbue(std::locale::classic());
    in >> open >> (*out)[0] >> first >> (*out)[1] >> second >> (*out)[2] >> close;
    return static_cast<bool>(in) && open == '(' && first == ',' && second == ',' && close == ')';
}

/// Splits into words; parenthesised ones stay whole.
std::vector<std::string> words_of(const std::string& text) {
    std::vector<std::string> out;
    std::string word;
    bool in_brackets = false;
    for (const char c : text + " ") {
        in_brackets = c == '(' || (in_brackets && c != ')');
        if (c != ' ' && c != '\t') {
            word += c;
        } else if (!in_brackets && !word.empty()) {
            out.push_back(std::move(word));
            word.clear();
        }
    }
    return out;
}

/// In lower case, with one blank between words.
std::string plain_words(const std::string& text) {
    std::string out;
    for (const std::string& word : words_of(lower_ascii(text)))
        out += (out.empty() ? "" : " ") + word;
    return out;
}

/// Reads an integer, at least `least`; empty if the field is missing under both its names.
Result<int64_t> skip_of(const texture::NrrdHeader& header, const char* name, const char* other,
                        int64_t least) {
    std::string text = header.field(name);
    if (text.empty()) text = header.field(other);
    if (text.empty()) return int64_t{0};
    int64_t value = 0;
    const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool blank =
        text.find_first_not_of(" \t", static_cast<size_t>(end - text.data())) == std::string::npos;
    if (wrong != std::errc() || !blank || value < least) {
        return user_error(fmt::format(messages::kNotAWholeNumberFrom, name, text, least));
    }
    return value;
}

/// What precedes the numbers, after the header or from the start of the data file.
struct Skipped {
    int64_t lines = 0;  ///< first, in the file as stored
    int64_t bytes = 0;  ///< then, of decompressed data; -1: all before the numbers
};

Result<Skipped> skipped_by(const texture::NrrdHeader& header, bool raw) {
    const Result<int64_t> lines = skip_of(header, "line skip", "lineskip", 0);
    if (!lines) return lines.error();
    const Result<int64_t> bytes = skip_of(header, "byte skip", "byteskip", -1);
    if (!bytes) return bytes.error();
    if (*bytes < 0 && !raw) {
        return user_error(messages::kByteSkipOfPacked);
    }
    if (*bytes < 0 && *lines > 0) {
        return user_error(messages::kBothSkips);
    }
    return Skipped{*lines, *bytes};
}

/// Returns the offset of line number `lines`, from 0.
Result<int64_t> behind_lines(const InputFile& file, int64_t begin, int64_t lines) {
    std::vector<char> buffer(kAtOnce);
    for (int64_t at = begin; lines > 0;) {
        const Result<size_t> got = file.read(at, buffer.data(), buffer.size());
        if (!got) return got.error();
        if (*got == 0) return user_error(messages::kFewerLinesThanSkip);
        size_t next = 0;
        while (lines > 0 && next < *got) {
            const auto* const end =
                static_cast<const char*>(std::memchr(buffer.data() + next, '\n', *got - next));
            next = end == nullptr ? *got : static_cast<size_t>(end - buffer.data()) + 1;
            lines -= end != nullptr;
        }
        at += static_cast<int64_t>(next);
        if (lines == 0) return at;
    }
    return begin;
}

/// What the header says of its axes.
struct Axes {
    std::vector<int64_t> sizes;
    std::vector<std::string> directions, spacings, kinds;  ///< empty, or one for each axis
};

Result<Axes> read_axes(const texture::NrrdHeader& header) {
    Axes axes;
    for (const std::string& size : words_of(header.field("sizes")))
        axes.sizes.push_back(std::strtoll(size.c_str(), nullptr, 10));
    const size_t count = axes.sizes.size();
    if (count != 3 && count != 4) {
        return user_error(fmt::format(messages::kNrrdDimensions, count));
    }
    const auto each = [&](const char* name, std::vector<std::string>* out) -> Result<void> {
        *out = words_of(header.field(name));
        if (out->empty() || out->size() == count) return {};
        return user_error(fmt::format(messages::kEntriesForAxes, name, out->size(), count));
    };
    Result<void> read = each("space directions", &axes.directions);
    if (read) read = each("spacings", &axes.spacings);
    if (read) read = each("kinds", &axes.kinds);
    for (std::string& kind : axes.kinds)
        kind = lower_ascii(kind);
    if (!read) return read.error();
    return axes;
}

/// Returns whether an axis lies in space, as far as the header says.
std::optional<bool> is_in_space(const Axes& axes, size_t axis) {
    if (!axes.directions.empty()) return axes.directions[axis].starts_with('(');
    if (!axes.kinds.empty()) {
        const std::string& kind = axes.kinds[axis];
        if (kind == "domain" || kind == "space") return true;
        if (kind != "???" && kind != "none") return false;
    }
    if (!axes.spacings.empty() && lower_ascii(axes.spacings[axis]) == "nan") return false;
    return std::nullopt;
}

/// Finds which axis is that of channels; -1 where there is none. What the header leaves open is the
/// first, or the last where the first is too long; tells where it could be either.
Result<int> channel_axis(const Axes& axes) {
    constexpr int64_t kMostChannels = 4;
    const int count = static_cast<int>(axes.sizes.size());
    int found = -1, unknown = 0;
    for (int a = 0; a < count; ++a) {
        const std::optional<bool> in_space = is_in_space(axes, static_cast<size_t>(a));
        unknown += in_space ? 0 : 1;
        if (in_space.value_or(true)) continue;
        if (found >= 0 || count == 3)
            return user_error(
                fmt::format(messages::kAxesInSpace, count - (found >= 0 ? 2 : 1), count));
        found = a;
    }
    if (count == 3 || found >= 0) return found;
    if (unknown == 0) return user_error(messages::kFourAxesInSpace);
    const bool both = axes.sizes.front() <= kMostChannels && axes.sizes.back() <= kMostChannels &&
                      !is_in_space(axes, 0) && !is_in_space(axes, axes.sizes.size() - 1);
    if (both) tell(fmt::format(messages::kAxesUnknown, axes.sizes.front(), axes.sizes.back()));
    return axes.sizes.front() > kMostChannels && axes.sizes.back() <= kMostChannels ? count - 1 : 0;
}

/// The size in mm of the unit that the header names for its space.
Result<double> header_unit_mm(const texture::NrrdHeader& header,
                              const texture::VolumeOptions& options) {
    if (!options.unit.empty()) return unit_mm(options);
    std::string names = header.field("space units");
    if (names.empty()) names = header.field("units");
    std::string unit;
    for (const std::string& word : words_of(names)) {
        std::string name;
        std::remove_copy(word.begin(), word.end(), std::back_inserter(name), '"');
        if (name.empty() || name == "???" || name == "none") continue;
        if (!unit.empty() && unit != name)
            return user_error(fmt::format("{}{} and {}", messages::kSeveralUnits, unit, name),
                              messages::kSeveralUnitsHelp);
        unit = name;
    }
    if (unit.empty()) return 1.0;
    if (const std::optional<double> known = texture::named_length_mm(unit)) return *known;
    return user_error(fmt::format(messages::kUnknownUnit, unit), messages::kUnknownUnitHelp);
}

/// Parses a step, without what rounding left of other axes.
bool step_of(const std::string& word, Vec3d* out) {
    constexpr double kRounding = 1e-6;  // of its length, as writers print six digits
    std::array<double, 3> v{};
    if (!vector_of(word, &v)) return false;
    *out = {v[0], v[1], v[2]};
    const double least = kRounding * length(*out);
    for (int k = 0; k < 3; ++k) {
        if (std::fabs((*out)[k]) <= least) (*out)[k] = 0;
    }
    return std::isfinite(least);
}

/// Turns a frame of a left-handed space into one of a right-handed one, where the header says which.
Result<void> turn_left_handed(const texture::NrrdHeader& header, const std::string& name,
                              std::optional<GridFrame>* frame) {
    const std::string space = lower_ascii(header.field("space"));
    if (space == "3d-left-handed")
        return user_error(fmt::format(messages::kLeftHanded, space), messages::kLeftHandedHelp);
    if (!*frame || (space != "left-anterior-superior" && space != "las")) return {};
    tell(fmt::format(messages::kTurnedToBack, name));
    for (Vec3d& step : (*frame)->steps)
        step.y = 0 - step.y;
    (*frame)->first.y = 0 - (*frame)->first.y;
    return {};
}

/// Reads where its texels lie; nothing where the header does not say. Without an origin it begins at 0.
Result<std::optional<GridFrame>> read_frame(const texture::NrrdHeader& header, const Axes& axes,
                                            int channels, double unit) {
    GridFrame frame;
    int axis = 0;  // in space
    for (int a = 0; a < static_cast<int>(axes.sizes.size()); ++a) {
        if (a == channels) continue;
        const auto i = static_cast<size_t>(a);
        Vec3d& step = frame.steps[static_cast<size_t>(axis)];
        if (!axes.directions.empty()) {
            if (!step_of(axes.directions[i], &step))
                return user_error(messages::kSpaceDirectionsMalformed);
            step = step * unit;
        } else if (!axes.spacings.empty()) {
            step[axis] = std::strtod(axes.spacings[i].c_str(), nullptr) * unit;
            if (!(step[axis] > 0)) return user_error(messages::kSpacingsNotAboveZero);
        } else {
            step[axis] = unit;
        }
        ++axis;
    }
    const auto origin = words_of(header.field("space origin"));
    std::array<double, 3> at{};
    if (!origin.empty() && (origin.size() != 1 || !vector_of(origin[0], &at)))
        return user_error(messages::kSpaceOriginMalformed);
    frame.first = Vec3d{at[0], at[1], at[2]} * unit;
    if (axes.directions.empty() && axes.spacings.empty() && origin.empty() && unit == 1)
        return std::optional<GridFrame>{};
    return std::optional<GridFrame>(frame);
}

/// Opens the numbers, which stand behind the header or in files of their own.
Result<void> open_numbers(InputFile source, const fs::path& file, const texture::NrrdHeader& header,
                          const texture::ReadLimits& limits, StoredGrid* grid) {
    const std::string encoding = lower_ascii(header.field("encoding"));
    grid->packed = encoding == "gzip" || encoding == "gz";
    grid->text = encoding == "ascii" || encoding == "text" || encoding == "txt";
    if (!grid->packed && !grid->text && encoding != "raw") {
        return user_error(fmt::format(messages::kUnknownEncoding, encoding));
    }
    const Result<Skipped> skipped = skipped_by(header, !grid->packed && !grid->text);
    if (!skipped) return skipped.error();
    const std::string name = header.data_file();
    Result<std::vector<std::string>> names = texture::read_data_files(name, header.listed);
    if (!names) return names.error();
    const int64_t share = grid->bytes() / static_cast<int64_t>(names->size());
    const auto open = [share, packed = grid->packed, skipped = *skipped](
                          InputFile data, int64_t begin) -> Result<std::unique_ptr<ByteStream>> {
        const Result<int64_t> line = behind_lines(data, begin, skipped.lines);
        if (!line) return line.error();
        begin = skipped.bytes < 0 ? std::max(*line, data.bytes() - share) : *line;
        return packed ? open_packed_bytes(std::move(data), begin)
                      : open_bytes(std::move(data), begin);
    };
    const int64_t skip = std::max<int64_t>(skipped->bytes, 0);
    if (names->size() > 1 || texture::is_file_list(name)) {
        const auto open_one = [open, skip](InputFile data) {
            Result<std::unique_ptr<ByteStream>> stream = open(std::move(data), 0);
            if (stream) {
                if (Result<void> done = (*stream)->skip(skip); !done) stream = done.error();
            }
            return stream;
        };
        return chain_data_files(file, std::move(source), *names, limits, open_one, grid);
    }
    if (!name.empty()) {
        Result<InputFile> data = texture::open_data_file(file, names->front(), limits);
        if (!data) return data.error();
        source = std::move(*data);
    }
    Result<std::unique_ptr<ByteStream>> stream =
        open(std::move(source), name.empty() ? header.begin : 0);
    if (!stream) return stream.error();
    grid->stream = std::move(*stream);
    grid->skip = skip;
    return {};
}

/// Tells what the file says beside its numbers and their place, and what is made of it nowhere.
void tell_left_out(const texture::NrrdHeader& header, bool integers, const std::string& name) {
    const auto says = [&](const char* field, const char* other) {
        return !header.field(field).empty() || !header.field(other).empty();
    };
    if (says("axis mins", "axismins") && header.field("space origin").empty())
        tell(fmt::format(messages::kAxisMinsLeftOut, name));
    if (says("axis maxs", "axismaxs") && !says("space directions", "spacings"))
        tell(fmt::format(messages::kAxisMaxsLeftOut, name));
    if (integers && (says("old min", "oldmin") || says("old max", "oldmax")))
        tell(fmt::format(messages::kOldRangeLeftOut, name));
}

}  // namespace

MadeReader open_nrrd(const fs::path& file, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits) {
    Result<InputFile> source = InputFile::open(file);
    if (!source) return source.error();
    const Result<texture::NrrdHeader> read = texture::read_nrrd_header(*source);
    if (!read) return read.error();
    const texture::NrrdHeader& header = *read;
    StoredGrid grid;
    if (!number_format(plain_words(header.field("type")), &grid.format))
        return user_error(fmt::format(messages::kUnknownNumberType, header.field("type")));
    const std::string endian = lower_ascii(header.field("endian"));
    grid.format.swapped = endian == "big";
    const Result<Axes> axes = read_axes(header);
    if (!axes) return axes.error();
    const Result<int> channels = channel_axis(*axes);
    if (!channels) return channels.error();
    std::vector<int64_t> sides = axes->sizes;
    if (*channels >= 0) sides.erase(sides.begin() + *channels);
    const int64_t channel_count = *channels < 0 ? 1 : axes->sizes[static_cast<size_t>(*channels)];
    grid.channel_axis = std::max(*channels, 0);
    if (*channels >= 0 && !axes->kinds.empty() && channel_count > 1 &&
        axes->kinds[static_cast<size_t>(*channels)] == "time") {
        return user_error(fmt::format(messages::kStepsOfTime, channel_count));
    }
    if (Result<void> fits = set_sides({sides[0], sides[1], sides[2]}, channel_count, &grid); !fits)
        return fits.error();
    const Result<double> unit = header_unit_mm(header, options);
    if (!unit) return unit.error();
    Result<std::optional<GridFrame>> frame = read_frame(header, *axes, *channels, *unit);
    if (!frame) return frame.error();
    if (Result<void> turned = turn_left_handed(header, file.filename().string(), &*frame); !turned)
        return turned.error();
    tell_left_out(header, grid.format.kind != NumberFormat::Kind::kFloat, file.filename().string());
    if (Result<void> opened = open_numbers(std::move(*source), file, header, limits, &grid);
        !opened)
        return opened.error();
    if (!grid.text && grid.format.bytes > 1 && endian != "big" && endian != "little")
        return user_error(fmt::format(messages::kNoEndian, grid.format.bytes));
    MadeReader reader = open_stored_grid(std::move(grid), limits);
    if (!reader || !*frame) return reader;
    MadeReader placed = place_reader(std::move(*reader), **frame, options, limits);
    if (placed && header.field("space origin").empty()) (*placed)->origin.reset();
    return placed;
}

}  // namespace openfab::tools
