// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/stored_grid.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include "base/at.h"
#include "base/units.h"
#include "texture/nrrd_header.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kAtOnce = 1 << 16;

/// Reads the numbers of a grid in the file's order.
class GridNumbers {
  public:
    explicit GridNumbers(StoredGrid grid) : grid_(std::move(grid)) {}

    const StoredGrid& grid() const { return grid_; }
    /// How many numbers are best read at once.
    int64_t step() const { return static_cast<int64_t>(kAtOnce) / grid_.format.bytes; }

    /// Reads `count` numbers, at most step().
    Result<void> next(float* out, int64_t count) {
        return grid_.text ? words(out, count) : numbers(out, count);
    }
    /// Whether it was rounded to a float.
    bool rounded() const { return rounded_; }
    /// Checks what follows the last number: only the end of compressed data shows that it is complete.
    Result<void> end() {
        if (!grid_.packed || grid_.goes_on) return {};
        char more = 0;
        const Result<size_t> got = grid_.stream->next(&more, 1);
        if (!got) return got.error();
        return *got == 0 || grid_.text ? Result<void>()
                                       : user_error(messages::kCompressedOfOtherSize);
    }

  private:
    float scaled(double value) const {
        return static_cast<float>(value * grid_.slope + grid_.intercept);
    }

    Result<void> numbers(float* out, int64_t count) {
        const NumberFormat& format = grid_.format;
        const auto bytes = static_cast<size_t>(count * format.bytes);
        const Result<size_t> got = grid_.stream->next(buffer_.data(), bytes);
        if (!got) return got.error();
        if (*got < bytes)
            return user_error(grid_.packed ? messages::kCompressedOfOtherSize
                                           : messages::kCutShort);
        const bool as_it_is = grid_.slope == 1 && grid_.intercept == 0;
        for (int64_t i = 0; i < count; ++i) {
            const char* const at = buffer_.data() + i * format.bytes;
            out[i] = as_it_is ? read_number(format, at) : scaled(read_number_exactly(format, at));
        }
        if (as_it_is && format.kind != NumberFormat::Kind::kFloat && format.bytes >= 4) {
            for (int64_t i = 0; i < count && !rounded_; ++i)
                rounded_ = is_rounded(format, buffer_.data() + i * format.bytes);
        }
        return {};
    }

    Result<void> words(float* out, int64_t count) {
        const double largest = unit_of(grid_.format);
        for (int64_t i = 0; i < count; ++i) {
            std::string word;
            if (Result<void> found = next_word(&word); !found) return found;
            char* end = nullptr;
            const double value = std::strtod(word.c_str(), &end);
            if (*end != '\0') return user_error(fmt::format(messages::kNotANumber, word));
            out[i] = scaled(value / largest);
        }
        return {};
    }

    Result<void> next_word(std::string* word) {
        constexpr size_t kLongest = 64;
        constexpr std::string_view kBlanks = " \t\r\n,";
        for (;; ++at_) {
            if (at_ == held_) {
                const Result<size_t> got = grid_.stream->next(buffer_.data(), buffer_.size());
                if (!got) return got.error();
                held_ = *got;
                at_ = 0;
                if (held_ == 0)
                    return word->empty() ? Result<void>(user_error(messages::kCutShort)) : Ok{};
            }
            const char c = buffer_[at_];
            if (kBlanks.find(c) == std::string_view::npos) {
                *word += c;
                if (word->size() > kLongest)
                    return user_error(fmt::format(messages::kNotANumberLong, *word));
            } else if (!word->empty()) {
                return {};
            }
        }
    }

    StoredGrid grid_;
    std::vector<char> buffer_ = std::vector<char>(kAtOnce);
    size_t held_ = 0, at_ = 0;
    bool rounded_ = false;
};

/// Channels first: slice by slice.
class SliceReader final : public VolumeReader {
  public:
    explicit SliceReader(StoredGrid grid) : numbers_(std::move(grid)) {}

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const int64_t count = slice_floats();
        for (int64_t begin = 0; begin < count; begin += numbers_.step()) {
            const int64_t n = std::min(numbers_.step(), count - begin);
            if (Result<void> read = numbers_.next(out + begin, n); !read) return read;
            wrote(4 * n);
        }
        rounded = numbers_.rounded();
        return z + 1 == size.z ? numbers_.end() : Result<void>();
    }

  private:
    GridNumbers numbers_;
};

