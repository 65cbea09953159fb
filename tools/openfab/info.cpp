// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab info FILE`: describes a print, a folder of slices, a world, a mesh, a picture or a volume.

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "backends/job/record.h"
#include "backends/ofr/ofr_reader.h"
#include "backends/raster/slice_digests.h"
#include "backends/raster/slice_files.h"
#include "backends/read/gcvf_print.h"
#include "backends/zarr/store.h"
#include "base/input_file.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/list_mesh.h"
#include "tools/openfab/list_textures.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/verify_files.h"
#include "tools/openfab/verify_store.h"
#include "world/world.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Maximum number of placed vertices that are read for a world's size.
constexpr double kMostVertices = 3e8;

double voxel_ml(const pipeline::PrintInfo& info) {
    return info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
}

bool is_part(const pipeline::PrintInfo& info) {
    return info.slice_end - info.slice_begin < info.size.z;
}

void print_grid(const pipeline::PrintInfo& info) {
    const Vec3d& pitch = info.pitch_mm;
    show(fmt::format("title      {}\n", printable(info.title)));
    if (!info.printer.empty()) show(fmt::format("printer    {}\n", printable(info.printer)));
    show(fmt::format("voxels     {} x {} x {}, {} bits\n", info.size.x, info.size.y, info.size.z,
                     info.bits));
    show(fmt::format("pitch      {:.6g} x {:.6g} x {:.6g} mm ({:.5g} x {:.5g} dpi, {:.5g} um)\n",
                     pitch.x, pitch.y, pitch.z, 25.4 / pitch.x, 25.4 / pitch.y, pitch.z * 1000));
    show(fmt::format("size       {:.3f} x {:.3f} x {:.3f} mm\n", info.size.x * pitch.x,
                     info.size.y * pitch.y, info.size.z * pitch.z));
    show(fmt::format("origin     {:.3f} {:.3f} {:.3f} mm\n", info.origin_mm.x, info.origin_mm.y,
                     info.origin_mm.z));
    const bool part = is_part(info);
    show(part ? fmt::format(messages::kSlicesOfWhole, info.slice_begin, info.slice_end - 1,
                            info.size.z)
              : fmt::format("slices     {} to {}\n", info.slice_begin, info.slice_end - 1));
}

/// Describes how much of an unfinished print's file is usable.
Result<std::string> describe_unfinished(ofr::OfrReader* reader) {
    Result<bool> more = true;
    while ((more = reader->next()) && *more) {
    }
    const int32_t whole = reader->whole_slices();
    const int32_t planned = reader->info().slice_end - reader->info().slice_begin;
    if (reader->disk_failed()) return more.error();
    return fmt::format(messages::kSlicesWhole, whole, planned);
}

/// Shows what the record beside a print tells of its making.
void show_story(const fs::path& output, std::optional<uint64_t> hash, size_t width) {
    const std::optional<JsonValue> record = job::record_of(output, hash);
    if (!record) return;
    const char* label = "story";
    for (const std::string& line : job::story_lines(*record, output)) {
        show(fmt::format("{:<{}}{}\n", label, width, printable(line)));
        label = "";
    }
}

/// Shows the materials of a print, and how much there is of each where that is known.
void show_materials(const pipeline::PrintInfo& info,
                    const std::optional<pipeline::PrintTotals>& totals) {
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const pipeline::SliceMaterial& material = info.materials[m];
        show(fmt::format("material   {:2} #{:02x}{:02x}{:02x} {}", m + 1, material.key[0],
                         material.key[1], material.key[2], printable(material.name)));
        if (totals && m + 1 < totals->voxels_by_code.size()) {
            const double ml = static_cast<double>(totals->voxels_by_code[m + 1]) * voxel_ml(info);
            show(fmt::format(", {:.3f} ml", ml));
            if (material.density_g_cm3 > 0)
                show(fmt::format(", {:.3f} g", ml * material.density_g_cm3));
        }
        show("\n");
    }
}

Result<void> info_of_gcvf(const std::string& file, int64_t memory_bytes) {
    const auto print = prints::PrintFile::open(file, memory_bytes);
    if (!print) return print.error();
    const pipeline::PrintInfo& info = (*print)->info();
    print_grid(info);
    const int32_t whole = (*print)->whole_slices();
    const auto note = (*print)->note();
    const int32_t elsewhere = note ? note->slices_of_whole - info.size.z : 0;
    if (whole < info.size.z) {
        show(fmt::format(messages::kPackageLacksSlices, whole, info.size.z));
    } else {
        show(elsewhere == 0 ? std::string("complete   yes\n")
                            : fmt::format(messages::kCompletePart, elsewhere));
    }
    if (elsewhere > 0)
        show(fmt::format(messages::kAreSlicesOfWhole, note->slice_begin, note->slice_end - 1,
                         note->slices_of_whole));
    show_materials(info, (*print)->totals());
    show_story(file, std::nullopt, 11);
    return {};
}

