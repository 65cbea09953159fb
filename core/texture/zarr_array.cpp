// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/zarr_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "base/scan_number.h"
#include "texture/messages.h"

namespace openfab::texture {

namespace {

constexpr size_t kMostAxes = 8;

/// One of the files of metadata, and what is wrong in it.
class Metadata {
  public:
    Metadata(const JsonValue& root, const std::string& name) : root_(root), name_(name) {}

    const JsonValue* find(const char* key) const { return member(&root_, key); }
    static const JsonValue* member(const JsonValue* value, const char* key) {
        const JsonMember* const found = value != nullptr ? value->find(key) : nullptr;
        return found != nullptr ? &found->value : nullptr;
    }
    /// The name of an extension, which is a word or an object with its name; empty for anything else.
    static std::string name_of(const JsonValue* value) {
        if (value != nullptr && value->is(JsonValue::Kind::kObject)) value = member(value, "name");
        return value != nullptr && value->is(JsonValue::Kind::kString) ? value->text : "";
    }
    /// What goes with the name.
    static const JsonValue* settings_of(const JsonValue& value) {
        return member(&value, "configuration");
    }
    Error fail(const JsonValue* at, const std::string& what, const char* help = "") const {
        return user_error(
            fmt::format(messages::kZarrAt, name_, at != nullptr ? at->line : root_.line, what),
            help);
    }
    Error missing(const char* key) const {
        return fail(nullptr, fmt::format(messages::kZarrKeyMissing, key));
    }

    /// Reads sides, or other whole numbers from `least` on.
    Result<void> read_sides(const JsonValue* value, const char* key, int64_t least,
                            std::vector<int64_t>* out) const {
        if (value == nullptr) return missing(key);
        if (!value->is(JsonValue::Kind::kArray) || value->items.size() > kMostAxes)
            return fail(value, fmt::format(messages::kZarrNotSides, key));
        for (const JsonValue& item : value->items) {
            constexpr int64_t kMost = int64_t{1} << 40;
            const std::optional<int64_t> side = item.whole();
            if (!side || *side < least || *side > kMost)
                return fail(&item, fmt::format(messages::kZarrNotSides, key));
            out->push_back(*side);
        }
        return {};
    }

