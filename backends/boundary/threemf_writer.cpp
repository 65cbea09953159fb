// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/compile.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "backends/boundary/color_table.h"
#include "backends/boundary/filament_mixtures.h"
#include "backends/boundary/mesh_sink.h"
#include "backends/boundary/messages.h"
#include "backends/boundary/position_index.h"
#include "backends/common/deflate_spool.h"
#include "backends/common/messages.h"
#include "backends/common/package.h"
#include "backends/common/part_file.h"
#include "backends/common/xml_text.h"

namespace openfab::boundary {

namespace {

constexpr std::string_view kColorNamespace =
    " xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\"";
constexpr std::string_view kPrusaNamespace =
    " xmlns:slic3rpe=\"http://schemas.slic3r.org/3mf/2017/06\"";
constexpr int64_t kMostIndices = INT32_MAX;  // of vertices and triangles, by the 3MF specification
constexpr int kMaterialsId = 1;
constexpr const char* kModel = "3D/3dmodel.model";
constexpr int64_t kGlueBytes = 1 << 20;  // more than the text around the meshes
constexpr int64_t kColorBytes = 64;      // more than the text of a colour

constexpr std::string_view kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
  <Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
  <Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
  <Default Extension="config" ContentType="text/xml"/>
</Types>
)";

constexpr std::string_view kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
  <Relationship Target="/3D/3dmodel.model" Id="model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

/// Returns the attributes that paint a whole triangle with a filament, as OrcaSlicer and Bambu Studio read it:
/// four bits a hexadecimal digit, the last digit first; two bits 0, the triangle is whole; two bits of the filament, where
/// it is 1 or 2, else 3 and a digit of the filament less 3. PrusaSlicer has another name for the same, and reads this one
/// where its own is missing or empty: its own says that there is no paint, since it would carry that of horizontal
/// triangles into other layers, and has volumes instead.
/// Source: PrusaSlicer, TriangleSelector::serialize, Format/3mf.cpp; OrcaSlicer, Format/bbs_3mf.cpp.
std::string painted_with(size_t filament) {
    constexpr const char* kUnpainted = " slic3rpe:mmu_segmentation=\"0\"";
    return filament < 3 ? fmt::format("{} paint_color=\"{:X}\"", kUnpainted, filament << 2)
                        : fmt::format("{} paint_color=\"{:X}C\"", kUnpainted, filament - 3);
}

constexpr std::string_view kConfigHead = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<config>\n";

/// Returns where the build places the mesh: its lowest slice on the bed, and nothing at x or y below 0, as the specification
/// (3MF Core 1.3, 3.3) asks for. The mesh keeps its coordinates, which two prints of one assembly share. Not for filament: PrusaSlicer 2.5
/// moves the first volume of an object alone, and sets objects down on the bed itself.
std::string placed(const pipeline::PrintInfo& info) {
    const double x = std::max(0.0, -info.origin_mm.x), y = std::max(0.0, -info.origin_mm.y);
    const double z = 0.0 - (info.origin_mm.z + info.slice_begin * info.pitch_mm.z);
    if (x == 0 && y == 0 && z == 0) return "";
    return fmt::format(" transform=\"1 0 0 0 1 0 0 0 1 {} {} {}\"", static_cast<float>(x),
                       static_cast<float>(y), static_cast<float>(z));
}

enum class Kind : uint8_t { kEach, kApart, kFilament, kColored };

class ThreemfWriter final : public MeshWriter {
  public:
    ThreemfWriter(std::filesystem::path path, Kind kind, const FilamentMixtures* mixtures = nullptr)
        : path_(std::move(path)),
          kind_(kind),
          for_filament_(kind == Kind::kFilament),
          mixtures_(mixtures) {}

    bool numbers_together() const override { return for_filament_; }
    bool identifies_by_position() const override { return kind_ == Kind::kApart; }
    bool has_colors() const override { return kind_ == Kind::kColored; }

    Result<void> begin(const pipeline::PrintInfo& info) override {
        if (for_filament_ && info.materials.size() > kMostFilaments) {
            return user_error(
                fmt::format(messages::kTooManyFilaments, info.materials.size(), kMostFilaments));
        }
        info_ = info;
        coordinates_ = Coordinates(info);
        meshes_.resize(info.materials.size());
        // Reports an unwritable output now, not after the last slice.
        Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(path_);
        if (!file) return file.error();
        file_ = std::move(*file);
        return {};
    }

