// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// NRRD, https://teem.sourceforge.net/nrrd/format.html, as far as scanners and simulations write it.

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <string_view>

#include "base/input_file.h"
#include "base/units.h"
#include "texture/nrrd_header.h"
#include "tools/texture/volume_reader.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

constexpr size_t kAtOnce = 1 << 16;

/// Streams the bytes after a header.
class ByteStream {
  public:
    ByteStream(InputFile file, int64_t begin) : file_(std::move(file)), at_(begin) {}
    virtual ~ByteStream() = default;
    /// Reads up to `bytes` bytes; fewer only at the end.
    virtual Result<size_t> next(char* out, size_t bytes) {
        Result<size_t> got = file_.read(at_, out, bytes);
        if (got) at_ += static_cast<int64_t>(*got);
        return got;
    }
    /// Skips that many bytes.
    virtual Result<void> skip(int64_t bytes) {
        at_ += std::max<int64_t>(bytes, 0);
        return {};
    }
    /// Returns an upper bound of the number of bytes.
    virtual int64_t left() const { return file_.bytes() - at_; }

  protected:
    InputFile file_;
    int64_t at_ = 0;
};

/// The same, decompressed by zlib.
class UnpackedStream final : public ByteStream {
  public:
    UnpackedStream(InputFile file, int64_t begin) : ByteStream(std::move(file), begin) {
        constexpr int kGzip = 16;
        ready_ = inflateInit2(&state_, kGzip + MAX_WBITS) == Z_OK;
    }
    ~UnpackedStream() override { inflateEnd(&state_); }

    Result<size_t> next(char* out, size_t bytes) override {
        state_.next_out = reinterpret_cast<Bytef*>(out);
        state_.avail_out = static_cast<uInt>(bytes);
        while (state_.avail_out > 0 && !ended_) {
            if (state_.avail_in == 0) {
                const Result<size_t> got = ByteStream::next(buffer_.data(), buffer_.size());
                if (!got) return got.error();
                state_.next_in = reinterpret_cast<Bytef*>(buffer_.data());
                state_.avail_in = static_cast<uInt>(*got);
            }
            const int done = ready_ ? inflate(&state_, Z_NO_FLUSH) : Z_MEM_ERROR;
            ended_ = done == Z_STREAM_END;
            // Without input it makes no progress: the data is truncated.
            if (done != Z_OK && !ended_) return user_error(kDamaged);
        }
        return bytes - state_.avail_out;
    }
    Result<void> skip(int64_t bytes) override {
        std::vector<char> unused(kAtOnce);
        while (bytes > 0) {
            const auto step = static_cast<size_t>(std::min<int64_t>(bytes, kAtOnce));
            const Result<size_t> got = next(unused.data(), step);
            if (!got) return got.error();
            if (*got < step) return user_error(kDamaged);
            bytes -= static_cast<int64_t>(step);
        }
        return {};
    }
    int64_t left() const override {
        constexpr int64_t kDensest = 1032;  // of deflate: bytes per compressed byte
        return ByteStream::left() * kDensest;
    }

    static constexpr const char* kDamaged =
        "its compressed data is damaged or of another size than it says";

  private:
    z_stream state_{};
    bool ready_ = false;
    bool ended_ = false;
    std::vector<char> buffer_ = std::vector<char>(kAtOnce);
};

