// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/step/solids_package.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <memory>
#include <string_view>
#include <vector>

#include "backends/common/output_file.h"
#include "backends/common/package.h"

namespace openfab::tools {

namespace {

constexpr const char* kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>)";
constexpr const char* kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="r0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>)";

std::string xml_text(std::string_view text) {
    std::string out;
    for (const char c : text) {
        if (c == '&') {
            out += "&amp;";
        } else if (c == '<') {
            out += "&lt;";
        } else if (c == '"') {
            out += "&quot;";
        } else if (static_cast<unsigned char>(c) >= ' ') {
            out += c;
        }
    }
    return out;
}

int srgb(double linear) {
    const double x =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    return static_cast<int>(std::lround(255 * std::min(1.0, std::max(0.0, x))));
}

}  // namespace

Result<void> write_solids(const StepFile& solids, const std::string& output) {
    std::string text =
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n<resources>\n";
    auto to = std::back_inserter(text);
    bool colored = false;
    for (const StepSolid& solid : solids.solids)
        colored |= solid.color.has_value();
    if (colored) text += "<basematerials id=\"1\">\n";
    std::vector<int> material;  // by solid; -1: the file says none
    int count = 0;
    for (const StepSolid& solid : solids.solids) {
        material.push_back(solid.color ? count++ : -1);
        if (!solid.color) continue;
        const auto& c = *solid.color;
        fmt::format_to(to, "<base name=\"{}\" displaycolor=\"#{:02X}{:02X}{:02X}\"/>\n",
                       xml_text(solid.name.empty() ? "material" : solid.name), srgb(c[0]),
                       srgb(c[1]), srgb(c[2]));
    }
    if (colored) text += "</basematerials>\n";
    for (size_t i = 0; i < solids.solids.size(); ++i) {
        const StepSolid& solid = solids.solids[i];
        const std::string look =
            material[i] >= 0 ? fmt::format(" pid=\"1\" pindex=\"{}\"", material[i]) : "";
        fmt::format_to(to, "<object id=\"{}\" type=\"model\" name=\"{}\"{}><mesh><vertices>\n",
                       i + 2, xml_text(solid.name), look);
        for (const Vec3d& p : solid.vertices)
            fmt::format_to(to, "<vertex x=\"{:.9g}\" y=\"{:.9g}\" z=\"{:.9g}\"/>\n", p.x, p.y, p.z);
        text += "</vertices><triangles>\n";
        for (const auto& t : solid.triangles)
            fmt::format_to(to, "<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"/>\n", t[0], t[1], t[2]);
        text += "</triangles></mesh></object>\n";
    }
    text += "</resources>\n<build>\n";
    for (size_t i = 0; i < solids.solids.size(); ++i)
        fmt::format_to(to, "<item objectid=\"{}\"/>\n", i + 2);
    text += "</build>\n</model>\n";
    Result<backends::OutputFile> file = backends::OutputFile::create(output);
    if (!file) return file.error();
    Result<std::unique_ptr<backends::Package>> package = backends::Package::create(&*file);
    if (!package) return package.error();
    Result<void> done = (*package)->add("[Content_Types].xml", kContentTypes);
    if (done) done = (*package)->add("_rels/.rels", kRelationships);
    if (done) done = (*package)->add("3D/3dmodel.model", text);
    if (done) done = (*package)->close();
    if (done) done = file->close(false);
    return done;
}

}  // namespace openfab::tools
