// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/obj_piece.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

/// Returns the unit that a comment states, in mm; 0 for other comments.
double unit_of(std::string_view line) {
    constexpr size_t kLongest = 60;
    if (line.size() > kLongest) return 0;
    std::vector<std::string> words(1);
    for (const char c : line) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        if (letter) {
            words.back() += lower_ascii(c);
        } else if (c == ' ' || c == '\t' || c == '\r' || c == ':' || c == '=' || c == '.') {
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

/// What a statement that makes no triangles is told as; kCount: nothing, it is a hint for display
/// (or a part of a free-form surface, which is told once). None: not a statement of OBJ.
std::optional<ObjLeftOut> ignored(std::string_view word) {
    using enum ObjLeftOut;
    static constexpr std::pair<std::string_view, ObjLeftOut> kWords[] = {
        {"s", kCount},          {"l", kLines},         {"p", kPoints},      {"lod", kCount},
        {"mg", kCount},         {"usemap", kMaps},     {"maplib", kMaps},   {"bevel", kCount},
        {"c_interp", kCount},   {"d_interp", kCount},  {"stech", kCount},   {"ctech", kCount},
        {"shadow_obj", kCount}, {"trace_obj", kCount}, {"vp", kParameters}, {"curv", kSurfaces},
        {"curv2", kSurfaces},   {"surf", kSurfaces},   {"cstype", kCount},  {"deg", kCount},
        {"bmat", kCount},       {"step", kCount},      {"parm", kCount},    {"trim", kCount},
        {"hole", kCount},       {"scrv", kCount},      {"sp", kCount},      {"end", kCount},
        {"con", kCount},        {"bzp", kSurfaces},    {"bsp", kSurfaces},  {"cdc", kSurfaces},
        {"cdp", kSurfaces},     {"res", kCount},       {"call", kCalls},    {"csh", kCalls}};
    for (const auto& [known, what] : kWords) {
        if (known == word) return what;
    }
    return {};
}

class PieceReader {
  public:
    PieceReader(std::string_view text, const ObjPart& part, const std::string& file)
        : lines_(text, part.begin, part.end, static_cast<int32_t>(part.before.newlines) + 1),
          tokens_(lines_.tokens()),
          before_(part.before),
          file_(file) {
        out_.positions.reserve(part.inside.vertices);
        out_.uv.reserve(part.inside.uv * 2);
        out_.normals.reserve(part.inside.normals * 3);
        out_.triangles.reserve(part.inside.faces);
        out_.uv_corners.reserve(part.inside.faces);
        out_.normal_corners.reserve(part.inside.faces);
        out_.lines.reserve(part.inside.faces);
    }

    ObjPiece read() {
        while (!out_.error && lines_.next_or_comment()) {
            if (!tokens_.empty()) {
                statement();
            } else {
                comment(lines_.comment());
            }
        }
        return std::move(out_);
    }

  private:
    void comment(std::string_view text) {
        if (out_.unit_mm == 0) out_.unit_mm = unit_of(text);
        if (text.starts_with("MRGB ")) leave_out(ObjLeftOut::kPolypaint);
    }

    void leave_out(ObjLeftOut what) {
        ObjFound& found = out_.left_out[static_cast<size_t>(what)];
        if (found.count++ == 0) found.line = lines_.line();
    }

    void statement() {
        const std::string_view word = tokens_[0];
        if (word == "v") {
            vertex();
        } else if (word == "vt") {
            numbers(&out_.uv, 1, 3, 2);
        } else if (word == "vn") {
            numbers(&out_.normals, 3, 3, 3);
        } else if (word == "f" || word == "fo") {
            face();
        } else if (word == "g" || word == "o" || word == "usemtl" || word == "mtllib") {
            out_.cuts.push_back({out_.triangles.size(), 0, lines_.start(), lines_.line()});
        } else if (const std::optional<ObjLeftOut> what = ignored(word)) {
            if (*what != ObjLeftOut::kCount) leave_out(*what);
        } else {
            fail(word, fmt::format(messages::kUnknownStatement, word.substr(0, 40)),
                 messages::kUnknownStatementHelp);
        }
    }

    void fail(std::string_view token, const std::string& what, const std::string& help = {}) {
        out_.error = error_at(lines_.location(token, file_), what, help);
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
        fail(tokens_[0], fmt::format(messages::kStatementNumbers, tokens_[0], tokens_.size() - 1),
             fmt::format(
                 messages::kStatementNumbersHelp,
                 least == most ? fmt::format("{}", least) : fmt::format("{} to {}", least, most)));
    }

    void vertex() {
        const size_t count = tokens_.size() - 1;
        if (count != 3 && count != 4 && count != 6 && count != 7) return wrong_count(3, 7);
        std::array<double, 7> v{};
        for (size_t i = 0; i < count; ++i) {
            if (!number(tokens_[i + 1], &v[i])) return;
        }
        if (vertices() >= kMaxObjElements) return fail(tokens_[0], messages::kTooManyVertices);
        out_.positions.push_back({v[0], v[1], v[2]});
        const bool weighted = count == 4 || count == 7;
        if (weighted && v[3] != 1) leave_out(ObjLeftOut::kWeights);
        if (count >= 6) {
            out_.colors.resize((out_.positions.size() - 1) * 3, NAN);
            for (size_t i = count - 3; i < count; ++i)
                out_.colors.push_back(static_cast<float>(v[i]));
        }
    }

    size_t vertices() const { return before_.vertices + out_.positions.size(); }

    /// Reads the index of an element; one of `lost` that is not there is left out.
    bool index(std::string_view token, std::string_view digits, size_t count,
               std::optional<ObjLeftOut> lost, int32_t* out) {
        int64_t value = 0;
        const auto [end, code] =
            std::from_chars(digits.data(), digits.data() + digits.size(), value);
        if (code != std::errc() || end != digits.data() + digits.size()) {
            fail(token, fmt::format(messages::kNotACorner, token.substr(0, 40)),
                 messages::kNotACornerHelp);
            return false;
        }
        const auto n = static_cast<int64_t>(count);
        const int64_t index = value < 0 ? n + value : value - 1;
        if (value == 0 || index < 0 || index >= n) {
            if (lost) {
                leave_out(*lost);
                return true;
            }
            fail(token, fmt::format(messages::kCornerOfNoVertex, token.substr(0, 40), value, n));
            return false;
        }
        *out = static_cast<int32_t>(index);
        return true;
    }

    bool corner(std::string_view token, ObjCorner* out) {
        std::array<std::string_view, 3> part;
        std::string_view left = token;
        for (size_t i = 0; i < 3; ++i) {
            const size_t slash = i < 2 ? left.find('/') : std::string_view::npos;
            part[i] = left.substr(0, slash);
            left = slash == std::string_view::npos ? std::string_view() : left.substr(slash + 1);
        }
        if (!index(token, part[0], vertices(), {}, &out->v)) return false;
        if (!part[1].empty() &&
            !index(token, part[1], before_.uv + out_.uv.size() / 2, ObjLeftOut::kUv, &out->vt))
            return false;
        return part[2].empty() || index(token, part[2], before_.normals + out_.normals.size() / 3,
                                        ObjLeftOut::kNormals, &out->vn);
    }

    void face() {
        const size_t count = tokens_.size() - 1;
        if (count < 3)
            return fail(tokens_[0], fmt::format(messages::kFaceOfTooFewCorners, count),
                        messages::kFaceOfTooFewCornersHelp);
        if (count > kMaxObjCorners)
            return fail(tokens_[0], fmt::format(messages::kFaceOfTooManyCorners, kMaxObjCorners));
        corners_.assign(count, {});
        for (size_t i = 0; i < count; ++i) {
            if (!corner(tokens_[i + 1], &corners_[i])) return;
        }
        if (count > 3) {
            out_.cuts.push_back({out_.triangles.size(), count, lines_.start(), lines_.line()});
            out_.corners.insert(out_.corners.end(), corners_.begin(), corners_.end());
            return;
        }
        const ObjCorner &a = corners_[0], &b = corners_[1], &c = corners_[2];
        out_.triangles.push_back({a.v, b.v, c.v});
        out_.uv_corners.push_back({a.vt, b.vt, c.vt});
        out_.normal_corners.push_back({a.vn, b.vn, c.vn});
        out_.lines.push_back(lines_.line());
    }

    ObjLines lines_;
    const std::vector<std::string_view>& tokens_;  ///< of the current line
    ObjCounts before_;
    const std::string& file_;
    ObjPiece out_;
    std::vector<ObjCorner> corners_;
};

}  // namespace

ObjPiece read_obj_piece(std::string_view text, const ObjPart& part, const std::string& file) {
    return PieceReader(text, part, file).read();
}

}  // namespace openfab::mesh
