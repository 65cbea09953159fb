// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NPY and .cube, and what NRRD shares with them.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "base/input_file.h"
#include "base/json.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "texture/nrrd_header.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/messages.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr int64_t kMostTexels = int64_t{1} << 30;

template <typename T>
T load(const char* at, bool swapped) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, at, sizeof(T));
    if (swapped) std::reverse(bytes, bytes + sizeof(T));
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return value;
}

double integer(const NumberFormat& f, const char* at) {
    const bool sign = f.kind == NumberFormat::Kind::kSigned;
    switch (f.bytes) {
        case 1:
            return sign ? static_cast<double>(load<int8_t>(at, false))
                        : static_cast<double>(load<uint8_t>(at, false));
        case 2:
            return sign ? static_cast<double>(load<int16_t>(at, f.swapped))
                        : static_cast<double>(load<uint16_t>(at, f.swapped));
        case 4:
            return sign ? static_cast<double>(load<int32_t>(at, f.swapped))
                        : static_cast<double>(load<uint32_t>(at, f.swapped));
        default:
            return sign ? static_cast<double>(load<int64_t>(at, f.swapped))
                        : static_cast<double>(load<uint64_t>(at, f.swapped));
    }
}

/// An array of numbers in any order of axes.
class ArrayReader final : public VolumeReader {
  public:
    std::optional<InputFile> file;
    std::string bytes;
    int64_t begin = 0;
    NumberFormat format;
    std::array<int64_t, 4> strides{};  ///< of x, y, z and channel, in numbers

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        if (bytes.empty()) {
            if (Result<void> loaded = load_all(); !loaded) return loaded;
        }
        for (int64_t y = 0; y < size.y; ++y) {
            for (int64_t x = 0; x < size.x; ++x) {
                for (int64_t c = 0; c < channels; ++c) {
                    const int64_t index =
                        x * strides[0] + y * strides[1] + z * strides[2] + c * strides[3];
                    const char* const at = bytes.data() + index * format.bytes;
                    *out++ = read_number(format, at);
                    rounded = rounded || is_rounded(format, at);
                }
            }
            wrote(4 * row_floats());
        }
        return Ok{};
    }

  private:
    /// At most two thirds of the size of the pyramid, for which memory has been checked by now.
    /// Read whole, since the order of axes may need any element at any time.
    Result<void> load_all() {
        bytes.resize(static_cast<size_t>(slice_floats() * size.z * format.bytes));
        const Result<size_t> got = file->read(begin, bytes.data(), bytes.size());
        if (!got) return got.error();
        return *got == bytes.size() ? Result<void>() : user_error(messages::kCutShort);
    }
};

/// Returns the value of `key` in the header's dictionary.
std::string entry(const std::string& header, const std::string& key) {
    const size_t at = header.find("'" + key + "'");
    if (at == std::string::npos) return {};
    const size_t colon = header.find(':', at);
    if (colon == std::string::npos) return {};
    const size_t first = header.find_first_not_of(' ', colon + 1);
    if (first == std::string::npos) return {};
    const size_t end =
        header[first] == '(' ? header.find(')', first) : header.find_first_of(",}", first);
    return end == std::string::npos ? std::string{} : header.substr(first, end - first);
}

std::vector<int64_t> whole_numbers(const std::string& text) {
    std::vector<int64_t> out;
    const char* at = text.data();
    const char* end = at + text.size();
    while (at != end) {
        int64_t value = 0;
        const auto [next, error] = std::from_chars(at, end, value);
        if (error == std::errc{}) {
            out.push_back(value);
            at = next;
        } else {
            ++at;
        }
    }
    return out;
}

bool npy_format(const std::string& descr, NumberFormat* out) {
    if (descr.size() < 5) return false;
    const char order = descr[1], kind = descr[2];
    out->swapped = order == '>';
    out->bytes = descr[3] - '0';
    if (kind == 'f') {
        out->kind = NumberFormat::Kind::kFloat;
        return out->bytes == 2 || out->bytes == 4 || out->bytes == 8;
    }
    if (kind != 'u' && kind != 'i' && kind != 'b') return false;
    out->kind = kind == 'u' ? NumberFormat::Kind::kUnsigned : NumberFormat::Kind::kSigned;
    return out->bytes == 1 || out->bytes == 2 || out->bytes == 4 || out->bytes == 8;
}

}  // namespace