    Result<void> take_vertices(uint8_t code, std::span<const Vec3i> points) override {
        if (kind_ == Kind::kApart) return {};  // take_triangles has those that are moved
        Mesh& mesh = for_filament_ ? all_ : meshes_[code - 1u];
        if (Result<void> counted = count(mesh, &mesh.vertex_count, points.size()); !counted)
            return counted;
        if (mesh.vertices == nullptr) {
            if (Result<void> made = make_spool(&mesh.vertices); !made) return made;
        }
        text_.clear();
        for (const Vec3i& point : points)
            put_vertex(coordinates_.at(point));
        return mesh.vertices->append({text_.data(), text_.size()});
    }

    Result<void> take_triangles(uint8_t code, std::span<const MeshTriangle> triangles) override {
        Mesh& mesh = meshes_[code - 1u];
        Mesh& counted_in = for_filament_ ? all_ : mesh;
        Result<void> counted = count(counted_in, &counted_in.triangle_count, triangles.size());
        if (!counted) return counted;
        if (for_filament_) mesh.triangle_count += static_cast<int64_t>(triangles.size());
        if (mesh.triangles == nullptr) {
            if (Result<void> made = make_spool(&mesh.triangles); !made) return made;
        }
        if (kind_ == Kind::kApart) return take_apart(&mesh, triangles);
        text_.clear();
        const std::string paint = for_filament_
                                      ? fmt::format(" p1=\"{}\"{}", code - 1,
                                                    mixtures_ == nullptr ? painted_with(code) : "")
                                      : "";
        for (const MeshTriangle& t : triangles) {
            if (kind_ == Kind::kColored) {
                put_triangle(t[0].vertex, t[1].vertex, t[2].vertex,
                             fmt::format(" p1=\"{}\"", colors_.number(t.color)));
                continue;
            }
            put_triangle(t[0].vertex, t[1].vertex, t[2].vertex, paint);
        }
        return mesh.triangles->append({text_.data(), text_.size()});
    }

    Result<void> end(const pipeline::PrintTotals&) override {
        if (mixtures_ != nullptr) {
            info_.materials = mixtures_->all();
            meshes_.resize(info_.materials.size());
        }
        int64_t bytes = kGlueBytes + kColorBytes * static_cast<int64_t>(colors_.colors().size());
        bool any = false;
        const auto end_one = [&](backends::DeflateSpool* spool) -> Result<void> {
            if (spool == nullptr) return {};
            any = true;
            if (Result<void> ended = spool->end(); !ended) return ended;
            bytes += std::max(spool->packed_bytes(), spool->sum().bytes);
            return {};
        };
        Result<void> ended = end_one(all_.vertices.get());
        for (const Mesh& mesh : meshes_) {
            if (ended) ended = end_one(mesh.vertices.get());
            if (ended) ended = end_one(mesh.triangles.get());
        }
        if (!ended) return ended;
        if (!any) return user_error(messages::kNothingPrinted);
        Result<backends::OutputFile*> file = file_->flushed();
        if (!file) return file.error();
        Result<std::unique_ptr<backends::Package>> package = backends::Package::create(*file);
        if (!package) return package.error();
        package_ = std::move(*package);
        const std::string mixed = mixtures_ != nullptr ? mixtures_->json() : "";
        std::string types(kContentTypes);
        if (!mixed.empty())
            types.insert(types.find("  <Default"),
                         "  <Default Extension=\"json\" ContentType=\"application/json\"/>\n");
        Result<void> done = package_->add("[Content_Types].xml", types);
        if (done) done = package_->add("_rels/.rels", kRelationships);
        if (done && kind_ != Kind::kColored) {
            done = for_filament_ ? package_->add("Metadata/Slic3r_PE_model.config", volumes())
                                 : package_->add("Metadata/model_settings.config", parts());
        }
        if (done && !mixed.empty())
            done = package_->add("Metadata/Prusa_Slicer_full_spectrum.json", mixed);
        if (done) done = package_->begin_packed(kModel, bytes);
        if (done) done = write_model();
        if (done) done = package_->end_packed(sum_);
        if (done) done = package_->close();
        return done ? file_->keep() : done;
    }

  private:
    struct Mesh {
        std::unique_ptr<backends::DeflateSpool> vertices, triangles;
        PositionIndex positions;  ///< of kApart
        int64_t vertex_count = 0, triangle_count = 0;
    };

