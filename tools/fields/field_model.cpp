// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/field_model.h"

#include <fmt/format.h>

#include <iterator>

#include "backends/common/xml_text.h"
#include "mesh/read/threemf_fields.h"

namespace openfab::tools {

namespace {

std::string field_text(const ModelField& field) {
    return fmt::format(
        "functionid=\"{}\" channel=\"{}\"{}", field.function, field.channel,
        field.transform.empty() ? "" : fmt::format(" transform=\"{}\"", field.transform));
}

std::string material_text(int materials) {
    return materials > 0 ? fmt::format(" pid=\"{}\" pindex=\"0\"", materials) : "";
}

}  // namespace

std::string transform_text(const Affine3d& map) {
    std::string out;
    for (size_t column = 0; column < 3; ++column) {
        for (size_t row = 0; row < 3; ++row)
            out += fmt::format("{} ", map.m[3 * row + column]);
    }
    return out + fmt::format("{} {} {}", map.t.x, map.t.y, map.t.z);
}

int FieldModel::add_materials(const std::vector<ModelMaterial>& materials) {
    const int id = next_id();
    resources_ += fmt::format("<basematerials id=\"{}\">", id);
    for (const ModelMaterial& one : materials)
        resources_ += fmt::format("<base name=\"{}\" displaycolor=\"#{:02X}{:02X}{:02X}{:02X}\"/>",
                                  backends::escape_xml(one.name), one.color[0], one.color[1],
                                  one.color[2], one.color[3]);
    resources_ += "</basematerials>\n";
    return id;
}

int FieldModel::add_image(const std::vector<std::string>& sheets, int32_t columns, int32_t rows) {
    has_functions_ = true;
    const int id = next_id();
    resources_ += fmt::format(
        "<v:image3d id=\"{}\"><v:imagestack rowcount=\"{}\" columncount=\"{}\" "
        "sheetcount=\"{}\">\n",
        id, rows, columns, sheets.size());
    for (const std::string& sheet : sheets)
        resources_ += fmt::format("<v:imagesheet path=\"/{}\"/>\n", sheet);
    resources_ += "</v:imagestack></v:image3d>\n";
    return id;
}

int FieldModel::add_image_function(int image, double offset, double scale) {
    const int id = next_id();
    resources_ += fmt::format(
        "<v:functionfromimage3d id=\"{}\" image3did=\"{}\" valueoffset=\"{}\" valuescale=\"{}\" "
        "tilestyleu=\"clamp\" tilestylev=\"clamp\" tilestylew=\"clamp\" filter=\"linear\"/>\n",
        id, image, offset, scale);
    return id;
}

int FieldModel::add_volume(const ModelVolume& volume, int materials) {
    has_functions_ = true;
    const int id = next_id();
    resources_ += fmt::format("<v:volumedata id=\"{}\">\n", id);
    if (composite_) {
        resources_ += fmt::format("<v:composite basematerialid=\"{}\">\n", materials);
        for (const ModelField& share : volume.shares)
            resources_ += fmt::format("<v:materialmapping {}/>\n", field_text(share));
        resources_ += "</v:composite>\n";
    }
    for (const ModelField& color : volume.color)
        resources_ += fmt::format("<v:color {}/>\n", field_text(color));
    for (size_t i = 0; i < volume.shares.size() && !composite_; ++i)
        resources_ += fmt::format("<v:property name=\"{}{}\" {} required=\"false\"/>\n",
                                  mesh::kThreemfShare, i, field_text(volume.shares[i]));
    resources_ += "</v:volumedata>\n";
    return id;
}

int FieldModel::add_mesh(const std::string& name, const std::vector<Vec3d>& points,
                         const std::vector<std::array<int32_t, 3>>& triangles, int materials,
                         int volume) {
    const int id = next_id();
    auto to = std::back_inserter(resources_);
    fmt::format_to(to, "<object id=\"{}\" type=\"model\"", id);
    if (!name.empty()) fmt::format_to(to, " name=\"{}\"", backends::escape_xml(name));
    fmt::format_to(to, "{}>\n<mesh{}><vertices>\n", material_text(materials),
                   volume > 0 ? fmt::format(" v:volumeid=\"{}\"", volume) : "");
    // The shortest digits that read back as the number that a mesh has.
    for (const Vec3d& p : points)
        fmt::format_to(to, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", p.x, p.y, p.z);
    resources_ += "</vertices><triangles>\n";
    for (const std::array<int32_t, 3>& t : triangles)
        fmt::format_to(to, "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", t[0], t[1], t[2]);
    resources_ += "</triangles></mesh></object>\n";
    return id;
}

int FieldModel::add_beams(const std::string& name, const mesh::Beams& beams, int materials) {
    has_beams_ = true;
    const int id = next_id();
    auto to = std::back_inserter(resources_);
    fmt::format_to(to, "<object id=\"{}\" type=\"model\" name=\"{}\"{}>\n<mesh><vertices>\n", id,
                   backends::escape_xml(name), material_text(materials));
    for (const Vec3d& p : beams.nodes)
        fmt::format_to(to, "<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", p.x, p.y, p.z);
    constexpr const char* kCaps[] = {"sphere", "butt", "hemisphere"};  // by mesh::BeamEnd
    std::string struts, balls;
    float radius = 0;
    for (const mesh::Beam& beam : beams.beams) {
        if (radius == 0) radius = beam.radii[0];
        if (beam.nodes[0] == beam.nodes[1]) {
            balls +=
                fmt::format("<b2:ball vindex=\"{}\" r=\"{}\"/>\n", beam.nodes[0], beam.radii[0]);
            continue;
        }
        struts += fmt::format(
            "<b:beam v1=\"{}\" v2=\"{}\" r1=\"{}\" r2=\"{}\" cap1=\"{}\" cap2=\"{}\"/>\n",
            beam.nodes[0], beam.nodes[1], beam.radii[0], beam.radii[1],
            kCaps[static_cast<size_t>(beam.ends[0])], kCaps[static_cast<size_t>(beam.ends[1])]);
    }
    has_balls_ |= !balls.empty();
    fmt::format_to(
        to,
        "</vertices><triangles></triangles>\n<b:beamlattice radius=\"{}\" minlength=\"1e-6\" "
        "cap=\"sphere\"{}><b:beams>\n{}</b:beams>{}</b:beamlattice></mesh></object>\n",
        radius, balls.empty() ? "" : fmt::format(" ballmode=\"mixed\" ballradius=\"{}\"", radius),
        struts, balls.empty() ? "" : "<b2:balls>\n" + balls + "</b2:balls>");
    return id;
}

int FieldModel::add_box(const Box3d& box) {
    std::vector<Vec3d> points;
    for (int c = 0; c < 8; ++c)
        points.push_back({(c & 1) != 0 ? box.hi.x : box.lo.x, (c & 2) != 0 ? box.hi.y : box.lo.y,
                          (c & 4) != 0 ? box.hi.z : box.lo.z});
    return add_mesh({}, points,
                    {{0, 2, 3},
                     {0, 3, 1},
                     {4, 5, 7},
                     {4, 7, 6},
                     {0, 1, 5},
                     {0, 5, 4},
                     {2, 6, 7},
                     {2, 7, 3},
                     {0, 4, 6},
                     {0, 6, 2},
                     {1, 3, 7},
                     {1, 7, 5}},
                    0, 0);
}

int FieldModel::add_level_set(const std::string& name, const ModelField& level, int mesh,
                              bool box_only, int materials, int volume) {
    has_functions_ = true;
    const int id = next_id();
    resources_ += fmt::format(
        "<object id=\"{}\" type=\"model\" name=\"{}\"{}><v:levelset {} meshid=\"{}\" "
        "meshbboxonly=\"{}\"{}/></object>\n",
        id, backends::escape_xml(name), material_text(materials), field_text(level), mesh, box_only,
        volume > 0 ? fmt::format(" volumeid=\"{}\"", volume) : "");
    return id;
}

void FieldModel::add_item(int object, const Affine3d& place) {
    items_ +=
        fmt::format("<item objectid=\"{}\" transform=\"{}\"/>\n", object, transform_text(place));
}

std::string FieldModel::text(const std::string& title) const {
    std::string required;
    const auto need = [&](bool is, const char* prefix) {
        if (is) required += (required.empty() ? "" : " ") + std::string(prefix);
    };
    need(has_functions_, "v i");
    need(has_beams_, "b");
    need(has_balls_, "b2");
    if (!required.empty()) required = " requiredextensions=\"" + required + "\"";
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<model unit=\"millimeter\" xml:lang=\"en-US\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
        "xmlns:v=\"http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01\" "
        "xmlns:i=\"http://schemas.3mf.io/3dmanufacturing/implicit/2023/12\" "
        "xmlns:b=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02\" "
        "xmlns:b2=\"http://schemas.microsoft.com/3dmanufacturing/beamlattice/balls/2020/07\"{}>\n"
        "<metadata name=\"Title\">{}</metadata>\n"
        "<metadata name=\"Application\">OpenFab</metadata>\n"
        "<resources>\n{}</resources>\n<build>\n{}</build>\n</model>\n",
        required, backends::escape_xml(title), resources_, items_);
}

}  // namespace openfab::tools
