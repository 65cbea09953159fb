// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/text/text_shapes.h"

#include <fmt/compile.h>
#include <fmt/format.h>
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "backends/raster/png_encode.h"
#include "base/text.h"
#include "mesh/model/sweeps.h"
#include "tools/text/messages.h"
#include "tools/text/unite.h"

namespace openfab::text {
namespace {

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int32_t kMostPixels = 16'000;  // along a side: what FreeType's coordinates hold
constexpr int kPngLevel = 6;
constexpr size_t kMostCorners = 1'000'000;  // each takes about 1 kB, as a mesh and as its text

struct Box2 {
    mesh::Point2 lo{kFar, kFar}, hi{-kFar, -kFar};
    void add(const mesh::Point2& p) {
        lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
        hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
    }
    void add(const Glyph& glyph) {
        for (const mesh::Outline& outline : glyph) {
            for (const mesh::Point2& p : outline)
                add(p);
        }
    }
};

void move(Glyph* glyph, double x, double y) {
    for (mesh::Outline& outline : *glyph) {
        for (mesh::Point2& p : outline)
            p = {p.x + x, p.y + y};
    }
}

/// Appends the triangles of a mesh with the attributes of all primitives.
void append(const mesh::Mesh& part, mesh::Mesh* out) {
    if (out->triangles.empty()) {
        *out = part;
        return;
    }
    const auto first = static_cast<int32_t>(out->positions.size());
    out->positions.insert(out->positions.end(), part.positions.begin(), part.positions.end());
    for (std::array<int32_t, 3> t : part.triangles) {
        for (int32_t& corner : t)
            corner += first;
        out->triangles.push_back(t);
    }
    for (size_t a = 0; a < part.attributes.size(); ++a) {
        const mesh::MeshAttribute& from = part.attributes[a];
        mesh::MeshAttribute& to = out->attributes[a];
        to.faces.insert(to.faces.end(), from.faces.begin(), from.faces.end());
        if (from.is_int) continue;
        const auto value =
            static_cast<int32_t>(to.values.size() / static_cast<size_t>(to.components));
        to.values.insert(to.values.end(), from.values.begin(), from.values.end());
        for (std::array<int32_t, 3> corners : from.corners) {
            for (int32_t& corner : corners)
                corner += value;
            to.corners.push_back(corners);
        }
    }
}

/// FreeType's library, without a font: for its rasteriser.
class Rasteriser {
  public:
    Rasteriser() { FT_Init_FreeType(&library_); }
    ~Rasteriser() { FT_Done_FreeType(library_); }
    Rasteriser(const Rasteriser&) = delete;
    Rasteriser& operator=(const Rasteriser&) = delete;

    /// Draws an area whose points are in pixels from the lower left corner. `rows`: the top one first.
    bool draw(const Area& area, int32_t width, int32_t height, std::vector<uint8_t>* rows) {
        size_t points = 0;
        for (const mesh::Outline& outline : area)
            points += outline.size();
        if (points > std::numeric_limits<short>::max()) return false;
        FT_Outline outline{};
        if (FT_Outline_New(library_, static_cast<FT_UInt>(points), static_cast<FT_Int>(area.size()),
                           &outline) != 0)
            return false;
        size_t at = 0;
        for (size_t c = 0; c < area.size(); ++c) {
            for (const mesh::Point2& p : area[c]) {
                outline.points[at] = {std::lround(p.x * 64), std::lround(p.y * 64)};
                outline.tags[at++] = FT_CURVE_TAG_ON;
            }
            outline.contours[c] = static_cast<short>(at - 1);
        }
        outline.flags |= FT_OUTLINE_EVEN_ODD_FILL;
        Drawing drawing{rows, width, height};
        FT_Raster_Params params{};
        params.flags = FT_RASTER_FLAG_AA | FT_RASTER_FLAG_DIRECT | FT_RASTER_FLAG_CLIP;
        params.clip_box = {0, 0, width, height};
        params.gray_spans = &add_spans;
        params.user = &drawing;
        const bool drawn = FT_Outline_Render(library_, &outline, &params) == 0;
        FT_Outline_Done(library_, &outline);
        return drawn;
    }

