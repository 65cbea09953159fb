// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <unordered_set>

#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/polygon.h"

namespace openfab::mesh {
namespace {

constexpr size_t kMaxCorners = 4096;
constexpr size_t kMaxElements = 200'000'000;

bool is_blank(char c) {
    return c == ' ' || c == '\t' || c == '\r';
}

/// Indices of one corner of a face, from 0; -1 where it has none.
struct Corner {
    int32_t v = -1, vt = -1, vn = -1;
};

class ObjReader {
  public:
    ObjReader(std::string_view text, const std::string& file, int64_t memory_bytes)
        : text_(text), file_(file), memory_bytes_(memory_bytes) {}

    Result<MeshSource> read() {
        while (at_ < text_.size() && !error_) {
            read_line();
            const int64_t needed = growing_bytes(mesh_bytes(counts()));
            if (needed > memory_bytes_)
                return too_large_to_read(file_, counts().triangles, needed, memory_bytes_);
        }
        if (error_) return *error_;
        add_attributes();
        out_.mesh = std::move(mesh_);
        out_.origin = {file_, std::move(lines_)};
        return std::move(out_);
    }

  private:
    MeshCounts counts() const {
        MeshCounts out;
        // A quad's diagonal, as a key of a set.
        constexpr size_t kDiagonalVertices = 2;
        out.vertices =
            static_cast<int64_t>(mesh_.positions.size() + diagonals_.size() * kDiagonalVertices);
        out.triangles = static_cast<int64_t>(mesh_.triangles.size());
        out.values = static_cast<int64_t>(uv_.size() + normals_.size() + colors_.size());
        out.attributes = 3;
        out.group_bytes = out_.group_bytes() + names_bytes_;
        return out;
    }

    // One logical line with its tokens; a backslash at the end of a line continues it.
    void read_line() {
        line_start_ = at_;
        tokens_.clear();
        const int32_t first_line = line_;
        bool comment = false;
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '\n') {
                ++at_;
                ++line_;
                break;
            }
            if (comment || is_blank(c)) {
                ++at_;
            } else if (c == '#') {
                comment = true;
                if (tokens_.empty() && out_.unit_mm == 0) out_.unit_mm = unit_of(at_ + 1);
            } else if (c == '\\' && continues(at_ + 1)) {
                at_ = text_.find('\n', at_) + 1;
                ++line_;
            } else {
                const size_t start = at_;
                while (at_ < text_.size() && !is_blank(text_[at_]) && text_[at_] != '\n')
                    ++at_;
                // One more than any statement may have, to detect longer ones.
                if (tokens_.size() < kMaxCorners + 2)
                    tokens_.push_back(text_.substr(start, at_ - start));
            }
        }
        token_line_ = first_line;
        if (!tokens_.empty()) statement();
    }

    /// Returns the unit that a comment states, in mm; 0 for other comments.
    double unit_of(size_t start) const {
        constexpr size_t kLongest = 60;
        const std::string_view line =
            text_.substr(start, std::min(text_.find('\n', start), text_.size()) - start);
        if (line.size() > kLongest) return 0;
        std::vector<std::string> words(1);
        for (const char c : line) {
            const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
            if (letter) {
                words.back() += lower_ascii(c);
            } else if (is_blank(c) || c == ':' || c == '=' || c == '.') {
                if (!words.back().empty()) words.emplace_back();
            } else {
                return 0;
            }
        }
        std::erase(words, "");
        // `File units = inches`, `Units are cm`
        std::erase_if(words, [](const std::string& w) {
            return w == "file" || w == "model" || w == "scene" || w == "are" || w == "in";
        });
        const bool inches = line.ends_with("in") || line.ends_with("in\r");
        if (words.empty() || (words[0] != "unit" && words[0] != "units")) return 0;
        if (words.size() == 1 && inches) return 25.4;
        static constexpr std::pair<std::string_view, double> kUnits[] = {
            {"mm", 1},          {"millimeter", 1},  {"millimetre", 1}, {"cm", 10},
            {"centimeter", 10}, {"centimetre", 10}, {"m", 1000},       {"meter", 1000},
            {"metre", 1000},    {"um", 0.001},      {"micron", 0.001}, {"inch", 25.4},
            {"inches", 25.4},   {"foot", 304.8},    {"feet", 304.8},   {"ft", 304.8}};
        if (words.size() != 2) return 0;
        std::string_view word = words[1];
        for (const auto& [name, mm] : kUnits) {
            if (word == name || (word.ends_with('s') && word.substr(0, word.size() - 1) == name))
                return mm;
        }
        return 0;
    }