/// Channels anywhere else: the whole is read before its first slice is known.
class WholeReader final : public VolumeReader {
  public:
    explicit WholeReader(StoredGrid grid) : numbers_(std::move(grid)) {}

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        if (z == 0) {
            if (Result<void> read = read_all(); !read) return read;
        }
        const int64_t count = slice_floats();
        std::copy_n(values_.begin() + z * count, count, out);
        wrote(4 * count);
        if (z + 1 == size.z) values_ = {};
        return {};
    }

  private:
    Result<void> read_all() {
        const int64_t count = numbers_.grid().numbers();
        values_.resize(static_cast<size_t>(count));
        int64_t inner = 1;  // texels before the next channel
        for (int a = 0; a < numbers_.grid().channel_axis; ++a)
            inner *= size[a];
        std::vector<float> some(static_cast<size_t>(numbers_.step()));
        int64_t texel = 0, first = 0, channel = 0;  // first: of the block of `inner` texels
        for (int64_t begin = 0; begin < count; begin += numbers_.step()) {
            const int64_t n = std::min(numbers_.step(), count - begin);
            if (Result<void> read = numbers_.next(some.data(), n); !read) return read;
            for (int64_t i = 0; i < n; ++i) {
                values_[static_cast<size_t>((first + texel) * channels + channel)] = at(some, i);
                if (++texel < inner) continue;
                texel = 0;
                if (++channel < channels) continue;
                channel = 0;
                first += inner;
            }
        }
        rounded = numbers_.rounded();
        return numbers_.end();
    }

    GridNumbers numbers_;
    std::vector<float> values_;
};

}  // namespace

Result<void> set_sides(const std::array<int64_t, 3>& sides, int64_t channels, StoredGrid* grid) {
    constexpr int64_t kMostNumbers = int64_t{1} << 32;
    if (channels < 1 || channels > 4)
        return user_error(fmt::format(messages::kImageChannels, channels));
    int64_t numbers = channels;
    for (size_t a = 0; a < 3; ++a) {
        if (sides[a] < 1 || sides[a] > 16384)
            return user_error(fmt::format(messages::kSideNotPossible, sides[a]));
        numbers *= sides[a];
        if (numbers > kMostNumbers) return user_error(messages::kTooLarge);
        grid->size[static_cast<int>(a)] = static_cast<int32_t>(sides[a]);
    }
    grid->channels = static_cast<int32_t>(channels);
    return {};
}

Result<void> chain_data_files(const std::filesystem::path& header, InputFile source,
                              const std::vector<std::string>& names,
                              const texture::ReadLimits& limits, const OpenDataFile& open,
                              StoredGrid* grid) {
    if (grid->text) return user_error(messages::kTextInSeveralFiles);
    const auto count = static_cast<int64_t>(names.size());
    if (grid->numbers() % count != 0)
        return user_error(fmt::format(messages::kUnequalFiles, count));
    std::vector<OpenPart> parts;
    for (const std::string& name : names) {
        parts.emplace_back([=]() -> Result<std::unique_ptr<ByteStream>> {
            Result<InputFile> file = texture::open_data_file(header, name, limits);
            if (!file) return file.error();
            return open(std::move(*file));
        });
    }
    Result<std::unique_ptr<ByteStream>> chained =
        chain_bytes(std::move(source), std::move(parts), grid->bytes() / count);
    if (!chained) return chained.error();
    grid->stream = std::move(*chained);
    grid->goes_on = true;  // only the parts' ends are known
    return {};
}

MadeReader open_stored_grid(StoredGrid grid, const texture::ReadLimits& limits) {
    const int64_t left = grid.stream->left();
    if (left < grid.bytes() || left - grid.bytes() < grid.skip)
        return user_error(grid.packed ? messages::kCompressedOfOtherSize : messages::kCutShort);
    // Everything skipped must be decompressed.
    if (grid.packed && grid.skip > limits.memory_bytes) {
        return user_error(fmt::format(messages::kPackedBehindTooMuch, format_bytes(grid.skip),
                                      format_bytes(limits.memory_bytes)));
    }
    const int64_t behind = left - grid.bytes() - grid.skip;
    if (behind > 0 && !grid.packed && !grid.text && !grid.goes_on)
        tell(fmt::format(messages::kBytesBehind, behind));
    if (Result<void> skipped = grid.stream->skip(grid.skip); !skipped) return skipped.error();
    const bool is_first = grid.channel_axis == 0 || grid.channels == 1;
    // Beside it lies what it is put in order in (placed_grid.h).
    if (Result<void> fits = check_memory(is_first ? 0 : 8 * grid.numbers(), limits.memory_bytes);
        !fits)
        return fits.error();
    const Vec3i size = grid.size;
    const int32_t channels = grid.channels;
    const bool no_nan = grid.format.kind != NumberFormat::Kind::kFloat;
    std::unique_ptr<VolumeReader> reader;
    if (is_first) {
        reader = std::make_unique<SliceReader>(std::move(grid));
    } else {
        reader = std::make_unique<WholeReader>(std::move(grid));
    }
    reader->size = size;
    reader->channels = channels;
    reader->no_nan = no_nan;
    return reader;
}

}  // namespace openfab::tools