Result<void> info_of_store(const std::string& path, int64_t memory_bytes) {
    const auto print = prints::PrintFile::open(path, memory_bytes);
    if (!print) return print.error();
    const Result<std::string> missing = missing_in_store(path);
    if (!missing) return missing.error();
    const pipeline::PrintInfo& info = (*print)->info();
    print_grid(info);
    show(fmt::format("seed       {}\n", info.seed));
    const auto totals = (*print)->totals();
    show(missing->empty() ? std::string("complete   yes\n")
         : totals         ? fmt::format(messages::kCompletePart,
                                        info.size.z - (info.slice_end - info.slice_begin))
                          : fmt::format(messages::kStoreLacks, *missing));
    show_materials(info, totals);
    if (totals) show(fmt::format("hash       {:016x}\n", totals->hash));
    return {};
}

Result<void> info_of_ofr(const std::string& file, int64_t memory_bytes) {
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(file, memory_bytes);
    if (!reader) return reader.error();
    const pipeline::PrintInfo& info = (*reader)->info();
    print_grid(info);
    show(fmt::format("seed       {}\n", info.seed));
    Result<pipeline::PrintTotals> totals = ofr::OfrReader::read_totals(file);
    if (totals) {
        show(is_part(info) ? fmt::format(messages::kCompletePart,
                                         info.size.z - (info.slice_end - info.slice_begin))
                           : "complete   yes\n");
    } else {
        Result<std::string> unfinished = describe_unfinished(reader->get());
        if (!unfinished) return unfinished.error();
        show(fmt::format("complete   {}\n", *unfinished));
    }
    show_materials(info, totals ? std::optional(*totals) : std::nullopt);
    if (totals) show(fmt::format("hash       {:016x}\n", totals->hash));
    show_story(file, totals ? std::optional(totals->hash) : std::nullopt, 11);
    return {};
}

/// Empty if it cannot be read, or is larger than any manifest.
std::optional<std::string> read_manifest(const fs::path& file) {
    const Result<InputFile> opened = InputFile::open(file);
    if (!opened) return {};
    Result<std::string> text = opened->read_all(raster::kMostManifestBytes);
    return text ? std::optional(std::move(*text)) : std::nullopt;
}

/// Formats a value of any kind, if present.
std::string text_of(const JsonValue& object, std::string_view name) {
    using Kind = JsonValue::Kind;
    const JsonValue* const value = member_of(object, name);
    if (value == nullptr) return "?";
    if (value->is(Kind::kString)) return value->text;
    if (value->is(Kind::kBool)) return value->boolean ? "yes" : "no";
    if (const std::optional<int64_t> whole = value->whole()) return fmt::format("{}", *whole);
    if (value->is(Kind::kNumber)) return fmt::format("{:.6g}", value->number);
    if (!value->is(Kind::kArray)) return "?";
    std::string text;
    for (const JsonValue& item : value->items) {
        if (item.is(Kind::kString))
            text += (text.empty() ? "" : " ") + item.text;
        else if (item.is(Kind::kNumber))
            text += (text.empty() ? "" : " x ") + fmt::format("{:.6g}", item.number);
        else
            return "?";
    }
    return text;
}

int64_t count_slice_files(const fs::path& folder) {
    std::error_code ended;
    int64_t files = 0;
    for (fs::directory_iterator at(folder, ended); !ended && at != fs::directory_iterator();
         at.increment(ended)) {
        const std::string name = at->path().filename().string();
        files += raster::is_slice_name(name) && !name.ends_with(".part");
    }
    return files;
}

/// Returns the hash of the print that a manifest says to be complete.
std::optional<uint64_t> hash_of(const JsonValue& manifest) {
    const JsonValue* const hash = member_of(manifest, "hash");
    if (hash == nullptr || !hash->is(JsonValue::Kind::kString)) return {};
    return std::strtoull(hash->text.c_str(), nullptr, 16);
}

