// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/array_numbers.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "base/base64.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

constexpr size_t kAtOnce = 1 << 16;

/// Takes bytes out of a buffer from `at` on, which `fill` fills anew where it is used up.
template <typename Buffer, typename Fill>
Result<void> take_from(const Buffer& held, size_t* at, char* out, size_t bytes, const Fill& fill) {
    while (bytes > 0) {
        if (*at == held.size()) {
            if (Result<void> more = fill(); !more) return more;
        }
        const size_t n = std::min(bytes, held.size() - *at);
        std::memcpy(out, held.data() + *at, n);
        *at += n;
        out += n;
        bytes -= n;
    }
    return {};
}

/// The bytes as they are stored, base64 decoded.
class Stored {
  public:
    explicit Stored(const ArrayBytes& from) : from_(from) {}

    /// Returns an upper bound of the bytes to come, at first.
    int64_t most() const {
        const int64_t stored = from_.file == nullptr ? static_cast<int64_t>(from_.text.size())
                                                     : from_.file->bytes() - from_.begin;
        return from_.base64 ? stored / 4 * 3 + 3 : stored;
    }
    Result<void> next(char* out, size_t bytes) {
        return take_from(held_, &at_, out, bytes, [this] { return fill(); });
    }

  private:
    Result<void> fill() {
        held_.clear();
        at_ = 0;
        while (held_.empty()) {
            std::string piece;
            if (from_.file == nullptr) {
                piece = from_.text.substr(0, kAtOnce);
                from_.text.remove_prefix(piece.size());
            } else {
                piece.resize(kAtOnce);
                const Result<size_t> got = from_.file->read(from_.begin, piece.data(), kAtOnce);
                if (!got) return got.error();
                piece.resize(*got);
                from_.begin += static_cast<int64_t>(*got);
            }
            if (piece.empty() || ended_) return user_error(messages::kArrayCutShort);
            if (!from_.base64) {
                held_ = std::move(piece);
                return {};
            }
            // Appended text ends with the element.
            const size_t end = piece.find('<');
            ended_ = end != std::string::npos;
            if (!decoder_.add(std::string_view(piece).substr(0, end), &held_))
                return user_error(messages::kNotBase64);
        }
        return {};
    }

    ArrayBytes from_;
    Base64Decoder decoder_;
    std::string held_;
    size_t at_ = 0;
    bool ended_ = false;
};

size_t bytes_of(ArrayType type) {
    constexpr std::array<size_t, 10> kBytes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
    return kBytes[static_cast<size_t>(type)];
}

template <typename T>
double load(const char* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
}

double number(ArrayType type, const char* at) {
    switch (type) {
        case ArrayType::kInt8:
            return load<int8_t>(at);
        case ArrayType::kUInt8:
            return load<uint8_t>(at);
        case ArrayType::kInt16:
            return load<int16_t>(at);
        case ArrayType::kUInt16:
            return load<uint16_t>(at);
        case ArrayType::kInt32:
            return load<int32_t>(at);
        case ArrayType::kUInt32:
            return load<uint32_t>(at);
        case ArrayType::kInt64:
            return load<int64_t>(at);
        case ArrayType::kUInt64:
            return load<uint64_t>(at);
        case ArrayType::kFloat32:
            return load<float>(at);
        case ArrayType::kFloat64:
            break;
    }
    return load<double>(at);
}

/// Whether an integer of 64 bits is not the double that it became.
bool is_lost(ArrayType type, const char* at, double as) {
    constexpr double kExact = 9007199254740992;  // 2^53
    if (!(std::abs(as) >= kExact)) return false;
    uint64_t bits = 0;
    if (type == ArrayType::kInt64 || type == ArrayType::kUInt64)
        std::memcpy(&bits, at, sizeof bits);
    if (type == ArrayType::kInt64 && as < 0) bits = 0 - bits;
    return std::bit_width(bits) - std::countr_zero(bits) > std::numeric_limits<double>::digits;
}

class ByteNumbers final : public ArrayNumbers {
  public:
    ByteNumbers(const ArrayBytes& bytes, ArrayType type, int64_t count)
        : bytes_(bytes), stored_(bytes), type_(type), total_(count * int64_t(bytes_of(type))) {}

