// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/text/font.h"

#include <fmt/format.h>
#include <fontconfig/fontconfig.h>
#include <hb-ot.h>
#include <hb.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/say.h"
#include "base/text.h"
#include "tools/text/messages.h"

namespace openfab::text {
namespace {

constexpr double kTolerance = 1e-3;  // of a capital's height

/// Owns an object of a C library.
template <typename T, void (*Free)(T*)>
struct Freed {
    void operator()(T* object) const { Free(object); }
};
template <typename T, void (*Free)(T*)>
using Owned = std::unique_ptr<T, Freed<T, Free>>;

struct FoundFont {
    std::string file, name;
    int index = 0;           ///< in a file of several fonts
    int instance = 0;        ///< of a variable one, from 1; 0: none is named
    std::string variations;  ///< of its axes, `wght=700,wdth=80`
};

std::string text_of(const FcPattern* pattern, const char* property, int number) {
    FcChar8* text = nullptr;
    const bool is_there = FcPatternGetString(pattern, property, number, &text) == FcResultMatch;
    return is_there ? reinterpret_cast<const char*>(text) : "";
}

/// Checks the words after the family, as `bold` in `DejaVu Sans:bold`: Fontconfig skips those that it
/// does not know.
Result<void> check_styles(const std::string& name) {
    for (size_t at = name.find(':'); at != std::string::npos;) {
        const size_t next = name.find(':', at + 1);
        const std::string word = name.substr(at + 1, next - at - 1);
        at = next;
        int value = 0;
        if (word.empty() || word.find('=') != std::string::npos ||
            FcNameConstant(reinterpret_cast<const FcChar8*>(word.c_str()), &value))
            continue;
        return user_error(fmt::format(messages::kNoStyle, word), messages::kNoStyleHelp);
    }
    return {};
}

/// Checks that the font is of the wanted family, in whose place Fontconfig finds another where there is
/// none.
Result<void> check_family(const std::string& wanted, const FcPattern* found) {
    for (const char* generic : {"", "sans-serif", "sans", "serif", "monospace", "mono", "cursive",
                                "fantasy", "system-ui"}) {
        if (lower_ascii(wanted) == generic) return {};
    }
    for (int k = 0;; ++k) {
        const std::string family = text_of(found, FC_FAMILY, k);
        if (family.empty()) break;
        if (lower_ascii(family) == lower_ascii(wanted)) return {};
    }
    return user_error(fmt::format(messages::kNoFontFamily, wanted),
                      fmt::format(messages::kNoFontFamilyHelp, text_of(found, FC_FAMILY, 0)));
}

Result<FoundFont> find_font(const std::string& name) {
    std::error_code ignored;
    const auto is_file = [&](const std::string& path) {
        return std::filesystem::is_regular_file(path, ignored);
    };
    if (is_file(name)) return FoundFont{name, name, 0, 0, {}};
    for (size_t at = name.find(':'); at != std::string::npos; at = name.find(':', at + 1)) {
        if (!is_file(name.substr(0, at))) continue;
        std::string variations = name.substr(at + 1);
        std::replace(variations.begin(), variations.end(), ':', ',');
        return FoundFont{name.substr(0, at), name, 0, 0, variations};
    }
    if (name.find('/') != std::string::npos)
        return user_error(fmt::format(messages::kNoFontFile, name));
    const Owned<FcConfig, FcConfigDestroy> config(FcInitLoadConfigAndFonts());
    const Owned<FcPattern, FcPatternDestroy> wanted(
        FcNameParse(reinterpret_cast<const FcChar8*>(name.c_str())));
    if (config == nullptr || wanted == nullptr)
        return user_error(fmt::format(messages::kNotAFontName, name), messages::kNotAFontNameHelp);
    if (Result<void> known = check_styles(name); !known) return known.error();
    const std::string family = text_of(wanted.get(), FC_FAMILY, 0);
    FcConfigSubstitute(config.get(), wanted.get(), FcMatchPattern);
    FcDefaultSubstitute(wanted.get());
    FcPatternAddBool(wanted.get(), FC_SCALABLE, FcTrue);
    FcResult outcome = FcResultNoMatch;
    const Owned<FcPattern, FcPatternDestroy> found(
        FcFontMatch(config.get(), wanted.get(), &outcome));
    const std::string path = found == nullptr ? "" : text_of(found.get(), FC_FILE, 0);
    if (path.empty()) return outside_error(fmt::format(messages::kNoFontFor, name));
    if (Result<void> same = check_family(family, found.get()); !same) return same.error();
    int index = 0;
    FcPatternGetInteger(found.get(), FC_INDEX, 0, &index);
    const std::string full_name = text_of(found.get(), FC_FULLNAME, 0);
    constexpr int kInstances = 16;  // bits below that of the instance
    return FoundFont{path, full_name.empty() ? path : full_name, index & ((1 << kInstances) - 1),
                     (index >> kInstances) & 0x7FFF, text_of(found.get(), FC_FONT_VARIATIONS, 0)};
}

/// Sets the axes of a variable font, or says where it stands.
Result<void> set_axes(const FoundFont& found, hb_face_t* face, hb_font_t* font) {
    unsigned count = hb_ot_var_get_axis_count(face);
    std::vector<hb_ot_var_axis_info_t> axes(count);
    hb_ot_var_get_axis_infos(face, 0, &count, axes.data());
    const auto name_of = [](hb_tag_t tag) {
        std::string name(4, ' ');
        hb_tag_to_string(tag, name.data());
        return name;
    };
    std::string all;
    for (const hb_ot_var_axis_info_t& axis : axes)
        all += fmt::format("{}{} {:g} ({:g} to {:g})", all.empty() ? "" : ", ", name_of(axis.tag),
                           axis.default_value, axis.min_value, axis.max_value);
    if (found.variations.empty()) {
        if (found.instance > 0) {
            hb_font_set_var_named_instance(font, static_cast<unsigned>(found.instance - 1));
        } else if (!axes.empty()) {
            note(fmt::format(messages::kVariableFont, found.name, all, name_of(axes[0].tag)));
        }
        return {};
    }
    std::vector<hb_variation_t> values;
    for (size_t at = 0; at <= found.variations.size();) {
        const size_t end = std::min(found.variations.find(',', at), found.variations.size());
        const std::string word = found.variations.substr(at, end - at);
        at = end + 1;
        hb_variation_t value{};
        const auto is_axis = [&](const hb_ot_var_axis_info_t& axis) {
            return axis.tag == value.tag && value.value >= axis.min_value &&
                   value.value <= axis.max_value;
        };
        if (hb_variation_from_string(word.data(), static_cast<int>(word.size()), &value) == 0 ||
            std::none_of(axes.begin(), axes.end(), is_axis))
            return user_error(
                fmt::format(messages::kNoSetting, word, found.file),
                axes.empty() ? messages::kNotVariable : messages::kFontSettings + all);
        values.push_back(value);
    }
    hb_font_set_variations(font, values.data(), static_cast<unsigned>(values.size()));
    return {};
}

/// Collects the outlines of a glyph in the font's units, with curves cut into chords.
class OutlinePen {
  public:
    OutlinePen(double tolerance, Glyph* out) : tolerance_(tolerance), out_(*out) {}