    void put_vertex(const Vec3f& p) {
        // Formats the shortest digits that read back as this number.
        fmt::format_to(std::back_inserter(text_),
                       FMT_COMPILE("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n"), p.x, p.y, p.z);
    }
    void put_triangle(uint32_t a, uint32_t b, uint32_t c, std::string_view more) {
        fmt::format_to(std::back_inserter(text_),
                       FMT_COMPILE("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"{}/>\n"), a, b, c, more);
    }

    /// Writes vertices as triangles need them: each position once.
    Result<void> take_apart(Mesh* mesh, std::span<const MeshTriangle> triangles) {
        if (mesh->vertices == nullptr) {
            if (Result<void> made = make_spool(&mesh->vertices); !made) return made;
        }
        std::vector<std::array<uint32_t, 3>> numbers;
        text_.clear();
        size_t added = 0;
        for (const MeshTriangle& t : triangles) {
            std::array<uint32_t, 3>& of = numbers.emplace_back();
            for (size_t i = 0; i < 3; ++i) {
                const auto [number, is_new] = mesh->positions.number(t[i]);
                of[i] = number;
                if (!is_new) continue;
                put_vertex(coordinates_.at(t[i]));
                ++added;
            }
        }
        Result<void> done = count(*mesh, &mesh->vertex_count, added);
        if (done) done = mesh->vertices->append({text_.data(), text_.size()});
        text_.clear();
        for (const auto& [a, b, c] : numbers)
            put_triangle(a, b, c, "");
        return done ? mesh->triangles->append({text_.data(), text_.size()}) : done;
    }

    Result<void> count(const Mesh& mesh, int64_t* sum, size_t more) {
        *sum += static_cast<int64_t>(more);
        if (*sum <= kMostIndices) return {};
        const auto material = static_cast<size_t>(&mesh - meshes_.data());
        return user_error(fmt::format(
            messages::kMeshTooLarge, for_filament_ ? info_.title : info_.materials[material].name));
    }

    bool is_there(const Mesh& mesh) const { return mesh.triangles != nullptr; }
    /// The object of a material's mesh, or of all: numbers without gaps, after that of the colours.
    int object_of(size_t material) const {
        int id = kMaterialsId + 1;
        for (size_t m = 0; m < material; ++m)
            id += is_there(meshes_[m]) ? 1 : 0;
        return id;
    }

    /// The triangles of each material, and its filament, as PrusaSlicer reads them.
    /// Source: PrusaSlicer 2.5, Format/3mf.cpp.
    std::string volumes() const {
        std::string text = fmt::format("{} <object id=\"{}\" instances_count=\"1\">\n", kConfigHead,
                                       kMaterialsId + 1);
        int64_t first = 0;
        for (size_t m = 0; m < meshes_.size(); ++m) {
            if (!is_there(meshes_[m])) continue;
            text += fmt::format(
                "  <volume firstid=\"{}\" lastid=\"{}\">\n"
                "   <metadata type=\"volume\" key=\"name\" value=\"{}\"/>\n"
                "   <metadata type=\"volume\" key=\"volume_type\" value=\"ModelPart\"/>\n"
                "   <metadata type=\"volume\" key=\"extruder\" value=\"{}\"/>\n  </volume>\n",
                first, first + meshes_[m].triangle_count - 1,
                backends::escape_xml(info_.materials[m].name), m + 1);
            first += meshes_[m].triangle_count;
        }
        return text + " </object>\n</config>\n";
    }

    /// The filament of each material's object, as OrcaSlicer and Bambu Studio read it.
    /// Source: OrcaSlicer, Format/bbs_3mf.cpp.
    std::string parts() const {
        std::string text =
            fmt::format("{} <object id=\"{}\">\n  <metadata key=\"name\" value=\"{}\"/>\n",
                        kConfigHead, object_of(meshes_.size()), backends::escape_xml(info_.title));
        for (size_t m = 0; m < meshes_.size(); ++m) {
            if (!is_there(meshes_[m])) continue;
            text += fmt::format(
                "  <part id=\"{}\" subtype=\"normal_part\">\n"
                "   <metadata key=\"name\" value=\"{}\"/>\n"
                "   <metadata key=\"extruder\" value=\"{}\"/>\n  </part>\n",
                object_of(m), backends::escape_xml(info_.materials[m].name), m + 1);
        }
        return text + " </object>\n</config>\n";
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

    /// Which slices are here, where others are elsewhere.
    std::string part_of_print() const {
        if (info_.slice_begin == 0 && info_.slice_end == info_.size.z) return {};
        return fmt::format("<metadata name=\"Description\">slices {} to {} of {}</metadata>\n",
                           info_.slice_begin, info_.slice_end - 1, info_.size.z);
    }

    std::string head() const {
        std::string text = fmt::format(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<model unit=\"millimeter\" xml:lang=\"en-US\" "
            "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"{}>\n"
            "<metadata name=\"Title\">{}</metadata>\n"
            "<metadata name=\"Application\">OpenFab</metadata>\n{}"
            "<resources>\n",
            kind_ == Kind::kColored ? kColorNamespace
            : for_filament_         ? kPrusaNamespace
                                    : "",
            backends::escape_xml(info_.title), part_of_print());
        if (kind_ == Kind::kColored) {
            text += fmt::format("<m:colorgroup id=\"{}\">\n", kMaterialsId);
            for (const Rgba color : colors_.colors())
                text += fmt::format("<m:color color=\"#{:08X}\"/>\n", color);
            return text + "</m:colorgroup>\n";
        }
        text += fmt::format("<basematerials id=\"{}\">\n", kMaterialsId);
        for (const pipeline::SliceMaterial& m : info_.materials) {
            text += fmt::format("<base name=\"{}\" displaycolor=\"#{:02X}{:02X}{:02X}{:02X}\"/>\n",
                                backends::escape_xml(m.name), m.preview[0], m.preview[1],
                                m.preview[2], m.preview[3]);
        }
        return text + "</basematerials>\n";
    }

    Result<void> begin_object(int id, const std::string& name, size_t material) {
        return put(
            fmt::format("<object id=\"{}\" type=\"model\" name=\"{}\" pid=\"{}\" pindex=\"{}\">\n"
                        "<mesh>\n<vertices>\n",
                        id, backends::escape_xml(name), kMaterialsId, material));
    }
    Result<void> end_object() { return put("</triangles>\n</mesh>\n</object>\n"); }

    /// One object of all triangles, those of a material after each other.
    Result<void> write_all() {
        Result<void> done = begin_object(kMaterialsId + 1, info_.title, 0);
        if (done) done = put(*all_.vertices);
        if (done) done = put("</vertices>\n<triangles>\n");
        for (const Mesh& mesh : meshes_) {
            if (done && is_there(mesh)) done = put(*mesh.triangles);
        }
        return done ? end_object() : done;
    }

    /// An object for each material, and one that has them as components.
    Result<void> write_each() {
        std::string components;
        for (size_t m = 0; m < meshes_.size(); ++m) {
            const Mesh& mesh = meshes_[m];
            if (!is_there(mesh)) continue;
            components += fmt::format("<component objectid=\"{}\"/>\n", object_of(m));
            Result<void> done = begin_object(object_of(m), info_.materials[m].name,
                                             kind_ == Kind::kColored ? 0 : m);
            if (done) done = put(*mesh.vertices);
            if (done) done = put("</vertices>\n<triangles>\n");
            if (done) done = put(*mesh.triangles);
            if (done) done = end_object();
            if (!done) return done;
        }
        return put(
            fmt::format("<object id=\"{}\" type=\"model\" name=\"{}\">\n<components>\n{}"
                        "</components>\n</object>\n",
                        object_of(meshes_.size()), backends::escape_xml(info_.title), components));
    }

    Result<void> write_model() {
        Result<void> done = put(head());
        if (done) done = for_filament_ ? write_all() : write_each();
        if (!done) return done;
        const int item = for_filament_ ? kMaterialsId + 1 : object_of(meshes_.size());
        return put(
            fmt::format("</resources>\n<build>\n<item objectid=\"{}\"{}/>\n</build>\n</model>\n",
                        item, for_filament_ ? std::string() : placed(info_)),
            true);
    }

    std::filesystem::path path_;
    Kind kind_;
    bool for_filament_;
    const FilamentMixtures* mixtures_;  ///< null: there are none
    pipeline::PrintInfo info_;
    Coordinates coordinates_;
    std::vector<Mesh> meshes_;  ///< by material; for filament, their triangles
    Mesh all_;                  ///< for filament: the vertices, and how many triangles
    std::unique_ptr<backends::PartFile> file_;
    std::unique_ptr<backends::Package> package_;  ///< declared after file_, so destroyed before it
    backends::TextSum sum_;
    fmt::memory_buffer text_;
    ColorTable colors_;  ///< of kColored
};

}  // namespace

std::unique_ptr<MeshWriter> make_threemf_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Kind::kEach);
}

std::unique_ptr<MeshWriter> make_apart_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Kind::kApart);
}

std::unique_ptr<MeshWriter> make_colored_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Kind::kColored);
}

std::unique_ptr<MeshWriter> make_filament_writer(const std::filesystem::path& path) {
    return std::make_unique<ThreemfWriter>(path, Kind::kFilament);
}

std::unique_ptr<MeshWriter> make_mixed_writer(const std::filesystem::path& path,
                                              const FilamentMixtures* mixtures) {
    return std::make_unique<ThreemfWriter>(path, Kind::kFilament, mixtures);
}

}  // namespace openfab::boundary