class NrrdReader final : public VolumeReader {
  public:
    std::unique_ptr<ByteStream> stream;
    NumberFormat format;
    bool text = false;
    bool packed = false;

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const int64_t count = slice_floats();
        const auto step = static_cast<int64_t>(kAtOnce) / format.bytes;
        for (int64_t begin = 0; begin < count; begin += step) {
            const int64_t n = std::min(step, count - begin);
            Result<void> read = text ? words(out + begin, n) : numbers(out + begin, n);
            if (!read) return read;
            wrote(4 * n);
        }
        return z + 1 == size.z && packed ? end() : Result<void>();
    }

  private:
    Result<void> numbers(float* out, int64_t count) {
        const size_t bytes = static_cast<size_t>(count * format.bytes);
        const Result<size_t> got = stream->next(buffer_.data(), bytes);
        if (!got) return got.error();
        if (*got < bytes) return user_error(packed ? UnpackedStream::kDamaged : "it is cut short");
        for (int64_t i = 0; i < count; ++i)
            out[i] = read_number(format, buffer_.data() + i * format.bytes);
        return {};
    }

    Result<void> words(float* out, int64_t count) {
        const double largest = format.kind != NumberFormat::Kind::kUnsigned ? 1
                               : format.bytes == 1                          ? 255
                               : format.bytes == 2                          ? 65535
                                                                            : 1;
        for (int64_t i = 0; i < count; ++i) {
            std::string word;
            if (Result<void> found = next_word(&word); !found) return found;
            char* end = nullptr;
            const double value = std::strtod(word.c_str(), &end);
            if (*end != '\0') return user_error(fmt::format("`{}` in it is not a number", word));
            out[i] = static_cast<float>(value / largest);
        }
        return {};
    }

    Result<void> next_word(std::string* word) {
        constexpr size_t kLongest = 64;
        constexpr std::string_view kBlanks = " \t\r\n,";
        for (;; ++at_) {
            if (at_ == held_) {
                const Result<size_t> got = stream->next(buffer_.data(), buffer_.size());
                if (!got) return got.error();
                held_ = *got;
                at_ = 0;
                if (held_ == 0)
                    return word->empty() ? Result<void>(user_error("it is cut short")) : Ok{};
            }
            const char c = buffer_[at_];
            if (kBlanks.find(c) == std::string_view::npos) {
                *word += c;
                if (word->size() > kLongest)
                    return user_error(fmt::format("`{}...` in it is not a number", *word));
            } else if (!word->empty()) {
                return {};
            }
        }
    }

    /// Only the end of compressed data shows that it is complete.
    Result<void> end() {
        char more = 0;
        const Result<size_t> got = stream->next(&more, 1);
        if (!got) return got.error();
        return *got == 0 || text ? Result<void>() : user_error(UnpackedStream::kDamaged);
    }

    std::vector<char> buffer_ = std::vector<char>(kAtOnce);
    size_t held_ = 0, at_ = 0;
};

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
        {"int16", {Kind::kSigned, 2}},
        {"int16_t", {Kind::kSigned, 2}},
        {"ushort", {Kind::kUnsigned, 2}},
        {"unsigned short", {Kind::kUnsigned, 2}},
        {"uint16", {Kind::kUnsigned, 2}},
        {"uint16_t", {Kind::kUnsigned, 2}},
        {"int", {Kind::kSigned, 4}},
        {"int32", {Kind::kSigned, 4}},
        {"int32_t", {Kind::kSigned, 4}},
        {"uint", {Kind::kUnsigned, 4}},
        {"unsigned int", {Kind::kUnsigned, 4}},
        {"uint32", {Kind::kUnsigned, 4}},
        {"uint32_t", {Kind::kUnsigned, 4}},
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
    in >> open >> (*out)[0] >> first >> (*out)[1] >> second >> (*out)[2] >> close;
    return static_cast<bool>(in) && open == '(' && close == ')';
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
        return user_error(
            fmt::format("its `{}` is `{}`; a whole number from {} is right", name, text, least));
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
        return user_error(
            "its `byte skip` is -1, which is for the encoding `raw` alone: where other data end "
            "does not say where they begin");
    }
    if (*bytes < 0 && *lines > 0) {
        return user_error(
            "it has a `line skip` and a `byte skip` of -1, which counts from the end; give one of "
            "them");
    }
    return Skipped{*lines, *bytes};
}

