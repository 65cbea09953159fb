// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/off.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "base/color.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "mesh/model/mesh_assembly.h"
#include "mesh/model/mesh_memory.h"
#include "mesh/model/polygon.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {
namespace {

constexpr size_t kMostCorners = 4096;
constexpr size_t kMostWords = kMostCorners + 8;

bool ends_with_off(std::string_view word) {
    return lower_ascii(std::string(word)).ends_with("off");
}

/// What lines of vertices have, by the prefix of the header.
struct VertexKind {
    bool normal = false, color = false, uv = false;
    size_t numbers() const { return 3 + (normal ? 3 : 0); }
};

/// A colour as the text has it: what its numbers mean is known at the end.
struct TextColor {
    std::array<float, 4> values{0, 0, 0, 1};
};

/// How the words lie: a vertex or face on each line, or in a row that lines do not matter for, but at the end of a face's colour.
struct Layout {
    bool in_lines = true;
    size_t color_words = 4;   ///< of a vertex of a COFF
    bool face_colors = true;  ///< what follows a face on its line is its colour
};

// What fits first is taken; the numbers of vertices and faces tell.
constexpr std::array<Layout, 5> kLayouts{
    {{}, {false, 4, true}, {false, 4, false}, {false, 3, true}, {false, 3, false}}};

class OffReader {
  public:
    OffReader(std::string_view text, const std::string& file, int64_t memory_bytes, Layout layout)
        : text_(text), file_(file), memory_bytes_(memory_bytes), layout_(layout) {}

    Result<MeshSource> read() {
        read_header();
        if (!error_) reserve();
        for (int64_t v = 0; v < vertices_ && !error_; ++v)
            read_vertex(v);
        for (int64_t f = 0; f < faces_ && !error_; ++f)
            read_face(f);
        if (!error_ && more()) mesh_.leave_out(messages::kOffMore, place(), messages::kOffMoreHelp);
        if (error_) return *error_;
        if (!fits(static_cast<int64_t>(triangles_.size()))) return *error_;
        add_triangles();
        MeshSource source = mesh_.finish(file_, 0);
        source.origin.lines = std::move(lines_);
        return source;
    }

  private:
    void fail(const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = error_at({file_, line_number_, 1}, what, help);
    }
    std::string place() const { return fmt::format("{}:{}", file_, line_number_); }

    void take_line() {
        line_ = text_.substr(0, text_.find('\n'));
        text_.remove_prefix(std::min(line_.size() + 1, text_.size()));
        ++line_number_;
        line_ = line_.substr(0, line_.find('#'));
    }

    /// Adds what is left of the line to the words.
    void take_rest() {
        for (std::string_view word = take_word(&line_); !word.empty() && words_.size() < kMostWords;
             word = take_word(&line_))
            words_.push_back(word);
    }

    /// Goes to the next line with words; false at the end.
    bool next_line() {
        words_.clear();
        while (words_.empty() && !text_.empty()) {
            take_line();
            take_rest();
        }
        return !words_.empty();
    }

    /// Adds words, from as many lines as they are on; false at the end.
    bool take_words(size_t count) {
        while (count > 0) {
            const std::string_view word = take_word(&line_);
            if (word.empty() && text_.empty()) return false;
            if (word.empty())
                take_line();
            else
                words_.push_back(word), --count;
        }
        return true;
    }

    /// Goes to the next item, of `least` words or more; false at the end.
    bool next_item(size_t least) {
        if (layout_.in_lines) return next_line();
        words_.clear();
        return take_words(least);
    }

    bool more() {
        if (next_item(1) && !layout_.in_lines) fail(messages::kOffCounts);  // another layout
        return !words_.empty();
    }