double small_float(uint32_t bits, int exponent_bits, int fraction_bits) {
    const int most = (1 << exponent_bits) - 1, bias = most / 2;
    const int exponent = static_cast<int>(bits >> fraction_bits) & most;
    const auto fraction = static_cast<int>(bits & ((1U << fraction_bits) - 1));
    double value = 0;
    if (exponent == most) {
        value = fraction == 0 ? std::numeric_limits<double>::infinity()
                              : std::numeric_limits<double>::quiet_NaN();
    } else {
        const int leading = exponent == 0 ? 0 : 1 << fraction_bits;
        value = std::ldexp(fraction + leading, std::max(exponent, 1) - bias - fraction_bits);
    }
    return (bits >> (exponent_bits + fraction_bits) & 1) != 0 ? -value : value;
}

float read_number(const NumberFormat& format, const char* at) {
    return static_cast<float>(read_number_exactly(format, at));
}

double read_number_exactly(const NumberFormat& format, const char* at) {
    if (format.kind != NumberFormat::Kind::kFloat) return integer(format, at) / unit_of(format);
    if (format.bytes == 2) return small_float(load<uint16_t>(at, format.swapped), 5, 10);
    return format.bytes == 4 ? static_cast<double>(load<float>(at, format.swapped))
                             : load<double>(at, format.swapped);
}

bool is_rounded(const NumberFormat& format, const char* at) {
    if (format.kind == NumberFormat::Kind::kFloat || format.bytes < 4) return false;
    const double value = integer(format, at);
    if (static_cast<double>(static_cast<float>(value)) != value) return true;
    // Of 64 bits, a double may have lost what a float would.
    constexpr double kExact = 9007199254740992;  // 2^53
    if (format.bytes < 8 || std::abs(value) < kExact) return false;
    const uint64_t bits = load<uint64_t>(at, format.swapped);
    const bool negative = format.kind == NumberFormat::Kind::kSigned && value < 0;
    return std::bit_width(negative ? 0 - bits : bits) - std::countr_zero(bits) >
           std::numeric_limits<float>::digits;
}

double unit_of(const NumberFormat& format) {
    if (format.kind != NumberFormat::Kind::kUnsigned || format.as_stored) return 1;
    return format.bytes == 1 ? 255 : format.bytes == 2 ? 65535 : 1;
}

namespace {

/// Places the array of a print by the file that the print wrote beside it. JSON of others is not looked at.
Result<void> place_array(const fs::path& file, const texture::ReadLimits& limits,
                         VolumeReader* reader) {
    constexpr int64_t kMostBytes = 4 << 20;
    const std::string beside = file.filename().string() + ".json";
    if (!fs::exists(file.parent_path() / beside)) return {};
    const Result<InputFile> opened = texture::open_data_file(file, beside, limits);
    if (!opened) return opened.error();
    const Result<std::string> text = opened->read_all(kMostBytes);
    if (!text) return text.error();
    const Result<JsonValue> json = parse_json(*text, beside, limits.memory_bytes);
    if (!json) return {};
    const JsonMember* const format = json->find("format");
    if (format == nullptr || format->value.text != "openfab-array") return {};
    const auto three = [&](const char* key, std::array<double, 3>* out) {
        const JsonMember* const m = json->find(key);
        if (m == nullptr || m->value.items.size() != out->size()) return false;
        for (size_t a = 0; a < out->size(); ++a)
            (*out)[a] = m->value.items[a].number;
        return true;
    };
    std::array<double, 3> shape{}, pitch{}, origin{};
    const Vec3i& size = reader->size;
    if (!three("shape_zyx", &shape) || !three("pitch_mm", &pitch) || !three("origin_mm", &origin) ||
        shape[0] != size.z || shape[1] != size.y || shape[2] != size.x ||
        !std::ranges::all_of(pitch, [](double h) { return std::isfinite(h) && h > 0; }))
        return user_error(fmt::format(messages::kOtherArray, beside), messages::kOtherArrayHelp);
    // The place is that of the whole print, of which an array may have some slices.
    if (const JsonMember* const first = json->find("first_slice_z"))
        origin[2] += first->value.number * pitch[2];
    reader->spacing = pitch;
    reader->origin = origin;
    return {};
}

}  // namespace

