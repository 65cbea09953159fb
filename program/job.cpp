// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "abi/kernel_call.h"
#include "backends/formats/formats.h"
#include "base/near_miss.h"
#include "base/text.h"
#include "mesh/load/load_mesh.h"
#include "program/altered_world.h"
#include "program/build_volume.h"
#include "program/messages.h"
#include "program/outputs.h"
#include "program/process.h"
#include "program/process_field.h"
#include "runtime/part/bind.h"
#include "runtime/process/kinds/kinds.h"
#include "runtime/solid/kinds/kinds.h"
#include "world/world.h"

namespace openfab::program {

namespace {

bool is_world(const std::string& input) {
    return input.ends_with(".json");
}

world::FileRules file_rules(const Options& options) {
    return world::rules_of(options.allow, options.memory_bytes);
}

std::string title_of(const std::string& input) {
    std::string name = std::filesystem::path(input).filename().string();
    for (const std::string suffix : {".fab.json", ".json"}) {
        if (name.size() > suffix.size() && name.ends_with(suffix))
            return name.substr(0, name.size() - suffix.size());
    }
    return mesh::is_mesh_file(name) ? std::filesystem::path(name).stem().string() : name;
}

/// Returns whether voxels have the pitch of meshes: not where the printer's own format is a mesh, for
/// which its pitch is meant, if it is known.
bool has_mesh_pitch(const Options& options, const world::Printer& printer,
                    const backends::Format* format) {
    return is_mesh_format(format) && (format->name != printer.native_format ||
                                      options.mesh_pitch_mm || !printer.knows_pitch());
}

std::string printer_source(const Options& options, const world::World& world) {
    const std::string& name = options.printer.empty() ? world.printer : options.printer;
    return name.empty() ? "generic" : name;
}

Result<world::Printer> printer_of(const Options& options, const world::World& world,
                                  std::vector<std::string>* notes) {
    const std::string name = printer_source(options, world);
    const bool named = !options.printer.empty() || !world.printer.empty();
    const bool chosen = named && (is_world(options.input) || !options.printer.empty());
    Result<world::Printer> printer = world::load_printer(name);
    if (!printer) return printer;
    const Result<const backends::Format*> format = choose_format(options, *printer);
    if (!format) return format.error();
    if (Result<void> fine = check_mesh_pitch(options, *format); !fine) return fine.error();
    if (has_mesh_colors(*format, *printer) && !(*format)->needs_mixtures)
        notes->push_back(fmt::format(messages::kColorsOfPreviews, printer->name));
    if (has_mesh_pitch(options, *printer, *format)) {
        if (!options.mesh_pitch_mm && !pitch_is_given(options)) {
            notes->push_back(fmt::format(messages::kMeshesMadeFrom, kMeshPitchMm * options.draft));
        }
        return printer;
    }
    const bool pitch_given =
        options.pitch_mm || options.voxel_mm || (options.dpi && options.layer_mm);
    if (!chosen && !pitch_given) {
        notes->push_back(fmt::format(messages::kNoPrinterNamed, printer->name, printer->pitch_mm.x,
                                     printer->pitch_mm.y, printer->pitch_mm.z));
    }
    return printer;
}

/// A profile lists what its maker does not publish: the user must say it, but for a look.
Result<void> check_known(const Options& options, const world::Printer& printer, world::Tray tray,
                         Vec3d* pitch_mm, std::vector<std::string>* notes) {
    const bool plane = pitch_mm->x > 0 && pitch_mm->y > 0;
    const bool layer = pitch_mm->z > 0;
    if (!plane || !layer) {
        const char* what = plane   ? messages::kThicknessOfSlice
                           : layer ? messages::kResolutionAcross
                                   : messages::kResolutionAndThickness;
        const char* verb = plane || layer ? "is" : "are";
        if (!options.any_pitch) {
            const char* remedy = plane   ? messages::kGiveLayer
                                 : layer ? messages::kGiveDpi
                                         : messages::kGiveDpiAndLayer;
            return user_error(fmt::format(messages::kPitchNotKnown, what, printer.name, verb,
                                          printer.name, remedy));
        }
        const double mm = kMeshPitchMm * options.draft;
        if (!plane) pitch_mm->x = pitch_mm->y = mm;
        if (!layer) pitch_mm->z = mm;
        notes->push_back(fmt::format(messages::kPitchStandsIn, what, printer.name, verb,
                                     pitch_mm->x, pitch_mm->y, pitch_mm->z));
    }
    if (tray != world::Tray::kAnywhere && !printer.knows_build_volume()) {
        return user_error(fmt::format(messages::kTrayNotKnown, printer.name));
    }
    return {};
}

/// What has colours on its faces may have more of them than the machine has inks; without an output that is what the
/// machine takes.
Result<void> check_materials(const world::World& world, const world::Printer& printer,
                             const backends::Format* format) {
    if (format == nullptr) format = backends::find_format(printer.native_format);
    if (has_mesh_colors(format, printer) && !format->needs_mixtures) return {};
    const size_t most = static_cast<size_t>(printer.max_materials);
    if (world.materials.size() <= most) return {};
    return user_error(
        fmt::format(messages::kTooManyMaterials, world.materials.size(), printer.name, most));
}

/// Returns the code of the support material, 0 if the print has none. The printer's own is added to
/// the materials, unless the world has one of its name.
Result<int32_t> choose_support(const Options& options, const world::World& world,
                               const world::Printer& printer,
                               std::vector<pipeline::SliceMaterial>* materials) {
    world::SupportChoice choice = world.support;
    const bool named =
        !options.support.empty() && options.support != "on" && options.support != "off";
    if (!options.support.empty()) {
        choice.on = options.support != "off";
        if (named) choice.material = options.support;
    }
    if (!choice.on.value_or(!printer.makes_support)) return 0;
    std::vector<std::string> names;
    for (const pipeline::SliceMaterial& material : *materials)
        names.push_back(material.name);
    if (!choice.material.empty()) {
        const auto found = std::find(names.begin(), names.end(), choice.material);
        if (found != names.end()) return static_cast<int32_t>(found - names.begin()) + 1;
        return user_error(fmt::format(messages::kSupportOfNoMaterial, choice.material,
                                      suggest(choice.material, names)));
    }
    const world::SupportMaterial& own = printer.support_material;
    const pipeline::SliceMaterial added{own.name, own.key, own.preview, own.density_g_cm3,
                                        own.channel};
    for (size_t m = 0; m < materials->size(); ++m) {
        const pipeline::SliceMaterial& material = (*materials)[m];
        if (material.name == added.name) return static_cast<int32_t>(m) + 1;
        if (material.key != added.key) continue;
        return user_error(fmt::format(messages::kKeyOfSupport, material.name, printer.name));
    }
    materials->push_back(added);
    return static_cast<int32_t>(materials->size());
}

/// A bound that nothing needs is told once for each object.
void note_bounds_without_effect(const std::vector<part::Part>& parts,
                                std::vector<std::string>* notes) {
    std::set<std::string> told;
    for (const part::Part& part : parts) {
        const bool bounded = std::isfinite(part.max_displacement_mm);
        const std::string name = part.piece != nullptr ? std::string() : part.name;
        if (!bounded || name.empty() || part.fablet->has_surface != 0 || !told.insert(name).second)
            continue;
        notes->push_back(fmt::format(messages::kBoundWithoutEffect, name, part.fablet->name));
    }
}

std::vector<std::filesystem::path> inputs_of(const Options& options, const world::World& world) {
    std::vector<std::filesystem::path> inputs = world.files;
    for (const auto& [name, fablet] : world.fablets)
        inputs.push_back(fablet.source);
    inputs.insert(inputs.end(), options.inputs.begin(), options.inputs.end());
    for (const std::string& file : {options.printer, options.process_file}) {
        if (!file.empty()) inputs.emplace_back(file);
    }
    for (const auto& [name, value] : options.effects) {
        const process::Kind* kind = process::find_option(name);
        if (kind != nullptr && kind->option.choices.empty()) inputs.emplace_back(value);
    }
    inputs.emplace_back("/proc/self/exe");
    return inputs;
}

Result<world::World> load_without_meshes(const Options& options) {
    return world::load_world(options.input, file_rules(options), world::MeshFiles::kSkip);
}

}  // namespace

Result<std::optional<world::DitherRef>> load_rule(const Options& options) {
    if (!is_world(options.input)) return std::optional<world::DitherRef>();
    Result<world::World> world = load_without_meshes(options);
    if (!world) return world.error();
    return std::move(world->dither);
}

std::vector<std::filesystem::path> named_files(const Options& options) {
    if (is_world(options.input)) {
        Result<world::World> world = load_without_meshes(options);
        if (world) return std::move(world->files);
    }
    return {options.input};
}

Result<world::World> load_whole_world(const Options& options, const openfab_fablet_list& fablets) {
    world::FileRules rules = file_rules(options);
    rules.extent_of = [&](const world::World& unbuilt,
                          const world::Placement& placement) -> Result<Box3d> {
        const Result<part::Part> part = part::bind_geometry(
            unbuilt, placement, fablets, {options.settings, options.memory_bytes});
        if (!part) return part.error();
        return solid::extent_in_build(*part,
                                      abi::best_isa(options.isa.value_or(OPENFAB_ISA_AVX512)));
    };
    return is_world(options.input) ? world::load_world(options.input, rules)
                                   : part::make_quick_world(options.input, fablets, {},
                                                            options.settings, options.memory_bytes);
}

Result<Job> load_job(const Options& options, const openfab_fablet_list& fablets,
                     world::World* kept) {
    Result<world::World> world = load_whole_world(options, fablets);
    if (!world) return world.error();
    Job job;
    job.notes = world->notes;
    Result<world::Printer> printer = printer_of(options, *world, &job.notes);
    if (!printer) return printer.error();
    job.printer = std::move(*printer);
    if (Result<void> altered = alter_world(options, fablets, &*world, &job.input); !altered)
        return altered.error();
    if (Result<void> read = load_process_options(options, &job.printer); !read) return read.error();
    const world::Process& process = job.printer.process;
    if (process.about_mm != Vec3d{} && process.scale == Vec3d{1, 1, 1} && !options.as_built)
        world->warnings.emplace_back(messages::kAboutWithoutScale);
    scale_build(process, &*world, &job.input);
    if (Result<void> moved = displace_build(job.printer.process, options, &*world, &job.input);
        !moved)
        return moved.error();
    job.input.warnings = world->warnings;
    job.tray = world->tray;
    if (options.crop_tray) {
        // A world without a tray origin counts from the tray's corner.
        if (job.tray == world::Tray::kAnywhere) job.tray = world::Tray::kCorner;
        const Box3d tray = tray_box(job.printer, job.tray);
        job.input.crop_mm = Box3d{tray.lo, {tray.hi.x, tray.hi.y, tray.lo.z}};
    }
    const Result<const backends::Format*> format = choose_format(options, job.printer);
    if (!format) return format.error();
    if (Result<void> fine = check_materials(*world, job.printer, *format); !fine)
        return fine.error();
    Result<std::vector<part::Part>> parts =
        part::bind(*world, fablets, {options.settings, options.memory_bytes, &job.input.warnings});
    if (!parts) return parts.error();
    job.input.parts = std::move(*parts);
    note_bounds_without_effect(job.input.parts, &job.notes);
    print_only(options, *world, &job.input);
    for (const world::Material& material : world->materials) {
        job.input.materials.push_back({material.name, material.key, material.preview,
                                       material.density_g_cm3, material.channel});
    }
    Result<int32_t> support = choose_support(options, *world, job.printer, &job.input.materials);
    if (!support) return support.error();
    job.input.support_code = *support;
    job.input.pitch_mm =
        print_pitch(options, job.printer.pitch_mm, has_mesh_pitch(options, job.printer, *format));
    if (Result<void> known =
            check_known(options, job.printer, job.tray, &job.input.pitch_mm, &job.notes);
        !known)
        return known.error();
    auto effects = open_effects(options, job.printer, &job.input);
    if (!effects) return effects.error();
    job.effects = std::move(*effects);
    warn_of_costs(job.printer.process, &job.input);
    job.input.printer = job.printer.name;
    job.input.title = valid_utf8(title_of(options.input));
    job.files = world->files;
    job.inputs = inputs_of(options, *world);
    job.printer_source = printer_source(options, *world);
    for (const auto& [mesh, of] : world->boxed) {
        const world::ProgramRef* program = world::facts_of(of).program;
        if (program != nullptr) job.programs.push_back(program->command);
    }
    if (kept != nullptr) *kept = std::move(*world);
    return job;
}

}  // namespace openfab::program
