// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/trays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/json_text.h"
#include "tools/specimens/messages.h"

namespace openfab::specimens {

namespace {

/// How far digits stand out, and how deep they are rooted.
constexpr double kOutMm = 0.4, kRootMm = 0.5;
/// Flat ones on bars too thin for digits at their ends; grips must not press on them.
constexpr double kFlatMm = 0.2;
constexpr double kThinMm = 1.9, kLargestCellMm = 0.6, kFill = 0.85;

/// Turns about x, y and z, in this order, that lie a piece along an axis of the tray.
Vec3d turn_of(const Trays& request) {
    if (request.piece->is_disc()) {
        return request.along == 'x'   ? Vec3d{0, -90, 0}
               : request.along == 'y' ? Vec3d{90, 0, 0}
                                      : Vec3d{};
    }
    return request.along == 'x'   ? Vec3d{}
           : request.along == 'y' ? Vec3d{0, 0, 90}
                                  : Vec3d{0, -90, 0};
}

Vec3d turned(Vec3d p, const Vec3d& turn) {
    for (int axis = 0; axis < 3; ++axis) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        if (turn[axis] == 0) continue;
        const double sign = turn[axis] > 0 ? 1 : -1;
        const double from_a = p[a], from_b = p[b];
        p[a] = -sign * from_b;
        p[b] = sign * from_a;
    }
    return p;
}

struct Box {
    Vec3d low, high;
};

struct Label {
    double cell = 0, depth = 0;
    Vec3d turn_deg, place;
};

/// Digits at the end of a bar, or on the side of a disc, are read with the piece's top up; flat ones have their top at
/// the end.
Label label_of(const Trays& request, int number) {
    const Piece& piece = *request.piece;
    const Corner size = digits_size(number);
    Label out;
    if (!piece.is_disc() && request.thickness_mm < kThinMm) {
        out.cell =
            std::min({kFill * piece.ends_mm / size.x, piece.ends_mm / 2 / size.y, kLargestCellMm});
        out.depth = 2 * kFlatMm;
        out.turn_deg = {0, 0, -90};
        out.place = {piece.overall_mm / 2 - (size.y + 1) * out.cell, size.x * out.cell / 2,
                     request.thickness_mm - kFlatMm};
        return out;
    }
    const double across = piece.is_disc() ? piece.overall_mm / 2 : piece.ends_mm;
    out.cell =
        std::min({kFill * request.thickness_mm / size.y, kFill * across / size.x, kLargestCellMm});
    // The side of a disc is behind its foremost point there.
    const double half = size.x * out.cell / 2, radius = piece.overall_mm / 2;
    const double behind = piece.is_disc() ? radius - std::sqrt(radius * radius - half * half) : 0;
    out.depth = kOutMm + kRootMm + behind;
    out.turn_deg = {90, 0, 90};
    out.place = {radius - kRootMm - behind, -half, (request.thickness_mm - size.y * out.cell) / 2};
    return out;
}

Box box_of(const Trays& request) {
    const Piece& piece = *request.piece;
    const double half = piece.overall_mm / 2;
    const double side = piece.is_disc() ? half : piece.ends_mm / 2;
    const bool flat = !piece.is_disc() && request.thickness_mm < kThinMm;
    return {{-half, -side, 0},
            {half + (flat ? 0 : kOutMm), side, request.thickness_mm + (flat ? kFlatMm : 0)}};
}

void write_polygon(const std::vector<Corner>& polygon, double scale, JsonText* out) {
    out->begin_list();
    for (const Corner& p : polygon)
        out->begin_list()
            .value(std::round(p.x * scale * 1e6) / 1e6)
            .value(std::round(p.y * scale * 1e6) / 1e6)
            .end_array();
    out->end_array();
}

void write_vector(std::string_view key, const Vec3d& v, JsonText* out) {
    out->key(key).begin_list().value(v.x).value(v.y).value(v.z).end_array();
}

class World {
  public:
    explicit World(const Trays& request) : request_(request) {}

    /// `list` are the pieces of this tray, at the lowest corners `places`.
    std::string text(const std::vector<Specimen>& list, const std::vector<Corner>& places) {
        JsonText out(JsonText::Layout::kIndentedLists);
        out.begin_object().member("openfab", 1).member("printer", request_.printer);
        if (request_.tray_mm.x > 0) out.member("tray", "corner");
        out.key("fablets").begin_object();
        write_fablet("specimen", request_.source, request_.fablet, &out);
        write_fablet("label", "label.fl", "Specimen", &out);
        out.end_object();
        out.key("materials").value(parse_json(request_.materials, "materials").value());
        out.key("meshes").begin_object();
        write_piece(&out);
        for (const Specimen& one : list)
            write_label_mesh(one.label, &out);
        out.end_object().key("objects").begin_object();
        for (const Specimen& one : list)
            write_objects(one.label, &out);
        out.end_object().key("groups").begin_object();
        for (const Specimen& one : list)
            write_group(one.label, &out);
        out.end_object().key("build").begin_array();
        for (size_t i = 0; i < list.size(); ++i)
            write_place(list[i].label, places[i], &out);
        return out.end_array().end_object().take() + "\n";
    }