MadeReader open_npy(const fs::path& file, const texture::ReadLimits& limits) {
    Result<InputFile> opened = InputFile::open(file);
    if (!opened) return opened.error();
    constexpr int64_t kLongestHeader = 1 << 20;
    std::string bytes(static_cast<size_t>(std::min(opened->bytes(), kLongestHeader)), '\0');
    const Result<size_t> got = opened->read(0, bytes.data(), bytes.size());
    if (!got) return got.error();
    bytes.resize(*got);
    if (bytes.size() < 12 || bytes.compare(0, 6, "\x93NUMPY") != 0)
        return user_error(messages::kNotNpy);
    const bool long_header = bytes[6] >= 2;
    const size_t start = long_header ? 12 : 10;
    const size_t length = long_header ? load<uint32_t>(bytes.data() + 8, false)
                                      : load<uint16_t>(bytes.data() + 8, false);
    if (length > bytes.size() - start) return user_error(messages::kCutShort);
    const std::string header = bytes.substr(start, length);
    auto reader = std::make_unique<ArrayReader>();
    const std::string descr = entry(header, "descr");
    if (!npy_format(descr, &reader->format))
        return user_error(fmt::format(messages::kUnknownNumberKind, descr));
    reader->no_nan = reader->format.kind != NumberFormat::Kind::kFloat;
    const std::vector<int64_t> shape = whole_numbers(entry(header, "shape"));
    if (shape.size() != 3 && shape.size() != 4)
        return user_error(fmt::format(messages::kNpyDimensions, shape.size()));
    int64_t numbers = 1;
    for (const int64_t n : shape) {
        if (n < 1 || n > 16384) return user_error(fmt::format(messages::kSideNotPossible, n));
        numbers *= n;
        if (numbers > 4 * kMostTexels) return user_error(messages::kTooLarge);
    }
    reader->size = {static_cast<int32_t>(shape[2]), static_cast<int32_t>(shape[1]),
                    static_cast<int32_t>(shape[0])};
    reader->channels = shape.size() == 4 ? static_cast<int32_t>(shape[3]) : 1;
    // Strides in the file: the last index varies fastest, in Fortran order the first.
    std::vector<int64_t> step(shape.size(), 1);
    if (entry(header, "fortran_order") == "True") {
        for (size_t k = 1; k < shape.size(); ++k)
            step[k] = step[k - 1] * shape[k - 1];
    } else {
        for (size_t k = shape.size() - 1; k-- > 0;)
            step[k] = step[k + 1] * shape[k + 1];
    }
    reader->strides = {step[2], step[1], step[0], shape.size() == 4 ? step[3] : 0};
    reader->begin = static_cast<int64_t>(start + length);
    if (numbers * reader->format.bytes > opened->bytes() - reader->begin)
        return user_error(messages::kCutShort);
    if (Result<void> placed = place_array(file, limits, reader.get()); !placed)
        return placed.error();
    reader->file.emplace(std::move(*opened));
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

namespace {

class CubeReader final : public VolumeReader {
  public:
    std::vector<float> values;
    int64_t rows = 0;  ///< of colours, including excess ones
    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const int64_t count = slice_floats();
        std::copy_n(values.begin() + z * count, count, out);
        wrote(4 * count);
        return Ok{};
    }
};

/// Removes and returns the next word of a line.
std::string_view take_word(std::string_view* line) {
    constexpr std::string_view kBlanks = " \t\r\v\f";
    line->remove_prefix(std::min(line->find_first_not_of(kBlanks), line->size()));
    const std::string_view word = line->substr(0, line->find_first_of(kBlanks));
    line->remove_prefix(word.size());
    return word;
}

/// Whether nothing but a comment is left of a line.
bool ends(std::string_view line) {
    const std::string_view word = take_word(&line);
    return word.empty() || word[0] == '#';
}

/// Parses as many numbers of a line as fit.
template <size_t count>
bool take_numbers(std::string_view* line, std::array<double, count>* out) {
    return std::all_of(out->begin(), out->end(),
                       [&](double& value) { return scan_number(take_word(line), &value).empty(); });
}

}  // namespace