    void read_header() {
        if (!next_item(1)) return fail(messages::kOffCounts);
        // A blank may lack between the name and the first count.
        const size_t ends = words_[0].find_last_not_of("0123456789") + 1;
        const bool joined = ends < words_[0].size() && ends_with_off(words_[0].substr(0, ends));
        if (joined) {
            words_.insert(words_.begin(), words_[0].substr(0, ends));
            words_[1].remove_prefix(ends);
        }
        if (ends_with_off(words_[0])) {
            std::string word = lower_ascii(std::string(words_[0]));
            word.resize(word.size() - 3);
            if (word.starts_with("st")) kind_.uv = true, word.erase(0, 2);
            if (word.starts_with("c")) kind_.color = true, word.erase(0, 1);
            if (word.starts_with("n")) kind_.normal = true, word.erase(0, 1);
            // Of any number of them, `n` is a small letter.
            if (!word.empty() || words_[0].ends_with("nOFF")) return fail(messages::kOffDimensions);
            words_.erase(words_.begin());
            if (words_.empty() && layout_.in_lines && !next_line())
                return fail(messages::kOffCounts);
        } else if (ends != 0) {
            return fail(fmt::format(messages::kOffName, words_[0]));
        }
        if (!layout_.in_lines) take_words(3 - std::min<size_t>(words_.size(), 3));
        // The number of edges, third, says nothing.
        if (words_.size() < 2) return fail(messages::kOffCounts);
        vertices_ = integer(0);
        faces_ = integer(1);
        // A line of each takes at least so much of the text.
        constexpr int64_t kShortestVertex = 6;
        const auto left = static_cast<int64_t>(text_.size() + line_.size());
        if (vertices_ > left / kShortestVertex + 1)
            return fail(
                fmt::format(messages::kOffTooMany, static_cast<double>(vertices_), "vertices"));
        if (faces_ > left / kShortestVertex + 1)
            return fail(fmt::format(messages::kOffTooMany, static_cast<double>(faces_), "faces"));
    }

    int64_t integer(size_t i) {
        int64_t value = 0;
        if (const std::string wrong = scan_integer(words_[i], 0, INT32_MAX, &value); !wrong.empty())
            fail(wrong);
        return value;
    }

    double number(size_t i) {
        double value = 0;
        if (const std::string wrong = scan_number(words_[i], &value); !wrong.empty()) fail(wrong);
        return value;
    }

    MeshCounts counts_of(int64_t triangles) const {
        MeshCounts counts;
        counts.vertices = vertices_;
        counts.triangles = triangles;
        counts.attributes = 2;
        return counts;
    }

    bool fits(int64_t triangles) {
        // Corners, lines and colours, until they are the mesh's; lists double, and are copied then.
        constexpr int64_t kBesideTriangle = 3 * (12 + 4 + 4 + 16),
                          kBesideVertex = 3 * (24 + 16 + 16);
        const int64_t needed = growing_bytes(mesh_bytes(counts_of(triangles))) +
                               triangles * kBesideTriangle + vertices_ * kBesideVertex;
        if (needed > memory_bytes_ && !error_)
            error_ = too_large_to_read(file_, triangles, needed, memory_bytes_);
        return !error_;
    }

    void reserve() {
        if (fits(faces_)) mesh_.reserve(counts_of(faces_));
    }

    void read_vertex(int64_t v) {
        const size_t all =
            kind_.numbers() + (kind_.color ? layout_.color_words : 0) + (kind_.uv ? 2 : 0);
        if (!next_item(all))
            return fail(fmt::format(messages::kOffEndsEarly, v, vertices_, "vertices"));
        const size_t least = kind_.numbers();
        if (words_.size() < least)
            return fail(fmt::format(messages::kOffVertex, words_.size(), least));
        const Vec3d p{number(0), number(1), number(2)};
        if (!is_position(p.x, p.y, p.z)) return fail(messages::kOffFar);
        positions_.push_back(p);
        mesh_.add_vertex(p);
        // Programs write colours of vertices under a plain `OFF`, too.
        const size_t beside = least + (kind_.uv ? 2 : 0);
        const size_t rest = std::max(words_.size(), beside) - beside;
        if (rest != 0 && rest != 3 && rest != 4)
            return fail(fmt::format(messages::kOffVertex, words_.size(), beside));
        if (rest != 0) {
            vertex_colors_.resize(positions_.size() - 1, -1);
            vertex_colors_.push_back(add_color(least, rest));
        }
        if (kind_.uv && words_.size() >= beside) {
            uv_.resize(positions_.size(), {0, 0});
            uv_.back() = {number(words_.size() - 2), number(words_.size() - 1)};
        }
    }

