// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/program_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/near_miss.h"
#include "base/text.h"
#include "runtime/solid/messages.h"

namespace openfab::solid {

namespace {

constexpr int32_t kMostOfMesh = 1 << 24;  ///< vertices, triangles
constexpr size_t kShown = 60;             ///< bytes of a line in a message
constexpr size_t kLongestError = 2000;

/// The words of a line.
class Words {
  public:
    explicit Words(std::string_view line) : rest_(line) {}

    std::string_view next() {
        size_t n = 0;
        while (n < rest_.size() && is_blank(rest_[n]))
            ++n;
        rest_.remove_prefix(n);
        for (n = 0; n < rest_.size() && !is_blank(rest_[n]);)
            ++n;
        const std::string_view word = rest_.substr(0, n);
        rest_.remove_prefix(n);
        return word;
    }
    bool at_end() {
        Words after = *this;
        return after.next().empty();
    }
    size_t count() const {
        Words all = *this;
        size_t n = 0;
        while (!all.next().empty())
            ++n;
        return n;
    }
    template <typename T>
    bool number(T* out) {
        std::string_view word = next();
        if (word.starts_with('+')) word.remove_prefix(1);
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *out);
        if (word.empty() || error != std::errc() || end != word.data() + word.size()) return false;
        if constexpr (std::is_floating_point_v<T>) return std::isfinite(*out);
        return true;
    }
    bool point(Vec3f* p) { return number(&p->x) && number(&p->y) && number(&p->z); }
    std::string_view rest() const { return rest_; }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == ',' || c == '\r'; }

    std::string_view rest_;
};

class Reader {
  public:
    Reader(std::string_view text, const AnswerLayout& layout) : text_(text), layout_(layout) {}

    Result<ProgramAnswer> read() {
        while (next_line()) {
            Words words(line_);
            const std::string_view what = words.next();
            Result<void> fine;
            if (what.empty() || what.front() == '#') {
                continue;
            } else if (what == "beam" || what == "flat") {
                fine = beam(words, what == "flat" ? Kind::kFlat : Kind::kBeam);
            } else if (what == "place") {
                fine = place(words);
            } else if (what == "mesh") {
                fine = mesh(words);
            } else if (what == "more") {
                fine = more(words);
            } else if (what == "error") {
                return user_error(printable(
                    words.rest().substr(std::min<size_t>(1, words.rest().size()), kLongestError)));
            } else {
                fine =
                    error(fmt::format(messages::kNoKnownLine, shown()), messages::kNoKnownLineHelp);
            }
            if (!fine) return fine.error();
        }
        return std::move(out_);
    }

  private:
    using Kind = ProgramAnswer::Kind;

    bool next_line() {
        if (at_ >= text_.size()) return false;
        const size_t end = std::min(text_.find('\n', at_), text_.size());
        line_ = text_.substr(at_, end - at_);
        at_ = end + 1;
        ++number_;
        return true;
    }
    std::string shown() const { return printable(line_.substr(0, kShown)); }
    Error error(const std::string& what, const std::string& help) const {
        return user_error(fmt::format(messages::kAtLine, number_, what), help);
    }

    ProgramAnswer::Item& add(Kind kind) {
        ProgramAnswer::Item& item = out_.items.emplace_back();
        item.kind = kind;
        item.line = number_;
        return item;
    }

    /// Reads attributes to the end of the line; `ends`: of how many there are floats.
    bool values(Words* words, int32_t ends) {
        const auto n = static_cast<size_t>(layout_.floats);
        const size_t first = out_.floats.size();
        for (size_t i = 0; i < static_cast<size_t>(ends) * n; ++i) {
            if (!words->number(&out_.floats.emplace_back())) return false;
        }
        for (size_t i = 0; ends == 1 && i < n; ++i)
            out_.floats.push_back(out_.floats[first + i]);
        for (int32_t i = 0; i < layout_.ints; ++i) {
            int32_t value = 0;
            if (!words->number(&value)) return false;
            out_.ints.push_back(static_cast<uint32_t>(value));
        }
        return words->at_end();
    }
    /// Describes them in a message.
    std::string values_text(int32_t ends) const {
        std::string text;
        if (layout_.floats > 0)
            text += fmt::format(messages::kFloatAttributes, ends == 2 ? messages::kTwice : "",
                                layout_.floats, layout_.floats == 1 ? "" : "s",
                                ends == 2 ? messages::kOfEachEnd : "");
        if (layout_.ints > 0) text += fmt::format(messages::kIntAttributes, layout_.ints);
        return text;
    }