/// Returns the offset of line number `lines`, from 0.
Result<int64_t> behind_lines(const InputFile& file, int64_t begin, int64_t lines) {
    std::vector<char> buffer(kAtOnce);
    for (int64_t at = begin; lines > 0;) {
        const Result<size_t> got = file.read(at, buffer.data(), buffer.size());
        if (!got) return got.error();
        if (*got == 0) return user_error("it has fewer lines than its `line skip`");
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

/// Reads spacing and origin; fails for rotated axes.
Result<void> read_placement(const texture::NrrdHeader& header, size_t first, NrrdReader* reader) {
    const auto field = [&](const char* name) { return words_of(header.field(name)); };
    std::array<double, 3> spacing{1, 1, 1}, middle{};
    bool known = false;
    if (const auto directions = field("space directions"); directions.size() == first + 3) {
        for (size_t a = 0; a < 3; ++a) {
            std::array<double, 3> v{};
            if (!vector_of(directions[first + a], &v))
                return user_error("its `space directions` are malformed");
            for (size_t k = 0; k < 3; ++k) {
                if (k != a && std::fabs(v[k]) > 1e-6 * std::fabs(v[a]))
                    return user_error("its axes are rotated; write it along x, y and z");
            }
            if (!(v[a] > 0))
                return user_error("one of its axes runs backwards; write it along x, y and z");
            spacing[a] = v[a];
        }
        known = true;
    } else if (const auto sizes = field("spacings"); sizes.size() == first + 3) {
        for (size_t a = 0; a < 3; ++a) {
            spacing[a] = std::strtod(sizes[first + a].c_str(), nullptr);
            if (!(spacing[a] > 0)) return user_error("its `spacings` are not above 0");
        }
        known = true;
    }
    if (known) reader->spacing = spacing;
    if (const auto origin = field("space origin"); origin.size() == 1) {
        if (!vector_of(origin[0], &middle))
            return user_error("its `space origin` is not understood");
        reader->origin.emplace();
        for (size_t a = 0; a < 3; ++a)
            (*reader->origin)[a] = middle[a] - spacing[a] / 2;
    }
    return Ok{};
}

}  // namespace

MadeReader open_nrrd(const fs::path& file, const texture::ReadLimits& limits) {
    Result<InputFile> source = InputFile::open(file);
    if (!source) return source.error();
    const Result<texture::NrrdHeader> read = texture::read_nrrd_header(*source);
    if (!read) return read.error();
    const texture::NrrdHeader& header = *read;
    auto reader = std::make_unique<NrrdReader>();
    if (!number_format(header.field("type"), &reader->format))
        return user_error(
            fmt::format("its numbers are of type `{}`, which is not known", header.field("type")));
    reader->format.swapped = header.field("endian") == "big";
    const std::vector<std::string> sizes = words_of(header.field("sizes"));
    if (sizes.size() != 3 && sizes.size() != 4)
        return user_error(fmt::format(
            "it has {} dimensions; it must have 3, or 4 with the channels first", sizes.size()));
    const size_t first = sizes.size() - 3;
    std::array<int64_t, 4> n{1, 1, 1, 1};
    int64_t numbers = 1;
    for (size_t k = 0; k < sizes.size(); ++k) {
        n[k + 1 - first] = std::strtoll(sizes[k].c_str(), nullptr, 10);
        if (n[k + 1 - first] < 1 || n[k + 1 - first] > 16384)
            return user_error(fmt::format("a side of {} is not possible", sizes[k]));
        numbers *= n[k + 1 - first];
        if (numbers > (int64_t{1} << 32)) return user_error("it is too large");
    }
    reader->channels = static_cast<int32_t>(n[0]);
    reader->size = {static_cast<int32_t>(n[1]), static_cast<int32_t>(n[2]),
                    static_cast<int32_t>(n[3])};
    if (Result<void> placed = read_placement(header, first, reader.get()); !placed)
        return placed.error();
    int64_t begin = header.begin;
    if (const std::string name = header.data_file(); !name.empty()) {
        source = texture::open_data_file(file, name, limits);
        if (!source) return source.error();
        begin = 0;
    }
    const std::string encoding = header.field("encoding");
    reader->packed = encoding == "gzip" || encoding == "gz";
    reader->text = encoding == "ascii" || encoding == "text" || encoding == "txt";
    if (!reader->packed && !reader->text && encoding != "raw") {
        return user_error(
            fmt::format("its encoding `{}` is unknown; known: raw, text, gzip", encoding));
    }
    // Before allocation: a number takes its size in bytes, or a digit and a blank as text.
    const int64_t needed = reader->text ? 2 * numbers - 1 : numbers * reader->format.bytes;
    const Result<Skipped> skipped = skipped_by(header, !reader->packed && !reader->text);
    if (!skipped) return skipped.error();
    const Result<int64_t> line = behind_lines(*source, begin, skipped->lines);
    if (!line) return line.error();
    begin = *line;
    if (skipped->bytes < 0) begin = std::max(begin, source->bytes() - needed);
    if (reader->packed) {
        reader->stream = std::make_unique<UnpackedStream>(std::move(*source), begin);
    } else {
        reader->stream = std::make_unique<ByteStream>(std::move(*source), begin);
    }
    const int64_t left = reader->stream->left();
    if (left < needed || left - needed < skipped->bytes)
        return user_error(reader->packed ? UnpackedStream::kDamaged : "it is cut short");
    // Everything skipped must be decompressed.
    if (reader->packed && skipped->bytes > limits.memory_bytes) {
        return user_error(
            fmt::format("its `byte skip` passes over {} of packed data, more than the {} of "
                        "`--memory`; write it without them",
                        format_bytes(skipped->bytes), format_bytes(limits.memory_bytes)));
    }
    if (Result<void> done = reader->stream->skip(skipped->bytes); !done) return done.error();
    return std::unique_ptr<VolumeReader>(std::move(reader));
}

}  // namespace openfab::tools