    bool continues(size_t behind) const {
        while (behind < text_.size() && text_[behind] == '\r')
            ++behind;
        return behind < text_.size() && text_[behind] == '\n';
    }

    void statement() {
        const std::string_view word = tokens_[0];
        if (word == "v") {
            vertex();
        } else if (word == "vt") {
            numbers(&uv_, 1, 3, 2);
        } else if (word == "vn") {
            numbers(&normals_, 3, 3, 3);
        } else if (word == "f" || word == "fo") {
            face();
        } else if (word == "g") {
            if (tokens_.size() > kMaxCorners)
                return fail(word, fmt::format("a face in more than {} groups", kMaxCorners));
            groups_.assign(tokens_.begin() + 1, tokens_.end());
            groups_number_ = number_of(groups_, &groups_numbers_);
            group_.reset();
        } else if (word == "usemtl") {
            material_.clear();
            if (tokens_.size() > 1) material_ = rest_of_line(tokens_[1]);
            material_number_ = number_of(material_, &material_numbers_);
            group_.reset();
        } else if (!is_ignored(word)) {
            fail(word, fmt::format("unknown statement `{}`", word.substr(0, 40)),
                 "not an OBJ file, or one with free-form surfaces, which are not supported");
        }
    }

    /// Lines, points, names, smoothing and display hints: nothing that makes a solid.
    static bool is_ignored(std::string_view word) {
        static constexpr std::string_view kWords[] = {
            "o",      "s",      "mtllib", "l",        "p",        "lod",        "mg",
            "usemap", "maplib", "bevel",  "c_interp", "d_interp", "shadow_obj", "trace_obj"};
        return std::find(std::begin(kWords), std::end(kWords), word) != std::end(kWords);
    }

    std::string rest_of_line(std::string_view first) const {
        const auto start = static_cast<size_t>(first.data() - text_.data());
        size_t end = std::min(text_.find('\n', start), text_.size());
        while (end > start && is_blank(text_[end - 1]))
            --end;
        return std::string(text_.substr(start, end - start));
    }

    void fail(std::string_view token, const std::string& what, const std::string& help = {}) {
        if (error_) return;
        const auto offset = static_cast<size_t>(token.data() - text_.data());
        const size_t line_start = text_.rfind('\n', offset == 0 ? 0 : offset - 1);
        const size_t start =
            offset == 0 || line_start == std::string_view::npos ? 0 : line_start + 1;
        int32_t column = 1;
        for (size_t i = start; i < offset; ++i)
            column += (static_cast<unsigned char>(text_[i]) & 0xC0) != 0x80;
        const auto extra = std::count(text_.begin() + static_cast<ptrdiff_t>(line_start_),
                                      text_.begin() + static_cast<ptrdiff_t>(offset), '\n');
        error_ = error_at({file_, static_cast<int32_t>(token_line_ + extra), column}, what, help);
    }

    bool number(std::string_view token, double* out) {
        const std::string wrong = scan_number(token, out);
        if (!wrong.empty()) fail(token, wrong);
        return wrong.empty();
    }

    /// Reads between `least` and `most` numbers and keeps `kept` of them, 0 where the line has
    /// fewer.
    void numbers(std::vector<float>* out, size_t least, size_t most, size_t kept) {
        const size_t count = tokens_.size() - 1;
        if (count < least || count > most) return wrong_count(least, most);
        for (size_t i = 0; i < std::max(count, kept); ++i) {
            double value = 0;
            if (i < count && !number(tokens_[i + 1], &value)) return;
            if (i < kept) out->push_back(static_cast<float>(value));
        }
    }