    Result<void> open() {
        constexpr int64_t kDensest = 1032;  // of deflate: bytes per compressed byte
        const int64_t most = stored_.most();
        if (total_ > (bytes_.packed ? most * kDensest : most))
            return user_error(messages::kArrayCutShort);
        if (bytes_.header_bytes == 0) return {};
        Result<int64_t> first = header();
        if (!first) return first.error();
        if (!bytes_.packed) return *first == total_ ? Result<void>() : wrong_size();
        const Result<int64_t> block = header(), last = header();
        if (!block) return block.error();
        if (!last) return last.error();
        // The last block is a whole one where its size is 0.
        const int64_t whole = *last == 0 ? *first : std::max<int64_t>(*first - 1, 0);
        if (*first < 0 || *block < 0 || *last < 0 || *first > most / bytes_.header_bytes ||
            *last > *block || (whole > 0 && *block > total_ / whole) ||
            whole * *block + *last != total_)
            return wrong_size();
        block_ = static_cast<size_t>(*block);
        last_ = *last == 0 ? block_ : static_cast<size_t>(*last);
        for (int64_t i = 0; i < *first; ++i) {
            const Result<int64_t> size = header();
            if (!size) return size.error();
            if (*size < 0 || *size > most) return wrong_size();
            packed_sizes_.push_back(static_cast<size_t>(*size));
        }
        return {};
    }

    Result<void> next(double* out, size_t count) override {
        const size_t size = bytes_of(type_);
        std::array<char, 1024 * 8> buffer{};
        while (count > 0) {
            const size_t n = std::min<size_t>(count, 1024);
            if (Result<void> got = take(buffer.data(), n * size); !got) return got;
            for (size_t i = 0; i < n; ++i) {
                char* const at = buffer.data() + i * size;
                if (bytes_.swapped) std::reverse(at, at + size);
                *out = number(type_, at);
                has_lost_ = has_lost_ || is_lost(type_, at, *out);
                ++out;
            }
            count -= n;
        }
        return {};
    }

    bool are_integers() const override { return type_ < ArrayType::kFloat32; }
    bool has_lost() const override { return has_lost_; }

  private:
    static Result<void> wrong_size() { return user_error(messages::kArrayOfOtherSize); }

    Result<int64_t> header() {
        std::array<char, 8> at{};
        const auto size = static_cast<size_t>(bytes_.header_bytes);
        if (Result<void> got = stored_.next(at.data(), size); !got) return got.error();
        if (bytes_.swapped) std::reverse(at.begin(), at.begin() + bytes_.header_bytes);
        uint64_t value = 0;
        std::memcpy(&value, at.data(), sizeof value);
        return static_cast<int64_t>(value);
    }

    Result<void> take(char* out, size_t bytes) {
        if (!bytes_.packed) return stored_.next(out, bytes);
        return take_from(plain_, &at_, out, bytes, [this] { return unpack(); });
    }

    Result<void> unpack() {
        if (next_block_ == packed_sizes_.size()) return user_error(messages::kArrayCutShort);
        std::vector<char> packed(packed_sizes_[next_block_++]);
        if (Result<void> got = stored_.next(packed.data(), packed.size()); !got) return got;
        plain_.resize(next_block_ == packed_sizes_.size() ? last_ : block_);
        auto size = static_cast<uLongf>(plain_.size());
        const int done = uncompress(reinterpret_cast<Bytef*>(plain_.data()), &size,
                                    reinterpret_cast<const Bytef*>(packed.data()),
                                    static_cast<uLong>(packed.size()));
        if (done != Z_OK || size != plain_.size() || plain_.empty())
            return user_error(messages::kCompressedDataDamaged);
        at_ = 0;
        return {};
    }

    ArrayBytes bytes_;
    Stored stored_;
    ArrayType type_;
    int64_t total_;  ///< bytes of all numbers
    size_t block_ = 0, last_ = 0;
    std::vector<size_t> packed_sizes_;
    size_t next_block_ = 0;
    bool has_lost_ = false;
    std::vector<char> plain_;
    size_t at_ = 0;
};

/// Reads `nan`, which some fields have where they have no value.
bool is_nan(std::string_view word, double* out) {
    if (word.starts_with('-') || word.starts_with('+')) word.remove_prefix(1);
    if (lower_ascii(std::string(word.substr(0, 4))) != "nan") return false;
    *out = std::numeric_limits<double>::quiet_NaN();
    return true;
}