MadeReader open_cube(const fs::path& file, const texture::ReadLimits& limits) {
    constexpr int64_t kLongestSide = 256;
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return opened.error();
    // Limits for its text and for the parsed table.
    constexpr int64_t kMostBytes = 3 * kLongestSide * kLongestSide * kLongestSide * 4;
    const int64_t needed = opened->bytes() + std::min(2 * opened->bytes(), kMostBytes);
    if (Result<void> fits = check_memory(needed, limits.memory_bytes); !fits) return fits.error();
    const Result<std::string> bytes = opened->read_all(opened->bytes());
    if (!bytes) return bytes.error();
    std::array<double, 3> low{0, 0, 0}, high{1, 1, 1};
    auto reader = std::make_unique<CubeReader>();
    reader->no_nan = true;
    bool has_domain = false, has_range = false;
    int64_t n = 0;
    if (const Complaint wide = not_utf8(*bytes); !wide.empty())
        return user_error(wide.what, wide.help);
    const PlainText plain(*bytes);
    std::string_view text = plain.text();
    for (int number = 1; !text.empty(); ++number) {
        std::string_view line = text.substr(0, text.find('\n'));
        text.remove_prefix(std::min(line.size() + 1, text.size()));
        const std::string_view word = take_word(&line);
        // OpenColorIO reads them in any case.
        const bool is_word = !word.empty() && std::isalpha(static_cast<unsigned char>(word[0]));
        const std::string key = is_word ? lower_ascii(std::string(word)) : std::string();
        if (word.empty() || word[0] == '#' || key == "title") continue;
        bool fine = true;
        if (key == "lut_3d_size") {
            std::array<double, 1> size{};
            fine = take_numbers(&line, &size);
            if (fine && !(size[0] >= 2 && size[0] <= kLongestSide))
                return user_error(fmt::format(messages::kLutSize, size[0], kLongestSide));
            n = fine ? static_cast<int64_t>(size[0]) : 0;
            // No more than there can be: a number takes two bytes of the text.
            reader->values.reserve(std::min(static_cast<size_t>(3 * n * n * n), bytes->size() / 2));
            fine = fine && size[0] == static_cast<double>(n);
        } else if (key == "domain_min" || key == "domain_max") {
            has_domain = true;
            fine = take_numbers(&line, key == "domain_min" ? &low : &high);
        } else if (key == "lut_3d_input_range") {
            has_range = true;
            std::array<double, 2> range{};
            fine = take_numbers(&line, &range);
            low.fill(range[0]);
            high.fill(range[1]);
        } else if (key == "lut_1d_size") {
            const bool shapes =
                n > 0 || lower_ascii(std::string(text)).find("lut_3d_size") != std::string::npos;
            return user_error(shapes ? messages::kLutHasShaper : messages::kLutIs1d);
        } else if (is_word) {
            return user_error(
                fmt::format(messages::kLutWord, number, printable(word.substr(0, 40))));
        } else {
            line = std::string_view(word.data(),
                                    static_cast<size_t>(line.data() + line.size() - word.data()));
            std::array<double, 3> rgb{};
            if (!take_numbers(&line, &rgb) || !ends(line))
                return user_error(fmt::format(messages::kLineNotThreeNumbers, number));
            if (n == 0) return user_error(fmt::format(messages::kColourBeforeLutSize, number));
            reader->rows += 1;
            if (reader->rows > n * n * n) continue;
            for (const double value : rgb)
                reader->values.push_back(static_cast<float>(value));
            continue;
        }
        if (!fine || !ends(line))
            return user_error(fmt::format(messages::kLineNotUnderstood, number));
        if (has_domain && has_range)
            return user_error(messages::kLutTwoDomains, messages::kLutTwoDomainsHelp);
    }
    if (n == 0) return user_error(messages::kNoLutSize);
    for (size_t a = 0; a < 3; ++a)
        if (!(high[a] > low[a])) return user_error(messages::kLutDomain);
    if (reader->rows != n * n * n) {
        return user_error(fmt::format(messages::kLutRows, reader->rows, n, n * n * n));
    }
    const auto side = static_cast<int32_t>(n);
    reader->size = {side, side, side};
    reader->channels = 3;
    reader->table = true;
    reader->origin.emplace();
    reader->spacing.emplace();
    for (size_t a = 0; a < 3; ++a) {
        // The ends of the domain are texel centers.
        const double step = (high[a] - low[a]) / static_cast<double>(n - 1);
        (*reader->spacing)[a] = step;
        (*reader->origin)[a] = low[a] - step / 2;
    }
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