    void wrong_count(size_t least, size_t most) {
        fail(tokens_[0], fmt::format("`{}` has {} numbers", tokens_[0], tokens_.size() - 1),
             fmt::format("it takes {}", least == most ? fmt::format("{}", least)
                                                      : fmt::format("{} to {}", least, most)));
    }

    void vertex() {
        const size_t count = tokens_.size() - 1;
        if (count != 3 && count != 4 && count != 6 && count != 7) return wrong_count(3, 7);
        std::array<double, 7> v{};
        for (size_t i = 0; i < count; ++i) {
            if (!number(tokens_[i + 1], &v[i])) return;
        }
        if (mesh_.positions.size() >= kMaxElements) return fail(tokens_[0], "too many vertices");
        mesh_.positions.push_back({v[0], v[1], v[2]});
        if (count >= 6) {
            for (size_t i = count - 3; i < count; ++i)
                colors_.push_back(static_cast<float>(v[i]));
        }
    }

    bool index(std::string_view token, std::string_view digits, size_t count, const char* of,
               int32_t* out) {
        int64_t value = 0;
        const auto [end, code] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (code != std::errc() || end != digits.data() + digits.size()) {
            fail(token, fmt::format("`{}` is not a corner", token.substr(0, 40)),
                 "write it as v, v/vt, v//vn or v/vt/vn");
            return false;
        }
        const auto n = static_cast<int64_t>(count);
        const int64_t index = value < 0 ? n + value : value - 1;
        if (value == 0 || index < 0 || index >= n) {
            fail(token, fmt::format("`{}` refers to {} {}, but there are {} so far",
                                    token.substr(0, 40), of, value, n));
            return false;
        }
        *out = static_cast<int32_t>(index);
        return true;
    }

    bool corner(std::string_view token, Corner* out) {
        std::array<std::string_view, 3> part;
        std::string_view left = token;
        for (size_t i = 0; i < 3; ++i) {
            const size_t slash = i < 2 ? left.find('/') : std::string_view::npos;
            part[i] = left.substr(0, slash);
            left = slash == std::string_view::npos ? std::string_view() : left.substr(slash + 1);
        }
        if (!index(token, part[0], mesh_.positions.size(), "vertex", &out->v)) return false;
        if (!part[1].empty() &&
            !index(token, part[1], uv_.size() / 2, "texture coordinate", &out->vt))
            return false;
        return part[2].empty() || index(token, part[2], normals_.size() / 3, "normal", &out->vn);
    }

    void face() {
        const size_t count = tokens_.size() - 1;
        if (count < 3)
            return fail(tokens_[0], fmt::format("a face with {} corners", count),
                        "it needs 3 or more");
        if (count > kMaxCorners)
            return fail(tokens_[0], fmt::format("a face with more than {} corners", kMaxCorners));
        if (mesh_.triangles.size() >= kMaxElements) return fail(tokens_[0], "too many faces");
        corners_.resize(count);
        for (size_t i = 0; i < count; ++i) {
            corners_[i] = {};
            if (!corner(tokens_[i + 1], &corners_[i])) return;
        }
        if (count == 3) return add_triangle({0, 1, 2});
        // Two quads may share both ends of a diagonal; the second uses its other one, or four
        // triangles would meet there.
        if (count == 4 && !diagonals_.insert(edge_key(corners_[0].v, corners_[2].v)).second) {
            std::rotate(corners_.begin(), corners_.begin() + 1, corners_.end());
            diagonals_.insert(edge_key(corners_[0].v, corners_[2].v));
        }
        std::vector<Vec3d> points;
        for (const Corner& c : corners_)
            points.push_back(mesh_.positions[c.v]);
        const std::vector<std::array<int32_t, 3>> triangles = triangulate(points, &effort_);
        if (triangles.empty()) return fail(tokens_[0], kTooMuchEffort, kSplitPolygons);
        for (const auto& t : triangles)
            add_triangle(t);
    }