  private:
    const JsonValue& root_;
    const std::string& name_;
};

/// Bits of a float of 2, 4 or 8 bytes.
uint64_t float_bits(double value, int bytes) {
    if (bytes == 8) return std::bit_cast<uint64_t>(value);
    const auto bits = std::bit_cast<uint32_t>(static_cast<float>(value));
    if (bytes == 4) return bits;
    const uint32_t sign = bits >> 16 & 0x8000u;
    const double size = std::abs(value);
    if (std::isnan(value)) return sign | 0x7e00u;
    constexpr double kMostHalf = 65520;
    if (size >= kMostHalf) return sign | 0x7c00u;
    // Its fraction in units of the last place, rounded to even as numpy does.
    int exponent = 0;
    (void)std::frexp(size, &exponent);
    exponent = std::max(exponent - 1, -14);
    const auto units = static_cast<uint32_t>(std::nearbyint(std::ldexp(size, 10 - exponent)));
    return sign | ((static_cast<uint32_t>(exponent + 14) << 10) + units);
}

/// Reads the fill value as the bits of its number.
Result<void> read_fill(const Metadata& metadata, const JsonValue* value, ZarrArray* out) {
    using Kind = JsonValue::Kind;
    uint64_t bits = 0;
    const auto bad = [&] {
        return metadata.fail(value, messages::kZarrFill, messages::kZarrFillHelp);
    };
    if (value == nullptr || value->is(Kind::kNull)) return {};
    if (value->is(Kind::kBool)) {
        if (out->kind != 'b') return bad();
        bits = value->boolean ? 1 : 0;
    } else if (out->kind == 'f') {
        double number = value->number;
        if (value->is(Kind::kString)) {
            const std::string& text = value->text;
            constexpr double kInfinite = std::numeric_limits<double>::infinity();
            if (text == "NaN") {
                number = std::numeric_limits<double>::quiet_NaN();
            } else if (text == "Infinity" || text == "-Infinity") {
                number = text[0] == '-' ? -kInfinite : kInfinite;
            } else {
                return bad();
            }
        } else if (!value->is(Kind::kNumber)) {
            return bad();
        }
        bits = float_bits(number, out->bytes);
    } else {
        const std::optional<int64_t> whole = value->whole();
        // Of version 2, numpy writes integers as floats, too.
        const bool as_float = !whole && value->is(Kind::kNumber) &&
                              std::abs(value->number) < 9e15 &&
                              value->number == std::floor(value->number);
        if (!whole && !as_float) return bad();
        const int64_t number = whole ? *whole : static_cast<int64_t>(value->number);
        if (out->kind == 'u' && number < 0) return bad();
        bits = static_cast<uint64_t>(number);
        const int unused = 64 - 8 * out->bytes;
        const bool fits = out->kind == 'i'
                              ? static_cast<int64_t>(bits << unused) >> unused == number
                              : (bits << unused) >> unused == bits;
        if (!fits) return bad();
    }
    std::memcpy(out->fill.data(), &bits, sizeof bits);
    return {};
}

/// Checks sides against each other, and that their products are numbers.
Result<void> check_sides(const Metadata& metadata, const ZarrArray& array) {
    const size_t axes = array.shape.size();
    if (axes == 0 || array.file.size() != axes || array.chunk.size() != axes)
        return metadata.fail(nullptr, messages::kZarrAxesDiffer);
    constexpr double kMost = 9e15;
    double bytes = array.bytes, chunks = 1;
    for (size_t a = 0; a < axes; ++a) {
        if (array.file[a] % array.chunk[a] != 0)
            return metadata.fail(nullptr, messages::kZarrShardSides);
        bytes *= static_cast<double>(array.chunk[a]);
        const int64_t in_file = array.file[a] / array.chunk[a];
        chunks *= static_cast<double>(in_file);
    }
    if (!(bytes < kMost) || !(chunks < kMost))
        return metadata.fail(nullptr, messages::kZarrChunkTooLarge);
    return {};
}

/// Reads the type of numbers of version 3, such as uint16.
bool read_type(const std::string& name, ZarrArray* out) {
    static constexpr std::string_view kWords[] = {"uint", "int", "float"};
    if (name == "bool") {
        out->kind = 'b';
        out->bytes = 1;
        return true;
    }
    for (const std::string_view word : kWords) {
        if (!name.starts_with(word)) continue;
        int64_t bits = 0;
        if (!scan_integer(std::string_view(name).substr(word.size()), 8, 64, &bits).empty())
            return false;
        out->kind = word[0];
        out->bytes = static_cast<int>(bits / 8);
        return std::has_single_bit(static_cast<uint64_t>(bits)) && (bits > 8 || word[0] != 'f');
    }
    return false;
}

/// Reads the codecs of version 3 of what a file holds or, inside of a shard, of a chunk.
class Codecs {
  public:
    Codecs(const Metadata& metadata, ZarrArray* out) : metadata_(metadata), out_(out) {}

    Result<void> read(const JsonValue* list, bool in_shard) {
        if (list == nullptr || !list->is(JsonValue::Kind::kArray))
            return metadata_.missing("codecs");
        bool in_bytes = false;
        for (const JsonValue& codec : list->items) {
            const std::string name = Metadata::name_of(&codec);
            const JsonValue* const settings = Metadata::settings_of(codec);
            Result<void> read;
            if (name == "sharding_indexed" && !in_shard && list->items.size() == 1)
                return read_shards(codec, settings);
            if (name == "transpose" && !in_bytes) {
                read = transpose(codec, settings);
            } else if (name == "bytes" && !in_bytes) {
                in_bytes = true;
                read = read_endian(codec, settings, &out_->big_endian);
            } else if (const std::optional<ZarrCodec> known = by_name(name); known && in_bytes) {
                out_->codecs.push_back(*known);
            } else {
                return unknown(codec, name);
            }
            if (!read) return read;
        }
        return in_bytes ? Result<void>() : metadata_.fail(list, messages::kZarrNoBytes);
    }