Result<void> info_of_folder(const fs::path& folder) {
    const fs::path file = folder / "manifest.json";
    const std::optional<std::string> text = read_manifest(file);
    if (!text) return user_error(fmt::format(messages::kNotAFolderOfSlices, folder.string()));
    const std::optional<JsonValue> parsed = raster::parse_manifest(*text);
    if (!parsed) return user_error(fmt::format(messages::kFolderDamaged, file.string()));
    const JsonValue& manifest = *parsed;
    // Of a print that was cut short its manifest, which was written at its start, knows no slices.
    const JsonValue* const whole = member_of(manifest, "complete");
    if (whole != nullptr && whole->is(JsonValue::Kind::kBool) && !whole->boolean) {
        for (const char* name : {"title", "printer", "slices_planned", "pixels", "dpi", "layer_um"})
            show(fmt::format("{:<16} {}\n", name, printable(text_of(manifest, name))));
        show(fmt::format(messages::kFolderIncomplete, count_slice_files(folder)));
        show_story(folder, {}, 17);
        return {};
    }
    const FolderFiles files = look_for_files(folder, manifest);
    for (const char* name : {"title", "printer", "complete", "slices", "slices_planned",
                             "slices_of_whole", "slices_elsewhere", "pixels", "dpi", "layer_um",
                             "size_mm", "color_mode", "support_made_by", "hash"}) {
        if (name == std::string_view("complete") && !files.missing.empty()) {
            show(fmt::format(messages::kFolderLacksFiles, files.missing.size(), files.names.size(),
                             files.missing.front()));
            continue;
        }
        const bool of_parts = std::string_view(name).starts_with("slices_of") ||
                              std::string_view(name).starts_with("slices_else");
        if (of_parts && member_of(manifest, name) == nullptr) continue;
        show(fmt::format("{:<16} {}\n", name, printable(text_of(manifest, name))));
    }
    show_story(folder, hash_of(manifest), 17);
    const JsonValue* const materials = member_of(manifest, "materials");
    if (materials == nullptr) return {};
    for (const JsonValue& material : materials->items) {
        if (!material.is(JsonValue::Kind::kObject)) continue;
        show(fmt::format("material         {} {}, {} ml, {} g\n",
                         printable(text_of(material, "color")),
                         printable(text_of(material, "name")), printable(text_of(material, "ml")),
                         printable(text_of(material, "g"))));
    }
    return {};
}

void print_mesh(const mesh::Mesh& mesh, const std::string& indent) {
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    show(fmt::format("{}triangles  {}, vertices {}\n", indent, mesh.triangles.size(),
                     mesh.positions.size()));
    if (!box.empty()) {
        const Vec3d size = box.size();
        show(fmt::format("{}size       {:.4g} x {:.4g} x {:.4g} mm, from {:.4g} {:.4g} {:.4g}\n",
                         indent, size.x, size.y, size.z, box.lo.x, box.lo.y, box.lo.z));
    }
    for (const mesh::MeshAttribute& attribute : mesh.attributes) {
        show(fmt::format("{}attribute  {}: {} {}\n", indent, printable(attribute.name),
                         attribute.components, attribute.is_int ? "int a face" : "float a corner"));
    }
}

void print_box(const mesh::Mesh& mesh) {
    Box3d box;
    for (const Vec3d& p : mesh.positions)
        box.add(p);
    const Vec3d size = box.size();
    show(fmt::format("  box        {:.4g} x {:.4g} x {:.4g} mm, from {:.4g} {:.4g} {:.4g}\n",
                     size.x, size.y, size.z, box.lo.x, box.lo.y, box.lo.z));
}

void print_beams(const mesh::Beams& beams) {
    const Box3d box = mesh::box_of(beams);
    const Vec3d size = box.size();
    show(fmt::format("  beams      {} with {} nodes, {:.5g} x {:.5g} x {:.5g} mm\n",
                     beams.beams.size(), beams.nodes.size(), size.x, size.y, size.z));
    for (const mesh::BeamAttribute& attribute : beams.attributes)
        show(fmt::format("  attribute  {}: {} {}\n", printable(attribute.name),
                         attribute.components, attribute.is_int ? "int a beam" : "float a node"));
}