    static uint64_t edge_key(int32_t a, int32_t b) {
        return static_cast<uint64_t>(std::min(a, b)) << 32 | static_cast<uint64_t>(std::max(a, b));
    }

    void add_triangle(const std::array<int32_t, 3>& pick) {
        const auto at = [&](size_t i) -> const Corner& { return corners_[pick[i]]; };
        mesh_.triangles.push_back({at(0).v, at(1).v, at(2).v});
        uv_corners_.push_back({at(0).vt, at(1).vt, at(2).vt});
        normal_corners_.push_back({at(0).vn, at(1).vn, at(2).vn});
        lines_.push_back(token_line_);
        if (!group_) group_ = group_index();
        out_.face_groups.push_back(*group_);
    }

    /// A cache: statements that alternate between a few groups do not process all of their names
    /// again.
    int32_t group_index() {
        const auto [known, fresh] = group_of_.try_emplace({groups_number_, material_number_}, 0);
        if (fresh) known->second = out_.group_index({groups_, material_});
        return known->second;
    }

    template <typename Names>
    int32_t number_of(const Names& names, std::map<Names, int32_t>* numbers) {
        const auto [known, fresh] =
            numbers->try_emplace(names, static_cast<int32_t>(numbers->size()) + 1);
        if (fresh) names_bytes_ += kNodeBytes + bytes_of(names);
        return known->second;
    }
    static int64_t bytes_of(const std::string& name) {
        return static_cast<int64_t>(sizeof name + name.size());
    }
    static int64_t bytes_of(const std::vector<std::string>& names) {
        int64_t bytes = sizeof names;
        for (const std::string& name : names)
            bytes += bytes_of(name);
        return bytes;
    }

    void add_float(const char* name, int32_t components, std::vector<float> values,
                   std::vector<std::array<int32_t, 3>> corners) {
        MeshAttribute a;
        a.name = name;
        a.components = components;
        a.values = std::move(values);
        a.corners = std::move(corners);
        mesh_.attributes.push_back(std::move(a));
    }

    void add_attributes() {
        add_float("uv", 2, std::move(uv_), std::move(uv_corners_));
        add_float("n", 3, std::move(normals_), std::move(normal_corners_));
        if (!colors_.empty() && colors_.size() == mesh_.positions.size() * 3) {
            add_float("color", 3, std::move(colors_), mesh_.triangles);
        }
    }

    std::string_view text_;
    const std::string& file_;
    int64_t memory_bytes_;
    int64_t effort_ = kTriangulationEffort;
    size_t at_ = 0;
    size_t line_start_ = 0;
    int32_t line_ = 1;
    int32_t token_line_ = 1;
    std::vector<std::string_view> tokens_;
    std::optional<Error> error_;

    MeshSource out_;
    Mesh mesh_;
    std::vector<float> uv_, normals_, colors_;
    std::vector<std::array<int32_t, 3>> uv_corners_, normal_corners_;
    std::vector<int32_t> lines_;  ///< by triangle
    std::vector<Corner> corners_;
    std::unordered_set<uint64_t> diagonals_;  ///< of quads, by their ends
    std::vector<std::string> groups_;
    std::string material_;
    std::optional<int32_t> group_;  ///< index of the current names among the groups
    static constexpr int64_t kNodeBytes = 64;
    std::map<std::vector<std::string>, int32_t> groups_numbers_;  ///< of `g` statements; 0: none
    std::map<std::string, int32_t> material_numbers_;
    int32_t groups_number_ = 0, material_number_ = 0;  ///< of the current names
    std::map<std::pair<int32_t, int32_t>, int32_t> group_of_;
    int64_t names_bytes_ = 0;  ///< of both tables
};

}  // namespace

Result<MeshSource> parse_obj(std::string_view text, const std::string& file, int64_t memory_bytes) {
    return ObjReader(text, file, memory_bytes).read();
}

}  // namespace openfab::mesh