    static hb_draw_funcs_t* functions() {
        static hb_draw_funcs_t* const functions = [] {
            hb_draw_funcs_t* made = hb_draw_funcs_create();
            hb_draw_funcs_set_move_to_func(made, &move_to, nullptr, nullptr);
            hb_draw_funcs_set_line_to_func(made, &line_to, nullptr, nullptr);
            hb_draw_funcs_set_quadratic_to_func(made, &quadratic_to, nullptr, nullptr);
            hb_draw_funcs_set_cubic_to_func(made, &cubic_to, nullptr, nullptr);
            hb_draw_funcs_set_close_path_func(made, &close_path, nullptr, nullptr);
            hb_draw_funcs_make_immutable(made);
            return made;
        }();
        return functions;
    }

  private:
    using Point = mesh::Point2;

    static OutlinePen& pen(void* data) { return *static_cast<OutlinePen*>(data); }

    static void move_to(hb_draw_funcs_t*, void* data, hb_draw_state_t*, float x, float y, void*) {
        pen(data).out_.emplace_back();
        pen(data).add({x, y});
    }
    static void line_to(hb_draw_funcs_t*, void* data, hb_draw_state_t*, float x, float y, void*) {
        pen(data).add({x, y});
    }
    static void quadratic_to(hb_draw_funcs_t*, void* data, hb_draw_state_t* state, float cx,
                             float cy, float x, float y, void*) {
        const Point a{state->current_x, state->current_y}, c{cx, cy}, b{x, y};
        // As a cubic, of which it is one.
        const auto third = [](const Point& end, const Point& control) {
            return Point{(end.x + 2 * control.x) / 3, (end.y + 2 * control.y) / 3};
        };
        pen(data).add_curve(a, third(a, c), third(b, c), b);
    }
    static void cubic_to(hb_draw_funcs_t*, void* data, hb_draw_state_t* state, float cx, float cy,
                         float dx, float dy, float x, float y, void*) {
        pen(data).add_curve({state->current_x, state->current_y}, {cx, cy}, {dx, dy}, {x, y});
    }
    static void close_path(hb_draw_funcs_t*, void* data, hb_draw_state_t*, void*) {
        mesh::Outline& outline = pen(data).out_.back();
        while (outline.size() > 1 && outline.back() == outline.front())
            outline.pop_back();
        if (outline.size() < 3) pen(data).out_.pop_back();  // of no area
    }