  private:
    static std::optional<ZarrCodec> by_name(const std::string& name) {
        if (name == "zstd" || name == "numcodecs.zstd") return ZarrCodec::kZstd;
        if (name == "gzip" || name == "numcodecs.gzip") return ZarrCodec::kGzip;
        if (name == "zlib" || name == "numcodecs.zlib") return ZarrCodec::kZlib;
        if (name == "blosc") return ZarrCodec::kBlosc;
        if (name == "crc32c") return ZarrCodec::kCrc32c;
        return std::nullopt;
    }

    Error unknown(const JsonValue& at, const std::string& name) const {
        return metadata_.fail(&at, fmt::format(messages::kZarrCodec, name),
                              messages::kZarrCodecHelp);
    }

    Result<void> read_endian(const JsonValue& codec, const JsonValue* settings, bool* big) const {
        const JsonValue* const endian = Metadata::member(settings, "endian");
        if (endian == nullptr) return {};
        if (endian->text != "little" && endian->text != "big")
            return metadata_.fail(&codec, fmt::format(messages::kZarrEndian, endian->text));
        *big = endian->text == "big";
        return {};
    }

    Result<void> transpose(const JsonValue& codec, const JsonValue* settings) {
        std::vector<int64_t> wanted;
        if (Result<void> read =
                metadata_.read_sides(Metadata::member(settings, "order"), "order", 0, &wanted);
            !read)
            return read;
        const std::vector<size_t> before = out_->order;
        std::vector<int64_t> sorted = wanted;
        std::sort(sorted.begin(), sorted.end());
        for (size_t a = 0; a < sorted.size(); ++a) {
            if (sorted[a] != static_cast<int64_t>(a) || sorted.size() != before.size())
                return metadata_.fail(&codec, messages::kZarrOrder);
        }
        for (size_t a = 0; a < wanted.size(); ++a)
            out_->order[a] = before[static_cast<size_t>(wanted[a])];
        return wanted.size() == before.size() ? Result<void>()
                                              : metadata_.fail(&codec, messages::kZarrOrder);
    }

    Result<void> read_shards(const JsonValue& codec, const JsonValue* settings) {
        out_->sharded = true;
        out_->chunk.clear();
        if (Result<void> read = metadata_.read_sides(Metadata::member(settings, "chunk_shape"),
                                                     "chunk_shape", 1, &out_->chunk);
            !read)
            return read;
        if (const JsonValue* const at = Metadata::member(settings, "index_location")) {
            if (at->text != "start" && at->text != "end")
                return metadata_.fail(at, fmt::format(messages::kZarrIndexPlace, at->text));
            out_->index_first = at->text == "start";
        }
        const JsonValue* const index = Metadata::member(settings, "index_codecs");
        if (index == nullptr || index->items.empty() || index->items.size() > 2 ||
            Metadata::name_of(&index->items[0]) != "bytes")
            return metadata_.fail(&codec, messages::kZarrIndexCodecs);
        if (Result<void> read = read_endian(index->items[0], Metadata::settings_of(index->items[0]),
                                            &out_->index_big_endian);
            !read)
            return read;
        out_->index_checked = index->items.size() == 2;
        if (out_->index_checked && Metadata::name_of(&index->items[1]) != "crc32c")
            return metadata_.fail(&codec, messages::kZarrIndexCodecs);
        return read(Metadata::member(settings, "codecs"), true);
    }