void print_geometry(std::monostate /*itself*/, const mesh::Mesh& mesh) {
    print_mesh(mesh, "  ");
}
void print_geometry(const std::shared_ptr<const mesh::Beams>& beams, const mesh::Mesh& /*box*/) {
    print_beams(*beams);
}
void print_geometry(const world::StageRef& stage, const mesh::Mesh& box) {
    show(fmt::format("  shape      by fablet {}\n", printable(stage.fablet)));
    print_box(box);
}
void print_geometry(const std::shared_ptr<const world::ProgramRef>& program,
                    const mesh::Mesh& box) {
    show(fmt::format("  program    {}\n",
                     printable(fmt::format("{}", fmt::join(program->command, " ")))));
    for (const world::ProgramRef::Attribute& attribute : program->attributes)
        show(fmt::format("  attribute  {}: {}\n", printable(attribute.name), attribute.type));
    print_box(box);
}

Result<void> info_of_world(const std::string& file, const std::vector<std::string>& allow,
                           int64_t memory_bytes) {
    Result<world::World> world =
        world::load_world(file, {{allow.begin(), allow.end()}, memory_bytes});
    if (!world) return world.error();
    show(fmt::format("printer    {}\n",
                     world->printer.empty() ? "none named" : printable(world->printer)));
    for (const auto& [name, fablet] : world->fablets) {
        show(fmt::format("fablet     {}: {} in {}\n", printable(name), printable(fablet.fablet),
                         printable(fablet.source.string())));
    }
    for (const world::Material& material : world->materials) {
        show(fmt::format("material   {} #{:02x}{:02x}{:02x}\n", printable(material.name),
                         material.key[0], material.key[1], material.key[2]));
    }
    list_textures(*world, memory_bytes);
    for (size_t i = 0; i < world->meshes.size(); ++i) {
        const mesh::Mesh& mesh = world->meshes[i];
        show(fmt::format("mesh       {}\n", printable(mesh.name)));
        std::visit([&](const auto& of) { print_geometry(of, mesh); },
                   world->geometry_of(static_cast<int32_t>(i)));
    }
    std::vector<int64_t> placed(world->objects.size());
    Box3d box;
    double work = 0;
    bool of_boxes = false;
    for (const world::Placement& placement : world->build) {
        ++placed[placement.object];
        const world::Object& object = world->objects[placement.object];
        const mesh::Mesh& mesh = world->meshes[object.mesh];
        work += static_cast<double>(mesh.positions.size());
        of_boxes = of_boxes || world->is_made(object.mesh);
        if (work > kMostVertices) continue;
        for (const Vec3d& p : mesh.positions)
            box.add(placement.transform.apply(p));
    }
    for (size_t i = 0; i < placed.size(); ++i) {
        const world::Object& object = world->objects[i];
        show(fmt::format("object     {}: mesh {}, fablet {}, placed {} times\n",
                         printable(object.name), printable(world->meshes[object.mesh].name),
                         printable(object.fablet), placed[i]));
    }
    const Vec3d size = box.size();
    show(fmt::format("build      {} placed", world->build.size()));
    if (work <= kMostVertices) {
        // What a stage fills of its box is found by programs that are compiled for the print.
        show(fmt::format(", {}{:.5g} x {:.5g} x {:.5g} mm, from {:.5g} {:.5g} {:.5g}",
                         of_boxes ? "within " : "", size.x, size.y, size.z, box.lo.x, box.lo.y,
                         box.lo.z));
    }
    show("\n");
    for (const std::string& warning : world->warnings)
        warn(warning);
    return {};
}

}  // namespace

Result<void> info(const std::string& file, const std::vector<std::string>& allow,
                  const std::string& memory, bool json) {
    const Result<int64_t> bytes = parse_memory_option(memory);
    if (!bytes) return bytes.error();
    if (json && !mesh::is_mesh_file(file)) return usage_error(messages::kJsonIsForMeshes);
    std::error_code status;
    if (fs::is_directory(file, status)) {
        if (zarr::is_store(file))
            return fs::exists(fs::path(file) / "openfab", status) ? info_of_store(file, *bytes)
                                                                  : list_texture(file, *bytes);
        const bool of_slices = fs::exists(fs::path(file) / "manifest.json", status);
        return of_slices || !is_volume_folder(file) ? info_of_folder(file)
                                                    : list_texture(file, *bytes);
    }
    if (file.ends_with(".json")) return info_of_world(file, allow, *bytes);
    if (mesh::is_mesh_file(file)) {
        const Result<void> listed = list_mesh(file, {.json = json, .memory_bytes = *bytes});
        if (listed && !json) show(part_of_mesh(file, *bytes));
        return listed;
    }
    if (is_texture_file(file)) return list_texture(file, *bytes);
    return prints::is_gcvf(file) ? info_of_gcvf(file, *bytes) : info_of_ofr(file, *bytes);
}

}  // namespace openfab::tools