    void add(const Point& p) {
        mesh::Outline& outline = out_.back();
        if (outline.empty() || !(outline.back() == p)) outline.push_back(p);
    }

    /// In n equal steps of its parameter a curve is within |its second derivative| / (8 n^2) of its
    /// chords; that of a cubic is largest at an end.
    void add_curve(const Point& a, const Point& c, const Point& d, const Point& b) {
        const auto bend = [](const Point& p, const Point& q, const Point& r) {
            const double x = p.x - 2 * q.x + r.x, y = p.y - 2 * q.y + r.y;
            return 6 * std::sqrt(x * x + y * y);
        };
        const double most = std::max(bend(a, c, d), bend(c, d, b));
        const int steps =
            std::max(1, static_cast<int>(std::ceil(std::sqrt(most / (8 * tolerance_)))));
        for (int i = 1; i < steps; ++i) {
            const double t = static_cast<double>(i) / steps, s = 1 - t;
            const double wa = s * s * s, wc = 3 * s * s * t, wd = 3 * s * t * t, wb = t * t * t;
            add({wa * a.x + wc * c.x + wd * d.x + wb * b.x,
                 wa * a.y + wc * c.y + wd * d.y + wb * b.y});
        }
        add(b);
    }

    double tolerance_;
    Glyph& out_;
};

class HarfBuzzFont final : public Font {
  public:
    HarfBuzzFont(Owned<hb_font_t, hb_font_destroy> font, std::string name)
        : font_(std::move(font)), name_(std::move(name)) {}

    /// False where the font has no outlines.
    bool set_size(double capital_mm) {
        hb_codepoint_t glyph = 0;
        hb_glyph_extents_t extents{};
        double capital = 0;
        if (hb_font_get_nominal_glyph(font_.get(), 'H', &glyph) != 0 &&
            hb_font_get_glyph_extents(font_.get(), glyph, &extents) != 0)
            capital = std::abs(static_cast<double>(extents.height));
        // Fonts of symbols have no H.
        if (capital == 0)
            capital = 0.7 * static_cast<double>(hb_face_get_upem(hb_font_get_face(font_.get())));
        tolerance_ = kTolerance * capital;
        mm_ = capital_mm / capital;
        hb_font_extents_t line{};
        hb_font_get_extents_for_direction(font_.get(), HB_DIRECTION_LTR, &line);
        line_pitch_mm_ = mm_ * (line.ascender - line.descender + line.line_gap);
        return capital > 0 && line_pitch_mm_ > 0;
    }

