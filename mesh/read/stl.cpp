// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/stl.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_memory.h"

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

Result<MeshSource> parse_binary(std::string_view bytes, const std::string& file,
                                int64_t memory_bytes) {
    const uint32_t count = facets_of(bytes);
    if ((bytes.size() - kHeader) / kFacet < count) {
        return user_error(
            fmt::format("{}: binary STL that declares {} triangles but ends after {}; it was cut "
                        "short, or is not STL",
                        file, count, (bytes.size() - kHeader) / kFacet));
    }
    const int64_t needed = mesh_bytes({int64_t{count} * 3, count, count, 0, 0});
    if (needed > memory_bytes) return too_large_to_read(file, count, needed, memory_bytes);
    MeshSource out;
    out.origin.file = file;
    MeshAttribute extra;
    extra.name = "attribute";
    extra.is_int = true;
    bool any_extra = false;
    out.mesh.positions.reserve(size_t{count} * 3);
    out.mesh.triangles.reserve(count);
    extra.faces.reserve(count);
    for (size_t t = 0; t < count; ++t) {
        const char* facet = bytes.data() + kHeader + t * kFacet;
        float corners[9];
        uint16_t value = 0;
        std::memcpy(corners, facet + 12, sizeof corners);
        std::memcpy(&value, facet + 48, sizeof value);
        for (size_t i = 0; i < 9; i += 3) {
            if (!is_position(corners[i], corners[i + 1], corners[i + 2])) {
                return user_error(
                    fmt::format("{}: triangle {} has a corner that is not finite", file, t + 1));
            }
            out.mesh.positions.push_back({corners[i], corners[i + 1], corners[i + 2]});
        }
        const auto v = static_cast<int32_t>(t * 3);
        out.mesh.triangles.push_back({v, v + 1, v + 2});
        extra.faces.push_back(value);
        any_extra = any_extra || value != 0;
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
        int32_t group = -1;
        for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
            Result<void> done = Ok{};
            if (equal_ignoring_case(word, "solid")) {
                const std::string name(words_.rest_of_line());
                FaceGroup solid;
                if (!name.empty()) solid.names.push_back(name);
                group = out_.group_index(solid);
            } else if (equal_ignoring_case(word, "endsolid")) {
                words_.rest_of_line();
            } else if (equal_ignoring_case(word, "facet") && group >= 0) {
                done = facet(group);
            } else {
                done = words_.error(
                    fmt::format("`{}` where `facet` or `endsolid` should be", word.substr(0, 40)));
            }
            if (!done) return done.error();
            const MeshCounts counts = counts_of(out_);
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
            return words_.error(fmt::format("the file ends where `{}` should be", wanted),
                                "it was cut short");
        return words_.error(fmt::format("`{}` where `{}` should be", word.substr(0, 40), wanted));
    }

    Result<Vec3d> numbers() {
        Vec3d v;
        for (int a = 0; a < 3; ++a) {
            const std::string wrong = scan_number(words_.next(), &v[a]);
            if (!wrong.empty()) return words_.error(wrong);
        }
        return v;
    }

    Result<void> facet(int32_t group) {
        out_.origin.lines.push_back(words_.line());
        out_.face_groups.push_back(group);
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
};

/// Binary files may begin with "solid", too; their size identifies them.
bool is_ascii(std::string_view bytes) {
    const size_t start = bytes.find_first_not_of(" \t\r\n");
    const bool says_solid =
        start != std::string_view::npos && equal_ignoring_case(bytes.substr(start, 5), "solid");
    if (!says_solid) return false;
    const bool size_of_binary =
        bytes.size() >= kHeader && bytes.size() - kHeader == size_t{facets_of(bytes)} * kFacet;
    return !size_of_binary && bytes.substr(0, 1024).find('\0') == std::string_view::npos;
}

}  // namespace

Result<MeshSource> parse_stl(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes) {
    if (is_ascii(bytes)) return AsciiReader(bytes, file, memory_bytes).read();
    if (bytes.size() < kHeader) {
        return user_error(fmt::format(
            "{}: not an STL file: it neither starts with `solid` nor is as long as a binary "
            "header ({} bytes)",
            file, kHeader));
    }
    return parse_binary(bytes, file, memory_bytes);
}

}  // namespace openfab::mesh
