// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/compile.h>
#include <fmt/format.h>

#include <iterator>
#include <utility>

#include "backends/boundary/mesh_sink.h"
#include "backends/boundary/messages.h"
#include "backends/common/deflate_spool.h"
#include "backends/common/messages.h"
#include "backends/common/package.h"
#include "backends/common/part_file.h"
#include "backends/common/xml_text.h"

namespace openfab::boundary {

namespace {

constexpr int64_t kMostIndices = INT32_MAX;  // of vertices and triangles, by the 3MF specification
constexpr int kMaterialsId = 1;
constexpr const char* kModel = "3D/3dmodel.model";
constexpr int64_t kGlueBytes = 1 << 20;  // more than the text around the meshes

constexpr std::string_view kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
  <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";

constexpr std::string_view kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
  <Relationship Target="/3D/3dmodel.model" Id="model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

/// Returns the attributes that paint a whole triangle with a filament. PrusaSlicer has its own name for
/// what OrcaSlicer and Bambu Studio call paint_color; the value is the same: four bits a hexadecimal
/// digit, the last digit first; two bits 0, the triangle is whole; two bits of the filament, where
/// it is 1 or 2, else 3 and a digit of the filament less 3.
/// Source: PrusaSlicer, TriangleSelector::serialize; OrcaSlicer, Format/bbs_3mf.cpp.
std::string painted_with(size_t filament) {
    const std::string value =
        filament < 3 ? fmt::format("{:X}", filament << 2) : fmt::format("{:X}C", filament - 3);
    return fmt::format(" paint_color=\"{0}\" slic3rpe:mmu_segmentation=\"{0}\"", value);
}

class ThreemfWriter final : public MeshWriter {
  public:
    ThreemfWriter(std::filesystem::path path, Faces faces)
        : path_(std::move(path)), faces_(faces) {}

    Faces faces() const override { return faces_; }

    Result<void> begin(const pipeline::PrintInfo& info) override {
        if (is_painted() && info.materials.size() > kMostFilaments) {
            return user_error(
                fmt::format(messages::kTooManyFilaments, info.materials.size(), kMostFilaments));
        }
        info_ = info;
        coordinates_ = Coordinates(info);
        meshes_.resize(is_painted() ? 1 : info.materials.size());
        // Reports an unwritable output now, not after the last slice.
        Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(path_);
        if (!file) return file.error();
        file_ = std::move(*file);
        return {};
    }

    Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) override {
        Mesh& mesh = mesh_of(code);
        if (Result<void> counted = count(code, &mesh.vertex_count, points.size()); !counted)
            return counted;
        if (mesh.vertices == nullptr) {
            if (Result<void> made = make_spool(&mesh.vertices); !made) return made;
        }
        text_.clear();
        for (const Vec3i& point : points) {
            // Formats the shortest digits that read back as this number.
            const Vec3f p = coordinates_.at(point);
            fmt::format_to(std::back_inserter(text_),
                           FMT_COMPILE("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n"), p.x, p.y, p.z);
        }
        return mesh.vertices->append({text_.data(), text_.size()});
    }