    Result<std::vector<Glyph>> shape(const std::string& line) override {
        const Owned<hb_buffer_t, hb_buffer_destroy> buffer(hb_buffer_create());
        hb_buffer_add_utf8(buffer.get(), line.data(), static_cast<int>(line.size()), 0,
                           static_cast<int>(line.size()));
        hb_buffer_guess_segment_properties(buffer.get());
        hb_shape(font_.get(), buffer.get(), nullptr, 0);
        unsigned count = 0;
        const hb_glyph_info_t* infos = hb_buffer_get_glyph_infos(buffer.get(), &count);
        const hb_glyph_position_t* places = hb_buffer_get_glyph_positions(buffer.get(), &count);
        std::vector<Glyph> out;
        double x = 0, y = 0;
        for (unsigned i = 0; i < count; ++i) {
            if (infos[i].codepoint == 0) {
                const size_t at = infos[i].cluster;
                size_t end = at + 1;
                while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xC0) == 0x80)
                    ++end;
                return user_error(
                    fmt::format(messages::kFontHasNo, name_, line.substr(at, end - at)),
                    messages::kChooseAnotherFont);
            }
            Glyph glyph = outlines_of(infos[i].codepoint);
            for (mesh::Outline& outline : glyph) {
                for (mesh::Point2& p : outline)
                    p = {mm_ * (x + places[i].x_offset + p.x),
                         mm_ * (y + places[i].y_offset + p.y)};
            }
            if (!glyph.empty()) out.push_back(std::move(glyph));
            x += places[i].x_advance;
            y += places[i].y_advance;
        }
        return out;
    }

    double line_pitch_mm() const override { return line_pitch_mm_; }
    const std::string& name() const override { return name_; }

  private:
    Glyph outlines_of(hb_codepoint_t glyph) {
        Glyph out;
        OutlinePen pen(tolerance_, &out);
#if HB_VERSION_ATLEAST(7, 0, 0)
        hb_font_draw_glyph(font_.get(), glyph, OutlinePen::functions(), &pen);
#else
        hb_font_get_glyph_shape(font_.get(), glyph, OutlinePen::functions(), &pen);
#endif
        return out;
    }

    Owned<hb_font_t, hb_font_destroy> font_;
    std::string name_;
    double mm_ = 0;  ///< of a unit of the font
    double tolerance_ = 0;
    double line_pitch_mm_ = 0;
};

}  // namespace

Result<std::unique_ptr<Font>> Font::open(const std::string& name, double capital_mm) {
    Result<FoundFont> found = find_font(name);
    if (!found) return found.error();
    const Owned<hb_blob_t, hb_blob_destroy> blob(
        hb_blob_create_from_file_or_fail(found->file.c_str()));
    if (blob == nullptr) return outside_error(fmt::format(messages::kCannotReadFont, found->file));
    const Owned<hb_face_t, hb_face_destroy> face(
        hb_face_create(blob.get(), static_cast<unsigned>(found->index)));
    if (hb_face_get_glyph_count(face.get()) == 0)
        return user_error(fmt::format(messages::kNotAFont, found->file), messages::kNotAFontHelp);
    Owned<hb_font_t, hb_font_destroy> made(hb_font_create(face.get()));
    if (Result<void> set = set_axes(*found, face.get(), made.get()); !set) return set.error();
    auto font = std::make_unique<HarfBuzzFont>(std::move(made), found->name);
    if (!font->set_size(capital_mm))
        return user_error(fmt::format(messages::kNoOutlines, found->name));
    return std::unique_ptr<Font>(std::move(font));
}

}  // namespace openfab::text
