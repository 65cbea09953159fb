// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/stl.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/color.h"
#include "base/large_pages.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

constexpr size_t kHeader = 84;  ///< 80 arbitrary bytes, then the number of triangles
constexpr size_t kFacet = 50;   ///< normal, three corners, two bytes

static_assert(std::endian::native == std::endian::little, "STL is read as it lies in memory");

uint32_t facets_of(std::string_view bytes) {
    uint32_t count = 0;
    std::memcpy(&count, bytes.data() + kHeader - 4, 4);
    return count;
}

/// Returns where the colour of a header `COLOR=rgba` stands, as Magics writes it; null if nowhere.
const uint8_t* color_of_header(std::string_view bytes) {
    constexpr std::string_view kColor = "COLOR=";
    const size_t at = bytes.substr(0, kHeader - 4).find(kColor);
    if (at == std::string_view::npos || at + kColor.size() + 4 > kHeader - 4) return nullptr;
    return reinterpret_cast<const uint8_t*>(bytes.data()) + at + kColor.size();
}

/// Whether a header with a colour is MeshLab's, which writes a grey that nobody chose into all
/// files, and marks facets with a colour of their own. Its words are parted by blanks, those of
/// Magics by commas; and Magics marks what has the header's colour, not one of several others.
bool is_of_meshlab(std::string_view bytes, const std::vector<int32_t>& values) {
    const uint8_t* header = color_of_header(bytes);
    if (header == nullptr) return false;
    constexpr std::string_view kNext = " MATERIAL=";
    const std::string_view rest(reinterpret_cast<const char*>(header) + 3,
                                static_cast<size_t>(bytes.data() + kHeader - 4 -
                                                    reinterpret_cast<const char*>(header) - 3));
    if (rest.starts_with(kNext)) return true;
    const int32_t own = header[0] >> 3 | header[1] >> 3 << 5 | header[2] >> 3 << 10;
    return std::any_of(values.begin(), values.end(), [&](int32_t value) {
        return (value & 0x8000) != 0 && (value & 0x7FFF) != 0 && (value & 0x7FFF) != own;
    });
}

/// Colours of facets, each with its index; 5 bits a channel.
class FacetColors {
  public:
    /// `values`: the two bytes of each facet. If all are 0, the header's colour is that of all.
    FacetColors(std::string_view bytes, const std::vector<int32_t>& values)
        : header_(color_of_header(bytes)),
          any_(std::any_of(values.begin(), values.end(), [](int32_t v) { return v != 0; })),
          meshlab_(is_of_meshlab(bytes, values)) {}

    /// Returns the index of the colour that a facet's two bytes stand for; -1: none. Magics marks
    /// facets of the header's colour by the highest bit, other programs those that have their own.
    int32_t index(uint16_t value) {
        const bool marked = (value & 0x8000) != 0;
        const bool own = header_ == nullptr || meshlab_;
        if (!own && (marked || !any_)) return of_header();
        if (own && !marked) return -1;
        int32_t& known = known_[value & 0x7FFF];
        if (known == 0) {
            const int red = header_ != nullptr ? 0 : 10;
            for (const int shift : {red, 5, 10 - red})
                add(((value >> shift) & 31) / 31.0);
            known = static_cast<int32_t>(values_.size() / 3);
        }
        return known - 1;
    }

    bool is_transparent() const { return header_ != nullptr && !meshlab_ && header_[3] < 255; }
    const std::vector<float>& values() const { return values_; }

  private:
    int32_t of_header() {
        if (of_header_ < 0) {
            of_header_ = static_cast<int32_t>(values_.size() / 3);
            for (int c = 0; c < 3; ++c)
                add(header_[c] / 255.0);
        }
        return of_header_;
    }
    void add(double srgb) { values_.push_back(static_cast<float>(srgb_to_linear(srgb))); }

    const uint8_t* header_;
    bool any_;
    bool meshlab_;
    int32_t of_header_ = -1;
    std::vector<int32_t> known_ = std::vector<int32_t>(0x8000);  ///< index + 1
    std::vector<float> values_;
};