    Result<void> beam(Words words, Kind kind) {
        ProgramAnswer::Item& item = add(kind);
        if (!words.point(&item.end[0]) || !words.point(&item.end[1]) ||
            !words.number(&item.radius[0]) || !words.number(&item.radius[1]) ||
            !values(&words, 2)) {
            return error(fmt::format(messages::kNotABeam, shown()),
                         fmt::format(messages::kNotABeamHelp, kind == Kind::kFlat ? "flat" : "beam",
                                     values_text(2)));
        }
        if (item.radius[0] < 0 || item.radius[1] < 0 ||
            !(std::max(item.radius[0], item.radius[1]) > 0))
            return error(fmt::format(messages::kBeamRadii, shown(), item.radius[0], item.radius[1]),
                         messages::kBeamRadiiHelp);
        return {};
    }

    Result<void> place(Words words) {
        ProgramAnswer::Item& item = add(Kind::kPlace);
        const std::string name(words.next());
        const auto found = std::ranges::find(layout_.places, name);
        if (found == layout_.places.end()) {
            return error(
                fmt::format(messages::kPlaceUnlisted, shown(), printable(name.substr(0, kShown))),
                layout_.places.empty() ? messages::kPlaceUnlistedHelp
                                       : suggest(name, layout_.places));
        }
        item.which = static_cast<int32_t>(found - layout_.places.begin());
        const auto numbers = static_cast<size_t>(layout_.floats + layout_.ints);
        const size_t count = words.count();
        bool fine = words.point(&item.end[0]);
        item.axes = {Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}};
        if (count == 12 + numbers) {
            for (Vec3f& axis : item.axes)
                fine = fine && words.point(&axis);
        }
        if (!fine || !values(&words, 1)) {
            return error(fmt::format(messages::kNotAPlace, shown()),
                         fmt::format(messages::kNotAPlaceHelp, values_text(1)));
        }
        return {};
    }

    Result<void> mesh(Words words) {
        ProgramAnswer::Item& item = add(Kind::kMesh);
        item.which = static_cast<int32_t>(out_.meshes.size());
        int32_t vertices = 0, triangles = 0;
        if (!words.number(&vertices) || !words.number(&triangles) || !values(&words, 1))
            return error(fmt::format(messages::kNotAMesh, shown()),
                         fmt::format(messages::kNotAMeshHelp, values_text(1)));
        if (vertices < 4 || triangles < 4 || vertices > kMostOfMesh || triangles > kMostOfMesh)
            return error(fmt::format(messages::kMeshCounts, vertices, triangles),
                         fmt::format(messages::kMeshCountsHelp, kMostOfMesh));
        mesh::Mesh& mesh = out_.meshes.emplace_back();
        for (int32_t i = 0; i < vertices; ++i) {
            Vec3f p;
            if (Result<void> fine = numbers_of_mesh(messages::kVertex, i, &p.x, &p.y, &p.z); !fine)
                return fine;
            mesh.positions.push_back(vec_cast<double>(p));
        }
        for (int32_t i = 0; i < triangles; ++i) {
            std::array<int32_t, 3> t{};
            if (Result<void> fine = numbers_of_mesh(messages::kTriangle, i, &t[0], &t[1], &t[2]);
                !fine)
                return fine;
            for (const int32_t v : t) {
                if (v < 0 || v >= vertices)
                    return error(fmt::format(messages::kTriangleVertex, i, v),
                                 fmt::format(messages::kTriangleVertexHelp, vertices));
            }
            mesh.triangles.push_back(t);
        }
        return {};
    }

    template <typename T>
    Result<void> numbers_of_mesh(const char* what, int32_t i, T* a, T* b, T* c) {
        if (!next_line())
            return error(fmt::format(messages::kEndsInMesh, what, i), messages::kEndsInMeshHelp);
        Words words(line_);
        if (words.number(a) && words.number(b) && words.number(c) && words.at_end()) return {};
        return error(fmt::format(messages::kNotOfMesh, shown(), what, i), messages::kNotOfMeshHelp);
    }

    Result<void> more(Words words) {
        ProgramAnswer::More& more = out_.more.emplace_back();
        more.line = number_;
        more.key = words.next();
        if (!words.point(&more.box.lo) || !words.point(&more.box.hi) || !words.at_end())
            return error(fmt::format(messages::kNotAMore, shown()), messages::kNotAMoreHelp);
        if (more.key.size() >= kKeyBytes || more.key.find('\0') != std::string::npos)
            return error(fmt::format(messages::kKeyTooLong, more.key.size()),
                         fmt::format(messages::kKeyTooLongHelp, kKeyBytes - 1));
        if (more.box.empty())
            return error(fmt::format(messages::kCornersSwapped, shown()),
                         messages::kLowerCornerFirst);
        return {};
    }

    const std::string_view text_;
    const AnswerLayout& layout_;
    ProgramAnswer out_;
    std::string_view line_;
    size_t at_ = 0;
    int32_t number_ = 0;
};

}  // namespace

Result<ProgramAnswer> read_program_answer(std::string_view text, const AnswerLayout& layout) {
    return Reader(text, layout).read();
}

}  // namespace openfab::solid
