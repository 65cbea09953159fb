// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/part_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/common/output_file.h"
#include "base/input_file.h"
#include "mechanics/messages.h"
#include "mechanics/part/doubts.h"

namespace openfab::mechanics {

namespace {
namespace fs = std::filesystem;

/// What is in memory besides grids.
constexpr int64_t kProgram = 40 << 20;
}  // namespace

Result<PartSource> PartSource::open(const CommonOptions& o, const fs::path& folder) {
    const fs::path file = o.materials.empty() ? properties_beside(o.input) : fs::path(o.materials);
    Result<Properties> properties = read_properties(file);
    if (!properties) return properties.error();
    if (!o.law.empty()) properties->law = *law_of(o.law);
    if (properties->law == Law::kTable && !properties->table)
        return user_error(fmt::format(messages::kLawWithoutTable, file.string()));
    return PartSource(o, folder, std::move(*properties));
}

PrintRequest PartSource::request(double pitch_mm) const {
    return {o_.input,  o_.programs, pitch_mm, o_.supersample, o_.codes,
            o_.dither, o_.settings, o_.allow, o_.threads,     o_.memory_bytes};
}

Result<std::array<double, 3>> PartSource::size_mm() const {
    if (!size_mm_) {
        const Result<std::array<double, 3>> size = build_size(request(0), folder_);
        if (!size) return size.error();
        size_mm_ = *size;
    }
    return *size_mm_;
}

Result<void> PartSource::check_size(double pitch_mm,
                                    const std::function<int64_t(const Grid&)>& bytes) const {
    const Result<std::array<double, 3>> size = size_mm();
    if (!size) return size.error();
    std::array<int32_t, 3> elements;
    for (size_t a = 0; a < 3; ++a) {
        // A print may begin and end a voxel further in.
        constexpr double kMost = 1e5;
        elements[a] =
            static_cast<int32_t>(std::clamp(std::floor((*size)[a] / pitch_mm), 1.0, kMost));
    }
    const Grid grid = Grid::make(elements, {pitch_mm, pitch_mm, pitch_mm}, false);
    return check_memory(bytes(grid) + kProgram, o_.memory_bytes, elements);
}

Result<double> PartSource::pitch_mm() const {
    if (o_.voxel_mm > 0) return o_.voxel_mm;
    const Result<std::array<double, 3>> size = size_mm();
    if (!size) return size.error();
    constexpr double kElements = 96;
    return *std::ranges::max_element(*size) / kElements;
}

Result<ObjectVoxels> PartSource::object(const std::string& name, double pitch_mm) const {
    const Result<std::string> text = object_world(o_.input, name, folder_);
    if (!text) return text.error();
    PrintRequest r = request(pitch_mm);
    r.world = folder_ / "object.fab.json";
    r.codes = false;
    r.supersample = 1;
    r.allow.push_back(reading_root(fs::absolute(o_.input).parent_path()).string());
    // The object has another fablet.
    std::erase_if(r.settings, [&](const std::string& one) { return one.starts_with(name + "."); });
    if (Result<void> done = backends::write_whole_file(r.world, *text); !done) return done.error();
    const Result<fs::path> printed = print_voxels(r, folder_, "object");
    if (!printed) return printed.error();
    const Result<VoxelFile> file = open_voxels(*printed);
    if (!file) return file.error();
    Properties any;
    std::vector<Material> materials;
    for (const std::string& one : file->materials) {
        Material m;
        m.name = one;
        m.young_MPa = 1;
        materials.push_back(m);
    }
    const Result<Voxels> voxels = read_voxels(*file, Mixture(std::move(materials), any));
    if (!voxels) return voxels.error();
    ObjectVoxels out{name, voxels->size, voxels->origin_mm, {}};
    for (const float share : voxels->solid)
        out.inside.push_back(share > 0 ? 1 : 0);
    return out;
}

Result<std::vector<Material>> PartSource::materials_of(
    const std::vector<std::string>& names) const {
    if (conducts_ == CaseKind::kForces) return properties_.of(names);
    Result<std::vector<Material>> out = properties_.of(names, false);
    if (!out) return out.error();
    for (Material& m : *out) {
        const bool current = conducts_ == CaseKind::kCurrent;
        if (current) m.conductivity = m.conductivity_S_m;
        if (!m.conductivity)
            return user_error(
                fmt::format(messages::kMaterialLacks, properties_.file, m.name,
                            current ? "conductivity_S_m" : "conductivity_W_mK"),
                current ? messages::kGiveConductivity : messages::kGiveHeatConductivity);
        // What is there, is solid.
        m.young_MPa = 1;
        m.poisson = 0;
    }
    return out;
}

Result<PartInput> PartSource::read(double pitch_mm, const std::vector<std::string>& objects,
                                   const std::function<int64_t(const Grid&)>& bytes) const {
    PartInput out;
    for (const std::string& name : objects) {
        Result<ObjectVoxels> one = object(name, pitch_mm);
        if (!one) return one.error();
        out.objects.push_back(std::move(*one));
    }
    if (Result<void> fits = check_size(pitch_mm, bytes); !fits) return fits.error();
    const Result<fs::path> printed = print_voxels(request(pitch_mm), folder_, "part");
    if (!printed) return printed.error();
    const Result<VoxelFile> file = open_voxels(*printed);
    if (!file) return file.error();
    const Grid grid = Grid::make(file->size, file->pitch_mm, false);
    if (Result<void> fits = check_memory(bytes(grid) + kProgram, o_.memory_bytes, file->size);
        !fits)
        return fits.error();
    Result<std::vector<Material>> materials = materials_of(file->materials);
    if (!materials) return materials.error();
    for (const Material& m : *materials)
        for (std::string& one : unit_doubts(std::span(properties_.find(m.name), 1)))
            out.doubts.push_back(std::move(one));
    const Mixture mixture(*materials, properties_);
    if (const std::string bad = mixture.complaint(); !bad.empty()) return user_error(bad);
    Result<Voxels> voxels = read_voxels(*file, mixture, keeps_shares_);
    if (!voxels) return voxels.error();
    out.voxels = std::move(*voxels);
    out.materials = std::move(*materials);
    std::error_code ignored;
    fs::remove(*printed, ignored);
    return out;
}

Result<PartInput> PartSource::read_halved(double pitch_mm, const LoadCase& load_case,
                                          const std::function<int64_t(const Grid&)>& bytes) const {
    if (!o_.codes) return read(pitch_mm / 2, load_case, bytes);
    Result<PartInput> out = read(pitch_mm, load_case, [&](const Grid& g) {
        Grid half = g;
        for (size_t a = 0; a < 3; ++a)
            half.elements[a] *= 2;
        half = Grid::make(half.elements, half.pitch_mm, false);
        return bytes(half) + g.element_count() * Voxels::bytes_per_voxel();
    });
    if (out) out->voxels = halved(out->voxels);
    return out;
}

Result<void> PartSource::check_gravity(const PartInput& input, const LoadCase& load_case) const {
    if (!load_case.gravity_m_s2) return {};
    for (const Material& m : input.materials)
        if (!m.density_g_cm3)
            return user_error(fmt::format(messages::kGravityWithoutDensity, properties_.file,
                                          m.name, load_case.name));
    return {};
}

std::string PartSource::law() const {
    return o_.codes ? messages::kAsDithered
                    : fmt::format(messages::kMixturesBy,
                                  kLawNames[static_cast<size_t>(properties_.law)]);
}

}  // namespace openfab::mechanics