/// Adds the colours of facets as those of their corners; one alone as the look of all.
Result<void> add_colors(std::string_view bytes, int64_t memory_bytes,
                        const std::vector<int32_t>& attributes, MeshSource* out) {
    FacetColors colors(bytes, attributes);
    const auto count = static_cast<int64_t>(attributes.size());
    const int64_t needed = mesh_bytes({count * 3, count, 2 * count, 1, 0});
    int64_t bare = 0;
    for (const int32_t value : attributes)
        bare += colors.index(static_cast<uint16_t>(value)) < 0;
    if (bare == count) return Ok{};
    if (needed > memory_bytes)
        return too_large_to_read(out->origin.file, count, needed, memory_bytes);
    Look look;
    look.is_material = false;
    look.color = {1, 1, 1};
    if (bare == 0 && colors.values().size() == 3) {
        for (size_t c = 0; c < 3; ++c)
            (*look.color)[c] = static_cast<double>(colors.values()[c]);
        out->face_groups.assign(attributes.size(), out->group_index({{}, "", 0, 0}));
    } else {
        look.vertex_colors = true;
        MeshAttribute color;
        color.name = "color";
        color.components = 3;
        const int32_t colored = out->group_index({{}, "", 0, 0});
        const int32_t plain = bare > 0 ? out->group_index({{}, "", -1, 0}) : colored;
        for (const int32_t value : attributes) {
            const int32_t i = colors.index(static_cast<uint16_t>(value));
            color.corners.push_back({i, i, i});
            out->face_groups.push_back(i < 0 ? plain : colored);
        }
        color.values = colors.values();
        out->mesh.attributes.push_back(std::move(color));
    }
    if (colors.is_transparent()) {
        out->leave_out(messages::kTransparencyOfHeader, out->origin.file,
                       messages::kTransparencyOfHeaderHelp);
    }
    out->looks.push_back(std::move(look));
    return Ok{};
}

Result<MeshSource> parse_binary(std::string_view bytes, const std::string& file,
                                int64_t memory_bytes) {
    const uint32_t count = facets_of(bytes);
    if ((bytes.size() - kHeader) / kFacet < count) {
        return user_error(fmt::format(messages::kBinaryStlCutShort, file, count,
                                      (bytes.size() - kHeader) / kFacet));
    }
    const int64_t needed = mesh_bytes({int64_t{count} * 3, count, count, 0, 0});
    if (needed > memory_bytes) return too_large_to_read(file, count, needed, memory_bytes);
    MeshSource out;
    out.origin.file = file;
    MeshAttribute extra;
    extra.name = "attribute";
    extra.is_int = true;
    bool any_extra = false;
    reserve_large(&out.mesh.positions, size_t{count} * 3);
    reserve_large(&out.mesh.triangles, count);
    reserve_large(&extra.faces, count);
    for (size_t t = 0; t < count; ++t) {
        const char* facet = bytes.data() + kHeader + t * kFacet;
        float corners[9];
        uint16_t value = 0;
        std::memcpy(corners, facet + 12, sizeof corners);
        std::memcpy(&value, facet + 48, sizeof value);
        for (size_t i = 0; i < 9; i += 3) {
            if (!is_position(corners[i], corners[i + 1], corners[i + 2])) {
                return user_error(fmt::format(messages::kCornerNotFinite, file, t + 1));
            }
            out.mesh.positions.push_back({corners[i], corners[i + 1], corners[i + 2]});
        }
        const auto v = static_cast<int32_t>(t * 3);
        out.mesh.triangles.push_back({v, v + 1, v + 2});
        extra.faces.push_back(value);
        any_extra = any_extra || value != 0;
    }
    if (any_extra || color_of_header(bytes) != nullptr) {
        if (Result<void> done = add_colors(bytes, memory_bytes, extra.faces, &out); !done)
            return done.error();
    }
    if (any_extra) out.mesh.attributes.push_back(std::move(extra));
    return out;
}

/// Splits text into words and keeps the position of the last one.
class Words {
  public:
    Words(std::string_view text, const std::string& file) : text_(text), file_(file) {}

    /// Returns the next word, empty at the end.
    std::string_view next() {
        while (at_ < text_.size() && is_space(text_[at_])) {
            if (text_[at_] == '\n') {
                ++line_;
                line_start_ = at_ + 1;
            }
            ++at_;
        }
        start_ = at_;
        while (at_ < text_.size() && !is_space(text_[at_]))
            ++at_;
        return text_.substr(start_, at_ - start_);
    }

    /// Returns the rest of the line without surrounding blanks.
    std::string_view rest_of_line() {
        size_t end = std::min(text_.find('\n', at_), text_.size());
        size_t start = at_;
        at_ = end;
        while (start < end && is_space(text_[start]))
            ++start;
        while (end > start && is_space(text_[end - 1]))
            --end;
        return text_.substr(start, end - start);
    }

    int32_t line() const { return line_; }

    Error error(const std::string& what, const std::string& help = {}) const {
        return error_at({file_, line_, static_cast<int32_t>(start_ - line_start_) + 1}, what, help);
    }

  private:
    static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

    std::string_view text_;
    const std::string& file_;
    size_t at_ = 0;
    size_t start_ = 0;
    size_t line_start_ = 0;
    int32_t line_ = 1;
};

bool equal_ignoring_case(std::string_view word, std::string_view lower) {
    if (word.size() != lower.size()) return false;
    for (size_t i = 0; i < word.size(); ++i) {
        if (lower_ascii(word[i]) != lower[i]) return false;
    }
    return true;
}