    const Metadata& metadata_;
    ZarrArray* out_;
};

Result<void> read_key_encoding(const Metadata& metadata, ZarrArray* out) {
    const JsonValue* const encoding = metadata.find("chunk_key_encoding");
    if (encoding == nullptr) return metadata.missing("chunk_key_encoding");
    const std::string name = Metadata::name_of(encoding);
    if (name != "default" && name != "v2")
        return metadata.fail(encoding, fmt::format(messages::kZarrKeys, name));
    out->separator = name == "default" ? '/' : '.';
    const JsonValue* const separator =
        Metadata::member(Metadata::settings_of(*encoding), "separator");
    if (separator != nullptr) {
        if (separator->text != "/" && separator->text != ".")
            return metadata.fail(separator, fmt::format(messages::kZarrKeys, separator->text));
        out->separator = separator->text[0];
    }
    if (name == "default") out->key_begin = std::string("c") + out->separator;
    return {};
}

/// Refuses what a reader must know to read the array: members that the specification has not.
Result<void> check_extensions(const Metadata& metadata, const JsonValue& root) {
    static constexpr std::string_view kKnown[] = {"zarr_format",
                                                  "node_type",
                                                  "shape",
                                                  "data_type",
                                                  "chunk_grid",
                                                  "chunk_key_encoding",
                                                  "codecs",
                                                  "fill_value",
                                                  "attributes",
                                                  "dimension_names",
                                                  "storage_transformers",
                                                  "consolidated_metadata"};
    for (const JsonMember& member : root.members) {
        if (std::find(std::begin(kKnown), std::end(kKnown), member.key) != std::end(kKnown))
            continue;
        const JsonValue* const must = Metadata::member(&member.value, "must_understand");
        if (must == nullptr || !must->is(JsonValue::Kind::kBool) || must->boolean)
            return metadata.fail(&member.value, fmt::format(messages::kZarrExtension, member.key));
    }
    const JsonValue* const transformers = metadata.find("storage_transformers");
    if (transformers != nullptr && !transformers->items.empty())
        return metadata.fail(transformers,
                             fmt::format(messages::kZarrExtension, "storage_transformers"));
    return {};
}

void start_order(ZarrArray* out) {
    for (size_t a = 0; a < out->shape.size(); ++a)
        out->order.push_back(a);
}

}  // namespace

const char* codec_name(ZarrCodec codec) {
    static constexpr const char* kNames[] = {"blosc", "crc32c", "gzip", "zlib", "zstd"};
    return kNames[static_cast<size_t>(codec)];
}

int64_t ZarrArray::chunk_bytes() const {
    int64_t out = bytes;
    for (const int64_t side : chunk)
        out *= side;
    return out;
}

int64_t ZarrArray::chunks_in_file() const {
    int64_t out = 1;
    for (size_t a = 0; a < file.size(); ++a)
        out *= file[a] / chunk[a];
    return out;
}

std::string ZarrArray::file_name(std::span<const int64_t> at) const {
    return key_begin + fmt::format("{}", fmt::join(at, std::string_view(&separator, 1)));
}

Result<ZarrArray> read_zarr3_array(const JsonValue& root, const std::string& name) {
    const Metadata metadata(root, name);
    ZarrArray out;
    if (Result<void> known = check_extensions(metadata, root); !known) return known.error();
    if (Result<void> read = metadata.read_sides(metadata.find("shape"), "shape", 1, &out.shape);
        !read)
        return read.error();
    const JsonValue* const type = metadata.find("data_type");
    if (type == nullptr) return metadata.missing("data_type");
    const std::string type_name = Metadata::name_of(type);
    if (!read_type(type_name, &out))
        return metadata.fail(type, fmt::format(messages::kZarrType, type_name),
                             messages::kZarrTypeHelp);
    const JsonValue* const grid = metadata.find("chunk_grid");
    if (grid == nullptr) return metadata.missing("chunk_grid");
    if (const std::string kind = Metadata::name_of(grid); kind != "regular")
        return metadata.fail(grid, fmt::format(messages::kZarrGrid, kind));
    if (Result<void> read =
            metadata.read_sides(Metadata::member(Metadata::settings_of(*grid), "chunk_shape"),
                                "chunk_shape", 1, &out.file);
        !read)
        return read.error();
    out.chunk = out.file;
    start_order(&out);
    if (Result<void> read = read_key_encoding(metadata, &out); !read) return read.error();
    if (Result<void> read = Codecs(metadata, &out).read(metadata.find("codecs"), false); !read)
        return read.error();
    if (Result<void> read = read_fill(metadata, metadata.find("fill_value"), &out); !read)
        return read.error();
    if (const JsonValue* const names = metadata.find("dimension_names")) {
        for (const JsonValue& axis : names->items)
            out.names.push_back(axis.text);
        if (out.names.size() != out.shape.size()) out.names.clear();
    }
    if (Result<void> fits = check_sides(metadata, out); !fits) return fits.error();
    return out;
}

Result<ZarrArray> read_zarr2_array(const JsonValue& root, const std::string& name) {
    using Kind = JsonValue::Kind;
    const Metadata metadata(root, name);
    ZarrArray out;
    if (Result<void> read = metadata.read_sides(metadata.find("shape"), "shape", 1, &out.shape);
        !read)
        return read.error();
    if (Result<void> read = metadata.read_sides(metadata.find("chunks"), "chunks", 1, &out.file);
        !read)
        return read.error();
    out.chunk = out.file;
    const JsonValue* const type = metadata.find("dtype");
    if (type == nullptr) return metadata.missing("dtype");
    const std::string& text = type->text;
    const bool known = text.size() == 3 &&
                       std::string_view("<>|").find(text[0]) != std::string::npos &&
                       std::string_view("uifb").find(text[1]) != std::string::npos;
    out.kind = known ? text[1] : 'f';
    out.bytes = known ? text[2] - '0' : 0;
    out.big_endian = known && text[0] == '>';
    const bool possible =
        out.kind == 'f'   ? out.bytes == 2 || out.bytes == 4 || out.bytes == 8
        : out.kind == 'b' ? out.bytes == 1
                          : out.bytes == 1 || out.bytes == 2 || out.bytes == 4 || out.bytes == 8;
    if (!possible)
        return metadata.fail(type,
                             fmt::format(messages::kZarrType, type->is(Kind::kString) ? text : "…"),
                             messages::kZarrTypeHelp);
    start_order(&out);
    const JsonValue* const order = metadata.find("order");
    if (order != nullptr && order->text == "F") std::reverse(out.order.begin(), out.order.end());
    const JsonValue* const filters = metadata.find("filters");
    if (filters != nullptr && !filters->items.empty()) {
        const JsonValue* const id = Metadata::member(filters->items.data(), "id");
        return metadata.fail(filters,
                             fmt::format(messages::kZarrFilter, id != nullptr ? id->text : "…"),
                             messages::kZarrCodecHelp);
    }
    const JsonValue* const compressor = metadata.find("compressor");
    if (compressor != nullptr && !compressor->is(Kind::kNull)) {
        const JsonValue* const id = Metadata::member(compressor, "id");
        const std::string codec = id != nullptr ? id->text : "";
        constexpr ZarrCodec kCodecs[] = {ZarrCodec::kBlosc, ZarrCodec::kGzip, ZarrCodec::kZlib,
                                         ZarrCodec::kZstd};
        const auto* const found =
            std::find_if(std::begin(kCodecs), std::end(kCodecs),
                         [&](ZarrCodec one) { return codec == codec_name(one); });
        if (found == std::end(kCodecs))
            return metadata.fail(compressor, fmt::format(messages::kZarrCodec, codec),
                                 messages::kZarrCodecHelp);
        out.codecs.push_back(*found);
    }
    const JsonValue* const separator = metadata.find("dimension_separator");
    out.separator = separator != nullptr && separator->text == "/" ? '/' : '.';
    if (Result<void> read = read_fill(metadata, metadata.find("fill_value"), &out); !read)
        return read.error();
    if (Result<void> fits = check_sides(metadata, out); !fits) return fits.error();
    return out;
}

}  // namespace openfab::texture