    int32_t add_color(size_t at, size_t count) {
        TextColor color;
        for (size_t c = 0; c < count; ++c) {
            color.values[c] = static_cast<float>(number(at + c));
            has_fractions_ =
                has_fractions_ || words_[at + c].find_first_of(".eE") != std::string_view::npos;
            largest_ = std::max(largest_, color.values[c]);
            least_ = std::min(least_, color.values[c]);
        }
        if (count < 4) color.values[3] = -1;
        colors_.push_back(color);
        return static_cast<int32_t>(colors_.size() - 1);
    }

    void read_face(int64_t f) {
        if (!next_item(1)) return fail(fmt::format(messages::kOffEndsEarly, f, faces_, "faces"));
        const auto count = static_cast<size_t>(integer(0));
        if (!layout_.in_lines && count <= kMostCorners && take_words(count) && layout_.face_colors)
            take_rest();
        // What is no face is another layout, or damage.
        if (count < (layout_.in_lines ? 1 : 3) || count > kMostCorners || words_.size() < count + 1)
            return fail(fmt::format(messages::kOffFace, words_.size() - 1));
        std::vector<int32_t> corners;
        std::vector<Vec3d> places;
        for (size_t c = 1; c <= count; ++c) {
            const int64_t v = integer(c);
            if (error_) return;
            if (v >= vertices_) return fail(fmt::format(messages::kOffNoVertex, v, vertices_));
            corners.push_back(static_cast<int32_t>(v));
            places.push_back(positions_[static_cast<size_t>(v)]);
        }
        if (count < 3)
            return mesh_.leave_out(messages::kOffEdges, place(), messages::kOffEdgesHelp);
        const size_t rest = words_.size() - count - 1;
        int32_t color = -1;
        if (rest == 1)
            mesh_.leave_out(messages::kOffColourMap, place(), messages::kOffColourMapHelp);
        if (rest == 2 || rest > 4) return fail(fmt::format(messages::kOffFaceColour, rest));
        if (rest > 1) color = add_color(count + 1, rest);
        const auto triangles = triangulate(places, &effort_);
        if (triangles.empty()) return fail(messages::kOffEffort);
        // Polygons are more triangles than faces.
        constexpr size_t kOften = 1 << 16;
        if (triangles_.size() / kOften != (triangles_.size() + triangles.size()) / kOften &&
            !fits(static_cast<int64_t>(triangles_.size())))
            return;
        for (const auto& triangle : triangles) {
            std::array<int32_t, 3> vertices{};
            for (size_t c = 0; c < 3; ++c)
                vertices[c] = corners[static_cast<size_t>(triangle[c])];
            triangles_.push_back(vertices);
            face_colors_.push_back(color);
            lines_.push_back(line_number_);
        }
    }

    /// Adds the triangles, now that the numbers of their colours are known to be of 255 or of 1.
    void add_triangles() {
        const bool of_one = has_fractions_ || largest_ <= 1;
        if (of_one && !has_fractions_ && !colors_.empty())
            mesh_.warnings().push_back(fmt::format(messages::kOffUnitColours, file_));
        if (least_ < 0) {
            mesh_.leave_out(messages::kOffNegativeColours, file_,
                            messages::kOffNegativeColoursHelp);
            vertex_colors_.clear();
            std::ranges::fill(face_colors_, -1);
        }
        FaceGroup colored;
        int32_t group = -1, plain = -1;
        for (size_t t = 0; t < triangles_.size(); ++t) {
            std::array<int32_t, 3> values{face_colors_[t], face_colors_[t], face_colors_[t]};
            for (size_t c = 0; c < 3 && face_colors_[t] < 0; ++c) {
                const auto v = static_cast<size_t>(triangles_[t][c]);
                values[c] = v < vertex_colors_.size() ? vertex_colors_[v] : -1;
            }
            const bool all = std::ranges::none_of(values, [](int32_t v) { return v < 0; });
            if (!all) {
                if (plain < 0) plain = mesh_.group_index({});
                mesh_.add_triangle(triangles_[t], plain);
                set_uv(triangles_[t]);
                continue;
            }
            if (group < 0) {
                Look look;
                look.name = "colours";
                look.is_material = false;
                look.vertex_colors = true;
                look.color = {1, 1, 1};
                colored.look = static_cast<int32_t>(mesh_.looks().size());
                mesh_.looks().push_back(std::move(look));
                group = mesh_.group_index(colored);
            }
            mesh_.add_triangle(triangles_[t], group);
            set_color(values, of_one ? 1 : 255);
            set_uv(triangles_[t]);
        }
    }