class TextNumbers final : public ArrayNumbers {
  public:
    explicit TextNumbers(std::string_view text) : text_(text) {}
    bool are_integers() const override { return integers_; }
    bool has_lost() const override { return has_lost_; }
    Result<void> next(double* out, size_t count) override {
        for (size_t i = 0; i < count; ++i) {
            const std::string_view word = take_word(&text_);
            if (word.empty()) return user_error(messages::kArrayCutShort);
            integers_ = integers_ && word.find_first_not_of("+-0123456789") == word.npos;
            if (read_decimal(word, out) == Decimal::kFine || is_nan(word, out)) {
                has_lost_ = has_lost_ || (integers_ && is_long(word, *out));
                ++out;
            } else {
                return user_error(fmt::format(messages::kNumberNotFinite, word.substr(0, 40)));
            }
        }
        return {};
    }

  private:
    /// Whether the double has other digits than the integer.
    static bool is_long(std::string_view word, double as) {
        constexpr size_t kExactDigits = 15;
        if (word.size() <= kExactDigits) return false;
        word.remove_prefix(std::min(word.find_first_not_of("+-0"), word.size()));
        return word != fmt::format("{:.0f}", std::abs(as));
    }

    std::string_view text_;
    bool integers_ = true;  ///< so far
    bool has_lost_ = false;
};

}  // namespace

Result<std::unique_ptr<ArrayNumbers>> open_array_bytes(const ArrayBytes& bytes, ArrayType type,
                                                       int64_t count) {
    auto out = std::make_unique<ByteNumbers>(bytes, type, count);
    if (Result<void> opened = out->open(); !opened) return opened.error();
    return std::unique_ptr<ArrayNumbers>(std::move(out));
}

Result<std::unique_ptr<ArrayNumbers>> open_array_text(std::string_view text, int64_t count) {
    // A digit and a blank for each.
    if (static_cast<int64_t>(text.size()) + 1 < 2 * count)
        return user_error(messages::kArrayCutShort);
    return std::unique_ptr<ArrayNumbers>(std::make_unique<TextNumbers>(text));
}

Result<size_t> pick_field(const std::vector<std::string>& names, const std::string& wanted,
                          const std::string& usual) {
    if (names.empty()) return user_error(messages::kNoField);
    const std::string& name = wanted.empty() ? usual : wanted;
    if (name.empty() && names.size() == 1) return size_t{0};
    std::string all;
    for (const std::string& one : names)
        all += fmt::format("{}`{}`", all.empty() ? "" : ", ", one);
    if (name.empty())
        return user_error(fmt::format(messages::kSeveralFields, all),
                          messages::kSeveralFieldsChoose);
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<size_t>(found - names.begin());
    return user_error(fmt::format(messages::kNoSuchField, name, all));
}

bool are_in_one_order(const std::vector<int64_t>& a, const std::vector<int64_t>& b) {
    const auto runs = [](const std::vector<int64_t>& sides) {
        std::vector<int64_t> out{1};
        for (const int64_t side : sides) {
            if (side != 1) out.push_back(out.back() * side);
        }
        return out;
    };
    const std::vector<int64_t> of_a = runs(a), of_b = runs(b);
    return of_a.back() == of_b.back() &&
           (std::includes(of_a.begin(), of_a.end(), of_b.begin(), of_b.end()) ||
            std::includes(of_b.begin(), of_b.end(), of_a.begin(), of_a.end()));
}

Result<int32_t> field_channels(const std::string& name, int64_t components) {
    if (components <= 4) return static_cast<int32_t>(components);
    return user_error(fmt::format(messages::kFieldComponents, name, components));
}

Result<void> read_floats(ArrayNumbers* numbers, float* out, int64_t count) {
    constexpr int64_t kBuffered = 4096;
    std::array<double, kBuffered> buffer{};
    bool rounds = false;
    for (int64_t at = 0; at < count;) {
        const auto n = static_cast<size_t>(std::min(count - at, kBuffered));
        if (Result<void> got = numbers->next(buffer.data(), n); !got) return got;
        for (size_t i = 0; i < n; ++i) {
            *out = static_cast<float>(buffer[i]);
            rounds = rounds || static_cast<double>(*out) != buffer[i];
            ++out;
        }
        at += static_cast<int64_t>(n);
    }
    rounds = rounds || numbers->has_lost();
    if (rounds && numbers->are_integers() && !numbers->told_rounded) {
        numbers->told_rounded = true;
        tell(fmt::format(messages::kIntegersRounded, messages::kItsFieldAlone));
    }
    return {};
}

}  // namespace openfab::tools