  private:
    static void write_fablet(const char* name, const std::string& source, const std::string& fablet,
                             JsonText* out) {
        out->key(name)
            .begin_object()
            .member("source", source)
            .member("fablet", fablet)
            .end_object();
    }
    void write_piece(JsonText* out) const {
        const Piece& piece = *request_.piece;
        out->key("piece").begin_object();
        if (piece.is_disc()) {
            out->key("cylinder")
                .begin_list()
                .value(piece.overall_mm)
                .value(request_.thickness_mm)
                .end_array();
        } else {
            out->key("extrusion").begin_object().key("polygons").begin_array();
            write_polygon(outline(piece), 1, out);
            out->end_array().member("height", request_.thickness_mm).end_object();
        }
        out->end_object();
    }
    void write_label_mesh(int number, JsonText* out) const {
        const Label label = label_of(request_, number);
        out->key(fmt::format("label {}", number))
            .begin_object()
            .key("extrusion")
            .begin_object()
            .key("polygons")
            .begin_array();
        for (const std::vector<Corner>& polygon : digits(number))
            write_polygon(polygon, label.cell, out);
        out->end_array().member("height", label.depth).end_object().end_object();
    }
    void write_objects(int number, JsonText* out) const {
        // The piece has the higher priority, so that labels change nothing but what stands out.
        out->key(fmt::format("{}", number))
            .begin_object()
            .member("mesh", "piece")
            .member("fablet", "specimen")
            .member("priority", 1)
            .key("uniforms")
            .begin_object();
        for (const auto& [name, value] : request_.uniforms)
            out->key(name).value(parse_json(value, name).value());
        const size_t variant = static_cast<size_t>(number - 1) % request_.variants.size();
        for (const auto& [name, value] : request_.variants[variant])
            out->key(name).value(parse_json(value, name).value());
        out->end_object().end_object();
        out->key(fmt::format("label {}", number))
            .begin_object()
            .member("mesh", fmt::format("label {}", number))
            .member("fablet", "label")
            .key("uniforms")
            .begin_object();
        out->key("materials").begin_list().value(request_.label_material).end_array();
        out->key("shares").begin_list().value(1).end_array();
        out->end_object().end_object();
    }
    void write_group(int number, JsonText* out) const {
        const Label label = label_of(request_, number);
        out->key(fmt::format("specimen {}", number)).begin_array();
        out->begin_object().member("object", fmt::format("{}", number)).end_object();
        out->begin_object().member("object", fmt::format("label {}", number));
        write_vector("rotate_deg", label.turn_deg, out);
        write_vector("translate_mm", label.place, out);
        out->end_object().end_array();
    }
    void write_place(int number, const Corner& corner, JsonText* out) const {
        out->begin_object().member("group", fmt::format("specimen {}", number));
        write_vector("rotate_deg", turn_of(request_), out);
        out->key("translate_mm").begin_list().value(corner.x).value(corner.y).end_array();
        out->end_object();
    }

    const Trays& request_;
};

}  // namespace

Result<MadeTrays> make_trays(const Trays& request) {
    const Box box = box_of(request);
    const Vec3d turn = turn_of(request);
    const Vec3d one = turned(box.low, turn), other = turned(box.high, turn);
    const Vec3d low{std::min(one.x, other.x), std::min(one.y, other.y), std::min(one.z, other.z)};
    const Vec3d size{std::abs(one.x - other.x), std::abs(one.y - other.y),
                     std::abs(one.z - other.z)};
    const size_t kinds = request.variants.size();
    const size_t all = kinds * static_cast<size_t>(request.copies);
    size_t columns = all, rows = all;
    if (request.tray_mm.x > 0) {
        const Vec3d& tray = request.tray_mm;
        const auto fits = [&](double room, double length) {
            return room < length
                       ? size_t{0}
                       : 1 + static_cast<size_t>((room - length) / (length + request.gap_mm));
        };
        columns = fits(tray.x, size.x);
        rows = fits(tray.y, size.y);
        if (columns == 0 || rows == 0 || tray.z < size.z) {
            return user_error(fmt::format(messages::kPieceTooLarge, request.piece->name, size.x,
                                          size.y, size.z, request.printer, tray.x, tray.y, tray.z),
                              messages::kPieceTooLargeHelp);
        }
    } else {
        columns = static_cast<size_t>(
            std::max(1.0, std::round(std::sqrt(static_cast<double>(all) * size.y / size.x))));
    }
    MadeTrays out;
    out.list.piece = request.piece;
    out.list.columns = request.columns;
    out.list.mixtures = request.mixtures;
    World world(request);
    const size_t on_tray = columns * std::min(rows, (all + columns - 1) / columns);
    for (size_t first = 0; first < all; first += on_tray) {
        std::vector<Specimen> list;
        std::vector<Corner> places;
        for (size_t i = first; i < std::min(all, first + on_tray); ++i) {
            Specimen specimen;
            specimen.label = static_cast<int>(i + 1);
            specimen.tray = static_cast<int>(out.worlds.size() + 1);
            const Piece& piece = *request.piece;
            specimen.width_mm = piece.is_disc() ? piece.overall_mm : piece.narrow_mm;
            specimen.thickness_mm = request.thickness_mm;
            specimen.values = request.values[i % kinds];
            list.push_back(std::move(specimen));
            const size_t k = i - first;
            places.push_back(
                {static_cast<double>(k % columns) * (size.x + request.gap_mm) - low.x,
                 static_cast<double>(k / columns) * (size.y + request.gap_mm) - low.y});
        }
        out.worlds.push_back(world.text(list, places));
        out.list.specimens.insert(out.list.specimens.end(), list.begin(), list.end());
    }
    return out;
}

}  // namespace openfab::specimens