class AsciiReader {
  public:
    AsciiReader(std::string_view text, const std::string& file, int64_t memory_bytes)
        : words_(text, file), file_(file), memory_bytes_(memory_bytes) {
        out_.origin.file = file;
    }

    Result<MeshSource> read() {
        bool in_solid = false;
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
            Result<void> done = Ok{};
            if (equal_ignoring_case(word, "solid")) {
                name_ = utf8_or_latin1(words_.rest_of_line());
                group_ = -1;
                in_solid = true;
            } else if (equal_ignoring_case(word, "endsolid")) {
                words_.rest_of_line();
            } else if (equal_ignoring_case(word, "facet") && in_solid) {
                done = facet();
            } else {
                done = words_.error(fmt::format(messages::kOtherWordThanFacet, word.substr(0, 40)));
            }
            if (!done) return done.error();
            MeshCounts counts = counts_of(out_);
            counts.group_bytes += bodies_bytes_;
            const int64_t needed = growing_bytes(mesh_bytes(counts));
            if (needed > memory_bytes_)
                return too_large_to_read(file_, counts.triangles, needed, memory_bytes_);
        }
        return std::move(out_);
    }

  private:
    Result<void> expect(std::string_view wanted) {
        const std::string_view word = words_.next();
        if (equal_ignoring_case(word, wanted)) return Ok{};
        if (word.empty())
            return words_.error(fmt::format(messages::kEndsBeforeWord, wanted),
                                messages::kWasCutShort);
        return words_.error(fmt::format(messages::kOtherWord, word.substr(0, 40), wanted));
    }

    Result<Vec3d> numbers() {
        Vec3d v;
        for (int a = 0; a < 3; ++a) {
            const std::string wrong = scan_number(words_.next(), &v[a]);
            if (!wrong.empty()) return words_.error(wrong);
        }
        return v;
    }

    /// Each solid is a body, whatever it is called; one without facets is none.
    void begin_body() {
        FaceGroup solid;
        if (!name_.empty()) solid.names.push_back(name_);
        solid.body = static_cast<int32_t>(out_.bodies.size());
        out_.bodies.push_back({name_, BodyRole::kPart, 0});
        bodies_bytes_ += static_cast<int64_t>(sizeof(Body) + name_.size());
        group_ = out_.group_index(solid);
    }

    Result<void> facet() {
        if (group_ < 0) begin_body();
        out_.origin.lines.push_back(words_.line());
        out_.face_groups.push_back(group_);
        const auto v = static_cast<int32_t>(out_.mesh.positions.size());
        out_.mesh.triangles.push_back({v, v + 1, v + 2});
        if (Result<void> word = expect("normal"); !word) return word;
        // Some programs write `nan` for triangles without area; the order of the corners is used
        // instead.
        for (int i = 0; i < 3; ++i)
            words_.next();
        for (const char* word : {"outer", "loop"}) {
            if (Result<void> found = expect(word); !found) return found;
        }
        for (int i = 0; i < 3; ++i) {
            if (Result<void> found = expect("vertex"); !found) return found;
            Result<Vec3d> corner = numbers();
            if (!corner) return corner.error();
            out_.mesh.positions.push_back(*corner);
        }
        for (const char* word : {"endloop", "endfacet"}) {
            if (Result<void> found = expect(word); !found) return found;
        }
        return Ok{};
    }

    Words words_;
    const std::string& file_;
    int64_t memory_bytes_;
    MeshSource out_;
    std::string name_;  ///< of the current solid
    int32_t group_ = -1;
    int64_t bodies_bytes_ = 0;
};

bool has_size_of_binary(std::string_view bytes) {
    return bytes.size() >= kHeader && bytes.size() - kHeader == size_t{facets_of(bytes)} * kFacet;
}

/// Binary files may begin with "solid", too; their size identifies them.
bool is_ascii(std::string_view bytes) {
    const size_t start = bytes.find_first_not_of(" \t\r\n");
    const bool says_solid =
        start != std::string_view::npos && equal_ignoring_case(bytes.substr(start, 5), "solid");
    if (!says_solid) return false;
    return !has_size_of_binary(bytes) && bytes.substr(0, 1024).find('\0') == std::string_view::npos;
}

}  // namespace

Result<MeshSource> parse_stl(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes) {
    const bool marked = bytes.starts_with(kByteOrderMark);
    if (is_ascii(marked ? bytes.substr(kByteOrderMark.size()) : bytes)) {
        const PlainText plain(bytes);
        return AsciiReader(plain.text(), file, memory_bytes - plain.copied_bytes()).read();
    }
    if (const Complaint wide = not_utf8(bytes); !wide.empty() && !has_size_of_binary(bytes))
        return wide.at({file, 1, 1});
    if (bytes.size() < kHeader) {
        return user_error(fmt::format(messages::kNotStl, file, kHeader));
    }
    return parse_binary(bytes, file, memory_bytes);
}

}  // namespace openfab::mesh