  private:
    struct Drawing {
        std::vector<uint8_t>* rows;
        int32_t width, height;
    };
    /// Adds what an area covers of a row's pixels to what others cover of them.
    static void add_spans(int y, int count, const FT_Span* spans, void* user) {
        const Drawing& drawing = *static_cast<const Drawing*>(user);
        uint8_t* const row = drawing.rows->data() + int64_t{drawing.height - 1 - y} * drawing.width;
        for (const FT_Span& span : std::span(spans, static_cast<size_t>(count))) {
            for (int x = span.x; x < span.x + span.len; ++x)
                row[x] = static_cast<uint8_t>(std::min(row[x] + span.coverage, 255));
        }
    }

    FT_Library library_ = nullptr;
};

}  // namespace

Result<Layout> lay_out(Font* font, const std::string& text, Align align) {
    if (valid_utf8(text) != text) return user_error(messages::kNotUtf8);
    std::vector<std::vector<Glyph>> lines;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        Result<std::vector<Glyph>> line = font->shape(text.substr(begin, end - begin));
        if (!line) return line.error();
        lines.push_back(std::move(*line));
        begin = end + 1;
    }
    Layout layout;
    Box2 all;
    for (size_t l = 0; l < lines.size(); ++l) {
        Box2 box;
        for (const Glyph& glyph : lines[l])
            box.add(glyph);
        if (box.lo.x > box.hi.x) continue;  // of spaces
        const double x = align == Align::kLeft    ? -box.lo.x
                         : align == Align::kRight ? -box.hi.x
                                                  : -(box.lo.x + box.hi.x) / 2;
        for (Glyph& glyph : lines[l]) {
            move(&glyph, x, -static_cast<double>(l) * font->line_pitch_mm());
            all.add(glyph);
            layout.areas.push_back(std::move(glyph));
        }
    }
    if (layout.areas.empty()) return user_error(messages::kNoLetters);
    const double pitch = font->line_pitch_mm();
    layout.areas = unite(layout.areas, std::ldexp(pitch, -24), std::ldexp(pitch, -13));
    for (Area& area : layout.areas)
        move(&area, -(all.lo.x + all.hi.x) / 2, -(all.lo.y + all.hi.y) / 2);
    layout.size_mm = {all.hi.x - all.lo.x, all.hi.y - all.lo.y};
    return layout;
}

Result<mesh::Mesh> make_text_mesh(const Layout& layout, double depth_mm) {
    mesh::Mesh out;
    size_t corners = 0;
    for (const Area& area : layout.areas) {
        for (const mesh::Outline& outline : area)
            corners += outline.size();
    }
    if (corners > kMostCorners) {
        return user_error(fmt::format(messages::kTooManyCorners, corners, kMostCorners),
                          messages::kTooManyCornersHelp);
    }
    for (const Area& area : layout.areas) {
        size_t count = 0;
        for (const mesh::Outline& outline : area)
            count += outline.size();
        // Long words of a joined script have more.
        const bool few = count <= mesh::kMostOutlineCorners;
        if (const Result<void> fine = few ? mesh::check_outlines(area) : Ok{}; !fine) {
            return user_error(messages::kCannotBeDrawnOut + fine.error().message,
                              messages::kChooseAnotherFontWith);
        }
        append(mesh::make_extrusion(area, depth_mm), &out);
    }
    out.name = "text";
    mesh::MeshAttribute& uv = out.attributes[0];
    for (size_t t = 0; t < out.triangles.size(); ++t) {
        if (out.attributes[2].faces[t] == 2) continue;
        for (size_t c = 0; c < 3; ++c) {
            const Vec3d& p = out.positions[out.triangles[t][c]];
            float* value = &uv.values[static_cast<size_t>(uv.corners[t][c]) * 2];
            value[0] = static_cast<float>(p.x / layout.size_mm.x + 0.5);
            value[1] = static_cast<float>(p.y / layout.size_mm.y + 0.5);
        }
    }
    return out;
}