    Result<void> take_triangles(uint8_t code, std::span<const MeshTriangle> triangles) override {
        Mesh& mesh = mesh_of(code);
        if (Result<void> counted = count(code, &mesh.triangle_count, triangles.size()); !counted)
            return counted;
        if (mesh.triangles == nullptr) {
            if (Result<void> made = make_spool(&mesh.triangles); !made) return made;
        }
        text_.clear();
        const std::string paint =
            is_painted() ? fmt::format(" p1=\"{}\"{}", code - 1, painted_with(code)) : "";
        for (const MeshTriangle& t : triangles) {
            fmt::format_to(std::back_inserter(text_),
                           FMT_COMPILE("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"{}/>\n"),
                           t[0].vertex, t[1].vertex, t[2].vertex, paint);
        }
        return mesh.triangles->append({text_.data(), text_.size()});
    }

    Result<void> end() override {
        int64_t bytes = kGlueBytes;
        bool any = false;
        for (const Mesh& mesh : meshes_) {
            for (backends::DeflateSpool* spool : {mesh.vertices.get(), mesh.triangles.get()}) {
                if (spool == nullptr) continue;
                any = true;
                if (Result<void> ended = spool->end(); !ended) return ended;
                bytes += std::max(spool->packed_bytes(), spool->sum().bytes);
            }
        }
        if (!any) return user_error(messages::kNothingPrinted);
        Result<backends::OutputFile*> file = file_->flushed();
        if (!file) return file.error();
        Result<std::unique_ptr<backends::Package>> package = backends::Package::create(*file);
        if (!package) return package.error();
        package_ = std::move(*package);
        Result<void> done = package_->add("[Content_Types].xml", kContentTypes);
        if (done) done = package_->add("_rels/.rels", kRelationships);
        if (done) done = package_->begin_packed(kModel, bytes);
        if (done) done = write_model();
        if (done) done = package_->end_packed(sum_);
        if (done) done = package_->close();
        return done ? file_->keep() : done;
    }

  private:
    struct Mesh {
        std::unique_ptr<backends::DeflateSpool> vertices, triangles;
        int64_t vertex_count = 0, triangle_count = 0;
    };

    bool is_painted() const { return faces_ == Faces::kOfTheSolid; }
    Mesh& mesh_of(uint8_t code) { return meshes_[is_painted() ? 0 : code - 1u]; }
    /// Names the mesh of a material.
    const std::string& name_of(size_t material) const {
        return is_painted() ? info_.title : info_.materials[material].name;
    }

    Result<void> count(uint8_t code, int64_t* sum, size_t more) {
        *sum += static_cast<int64_t>(more);
        if (*sum <= kMostIndices) return {};
        return user_error(fmt::format(messages::kMeshTooLarge, name_of(code - 1u)));
    }

    Result<void> make_spool(std::unique_ptr<backends::DeflateSpool>* spool) {
        const std::filesystem::path folder = path_.parent_path();
        Result<std::unique_ptr<backends::DeflateSpool>> made =
            backends::DeflateSpool::create(folder.empty() ? "." : folder);
        if (!made) return made.error();
        *spool = std::move(*made);
        return {};
    }

    Result<void> put(const std::string& text, bool last = false) {
        const std::vector<uint8_t> packed = backends::deflate_text(text, last, &sum_);
        if (packed.empty()) return outside_error(backends::messages::kOutOfMemory);
        return package_->write_packed(packed);
    }

    Result<void> put(const backends::DeflateSpool& spool) {
        sum_.add(spool.sum());
        return spool.read(
            [this](std::span<const uint8_t> bytes) { return package_->write_packed(bytes); });
    }

    std::string head() const {
        std::string text = fmt::format(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<model unit=\"millimeter\" xml:lang=\"en-US\" "
            "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"{}>\n"
            "<metadata name=\"Title\">{}</metadata>\n"
            "<metadata name=\"Application\">OpenFab</metadata>\n"
            "<resources>\n<basematerials id=\"{}\">\n",
            is_painted() ? " xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\"" : "",
            backends::escape_xml(info_.title), kMaterialsId);
        for (const pipeline::SliceMaterial& m : info_.materials) {
            text += fmt::format("<base name=\"{}\" displaycolor=\"#{:02X}{:02X}{:02X}{:02X}\"/>\n",
                                backends::escape_xml(m.name), m.preview[0], m.preview[1],
                                m.preview[2], m.preview[3]);
        }
        return text + "</basematerials>\n";
    }

    Result<void> write_model() {
        Result<void> done = put(head());
        std::string components;
        int id = kMaterialsId;
        for (size_t m = 0; m < meshes_.size(); ++m) {
            const Mesh& mesh = meshes_[m];
            if (mesh.vertices == nullptr || mesh.triangles == nullptr) continue;
            ++id;
            components += fmt::format("<component objectid=\"{}\"/>\n", id);
            if (done) {
                done =
                    put(fmt::format("<object id=\"{}\" type=\"model\" name=\"{}\" pid=\"{}\" "
                                    "pindex=\"{}\">\n<mesh>\n<vertices>\n",
                                    id, backends::escape_xml(name_of(m)), kMaterialsId, m));
            }
            if (done) done = put(*mesh.vertices);
            if (done) done = put("</vertices>\n<triangles>\n");
            if (done) done = put(*mesh.triangles);
            if (done) done = put("</triangles>\n</mesh>\n</object>\n");
        }
        if (done && !is_painted()) {
            ++id;
            done =
                put(fmt::format("<object id=\"{}\" type=\"model\" name=\"{}\">\n<components>\n{}"
                                "</components>\n</object>\n",
                                id, backends::escape_xml(info_.title), components));
        }
        if (!done) return done;
        return put(
            fmt::format("</resources>\n<build>\n<item objectid=\"{}\"/>\n</build>\n</model>\n", id),
            true);
    }

    std::filesystem::path path_;
    Faces faces_;
    pipeline::PrintInfo info_;
    Coordinates coordinates_;
    std::vector<Mesh> meshes_;  ///< by material; or that of the solid
    std::unique_ptr<backends::PartFile> file_;
    std::unique_ptr<backends::Package> package_;  ///< declared after file_, so destroyed before it
    backends::TextSum sum_;
    fmt::memory_buffer text_;
};

}  // namespace

std::unique_ptr<MeshWriter> make_threemf_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Faces::kOfEachMaterial);
}

std::unique_ptr<MeshWriter> make_filament_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Faces::kOfTheSolid);
}

}  // namespace openfab::boundary