    void set_color(std::array<int32_t, 3> values, double unit) {
        if (!color_) color_ = mesh_.attribute("color", 3);
        numbers_.resize(colors_.size(), -1);
        for (int32_t& value : values) {
            int32_t& number = numbers_[static_cast<size_t>(value)];
            const std::array<float, 4>& color = colors_[static_cast<size_t>(value)].values;
            if (number < 0) {
                std::array<double, 3> linear{};
                for (size_t c = 0; c < 3; ++c)
                    linear[c] =
                        srgb_to_linear(std::clamp(static_cast<double>(color[c]) / unit, 0.0, 1.0));
                number = mesh_.add_value(*color_, linear.data());
            }
            if (color[3] >= 0 && static_cast<double>(color[3]) < unit && !clear_) {
                clear_ = true;
                mesh_.leave_out(messages::kTransparentColours, file_,
                                messages::kTransparentColoursHelp);
            }
            value = number;
        }
        mesh_.set_corners(*color_, values);
    }

    void set_uv(const std::array<int32_t, 3>& corners) {
        if (uv_.empty()) return;
        if (!uv_at_) uv_at_ = mesh_.attribute("uv", 2);
        std::array<int32_t, 3> values{-1, -1, -1};
        uv_numbers_.resize(uv_.size(), -1);
        for (size_t c = 0; c < 3; ++c) {
            const auto v = static_cast<size_t>(corners[c]);
            if (v >= uv_.size()) continue;
            if (uv_numbers_[v] < 0) uv_numbers_[v] = mesh_.add_value(*uv_at_, uv_[v].data());
            values[c] = uv_numbers_[v];
        }
        mesh_.set_corners(*uv_at_, values);
    }

    std::string_view text_, line_;  ///< what is not read yet, without the line that is being read
    const std::string& file_;
    int64_t memory_bytes_;
    Layout layout_;
    int32_t line_number_ = 0;
    std::vector<std::string_view> words_;
    VertexKind kind_;
    int64_t vertices_ = 0, faces_ = 0;
    std::vector<Vec3d> positions_;
    std::vector<TextColor> colors_;
    std::vector<int32_t> vertex_colors_, face_colors_;  ///< in colors_; -1: none
    std::vector<std::array<double, 2>> uv_;
    std::vector<std::array<int32_t, 3>> triangles_;
    std::vector<int32_t> lines_, numbers_;
    bool has_fractions_ = false, clear_ = false;
    float largest_ = 0, least_ = 0;
    int64_t effort_ = kTriangulationEffort;
    MeshAssembly mesh_;
    std::optional<size_t> color_, uv_at_;
    std::vector<int32_t> uv_numbers_;  ///< of `uv`, by vertex; -1: not yet
    std::optional<Error> error_;
};

}  // namespace

Result<MeshSource> parse_off(std::string_view bytes, const std::string& file,
                             int64_t memory_bytes) {
    std::string_view header = bytes.substr(0, bytes.find('\n'));
    if (ends_with_off(take_word(&header)) && take_word(&header) == "BINARY")
        return user_error(fmt::format("{}: {}", file, messages::kOffBinary));
    if (const Complaint wide = not_utf8(bytes); !wide.empty())
        return user_error(fmt::format("{}: {}", file, wide.what), wide.help);
    const PlainText plain(bytes);
    Result<MeshSource> first = user_error("");
    for (const Layout& layout : kLayouts) {
        Result<MeshSource> source =
            OffReader(plain.text(), file, memory_bytes - plain.copied_bytes(), layout).read();
        if (source) return source;
        if (&layout == kLayouts.data()) first = std::move(source);
    }
    return first;
}

}  // namespace openfab::mesh