std::string obj_text(const mesh::Mesh& mesh) {
    std::string text;
    // About what its lines take: a longer text would be there twice while it grows.
    text.reserve(30 * mesh.positions.size() + 10 * mesh.attributes[0].values.size() +
                 7 * mesh.attributes[1].values.size() + 56 * mesh.triangles.size());
    const auto out = std::back_inserter(text);
    fmt::format_to(out, "# Made by OpenFab, in mm.\n");
    for (const Vec3d& p : mesh.positions)
        fmt::format_to(out, FMT_COMPILE("v {} {} {}\n"), static_cast<float>(p.x),
                       static_cast<float>(p.y), static_cast<float>(p.z));
    const mesh::MeshAttribute &uv = mesh.attributes[0], &n = mesh.attributes[1],
                              &face = mesh.attributes[2];
    for (size_t v = 0; v < uv.values.size(); v += 2)
        fmt::format_to(out, FMT_COMPILE("vt {} {}\n"), uv.values[v], uv.values[v + 1]);
    for (size_t v = 0; v < n.values.size(); v += 3)
        fmt::format_to(out, FMT_COMPILE("vn {} {} {}\n"), n.values[v], n.values[v + 1],
                       n.values[v + 2]);
    constexpr const char* kGroups[] = {"front", "back", "side"};
    for (int32_t group = 0; group < 3; ++group) {
        fmt::format_to(out, "g {}\n", kGroups[group]);
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            if (face.faces[t] != group) continue;
            fmt::format_to(out, "f");
            for (size_t c = 0; c < 3; ++c)
                fmt::format_to(out, FMT_COMPILE(" {}/{}/{}"), mesh.triangles[t][c] + 1,
                               uv.corners[t][c] + 1, n.corners[t][c] + 1);
            fmt::format_to(out, "\n");
        }
    }
    return text;
}

Result<Picture> draw_text(const Layout& layout, double dots_per_mm, double margin_mm) {
    const auto pixels = [&](double mm) { return std::ceil((mm + 2 * margin_mm) * dots_per_mm); };
    const double width = pixels(layout.size_mm.x), height = pixels(layout.size_mm.y);
    if (!(width <= kMostPixels && height <= kMostPixels)) {
        return user_error(fmt::format(messages::kPictureTooLarge, width, height, kMostPixels),
                          messages::kPictureTooLargeHelp);
    }
    Picture picture;
    picture.width = static_cast<int32_t>(width);
    picture.height = static_cast<int32_t>(height);
    const size_t row = static_cast<size_t>(picture.width);
    std::vector<uint8_t> grey(row * static_cast<size_t>(picture.height));
    Rasteriser rasteriser;
    for (Area area : layout.areas) {
        for (mesh::Outline& outline : area) {
            for (mesh::Point2& p : outline)
                p = {p.x * dots_per_mm + width / 2, p.y * dots_per_mm + height / 2};
        }
        if (!rasteriser.draw(area, picture.width, picture.height, &grey))
            return user_error(messages::kCannotBeDrawn, messages::kChooseAnotherFontWith);
    }
    std::vector<uint8_t> rows;
    rows.reserve(grey.size() + static_cast<size_t>(picture.height));
    for (int32_t y = 0; y < picture.height; ++y) {
        rows.push_back(0);
        const auto begin = grey.begin() + static_cast<std::ptrdiff_t>(row * static_cast<size_t>(y));
        rows.insert(rows.end(), begin, begin + static_cast<std::ptrdiff_t>(row));
    }
    raster::PngImage image;
    image.width = picture.width;
    image.height = picture.height;
    image.color = raster::PngColor::kGrey;
    image.rows = rows;
    image.pixels_per_metre_x = image.pixels_per_metre_y = dots_per_mm * 1000;
    picture.png = raster::encode_png(image, kPngLevel);
    if (picture.png.empty()) return outside_error(messages::kOutOfMemory);
    return picture;
}

}  // namespace openfab::text
