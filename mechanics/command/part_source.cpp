// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/part_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/sample_parts.h"
#include "mechanics/messages.h"
#include "mechanics/part/doubts.h"

namespace openfab::mechanics {

namespace {
namespace fs = std::filesystem;

/// What is in memory besides grids.
constexpr int64_t kProgram = 40 << 20;
}  // namespace

Result<PartSource> PartSource::open(const CommonOptions& o, const fs::path& folder) {
    Result<Properties> properties = properties_of(o);
    if (!properties) return properties.error();
    return PartSource(o, folder, std::move(*properties));
}

Result<PrintRequest> PartSource::request(const Vec3& pitch_mm) const {
    PrintRequest out{o_.input,    o_.programs, pitch_mm, 0,          o_.codes,       o_.dither,
                     o_.settings, o_.allow,    field_,   o_.threads, o_.memory_bytes};
    if (o_.codes || !(pitch_mm[0] > 0)) return out;
    const Result<BuildSize> size = this->size();
    if (!size) return size.error();
    const Vec3& own = size->printer_pitch_mm;
    out.supersample = parts_of_elements(o_, pitch_mm, own);
    // Elements begin where the part does, up to a sample: a wall of three is three of them.
    for (size_t a = 0; a < 3; ++a)
        out.lattice_mm[a] =
            pitch_mm[a] /
            (out.supersample > 0 ? out.supersample : samples_along(pitch_mm[a], own[a]));
    return out;
}

Result<BuildSize> PartSource::size() const {
    if (!size_) {
        const Result<PrintRequest> any = request({});
        const Result<BuildSize> size = build_size(*any, folder_);
        if (!size) return size.error();
        size_ = *size;
    }
    return *size_;
}

Result<void> PartSource::check_size(const Vec3& pitch_mm,
                                    const std::function<int64_t(const Grid&)>& bytes) const {
    const Result<BuildSize> size = this->size();
    if (!size) return size.error();
    std::array<int32_t, 3> elements;
    for (size_t a = 0; a < 3; ++a) {
        // A print may begin and end a voxel further in.
        constexpr double kMost = 1e5;
        elements[a] =
            static_cast<int32_t>(std::clamp(std::floor(size->mm[a] / pitch_mm[a]), 1.0, kMost));
    }
    const Grid grid = Grid::make(elements, pitch_mm, false);
    return check_memory(bytes(grid) + kProgram, o_.memory_bytes, elements);
}

Result<Vec3> PartSource::pitch_mm() const {
    const bool given = o_.voxel_mm[0] > 0;
    if (given && !o_.codes) return o_.voxel_mm;
    const Result<BuildSize> size = this->size();
    if (!size) return size.error();
    const Vec3& own = size->printer_pitch_mm;
    note_other_codes(o_, own);
    if (given) return o_.voxel_mm;
    if (o_.codes) {
        if (own[0] > 0 && own[1] > 0 && own[2] > 0) return own;
        return user_error(messages::kPitchOfCodes, messages::kGivePitchOfCodes);
    }
    constexpr double kElements = 96;
    const double side = *std::ranges::max_element(size->mm) / kElements;
    return Vec3{side, side, side};
}

Result<ObjectVoxels> PartSource::object(const std::string& name,
                                        const PrintRequest& request) const {
    // A face looks for the object up to a voxel before itself.
    constexpr int kAround = 1;
    const Result<fs::path> printed = print_object(request, name, kAround, folder_);
    if (!printed) return printed.error();
    const Result<VoxelFile> file = open_voxels(*printed);
    if (!file) return file.error();
    ObjectVoxels out{name, file->size, file->origin_mm, {}};
    Result<std::vector<uint8_t>> codes = read_codes(*file);
    if (!codes) return codes.error();
    out.inside = std::move(*codes);
    return out;
}

Result<std::vector<Material>> PartSource::materials_of(const VoxelFile& file) const {
    const Result<std::vector<uint8_t>> used = used_materials(file);
    if (!used) return used.error();
    const bool stiff = conducts_ == CaseKind::kForces;
    Result<std::vector<Material>> out = properties_.of(file.materials, *used, stiff);
    if (!out || stiff) return out;
    for (size_t k = 0; k < out->size(); ++k) {
        Material& m = (*out)[k];
        const bool current = conducts_ == CaseKind::kCurrent;
        if (current) m.conductivity = m.conductivity_S_m;
        if (!m.conductivity && (*used)[k] != 0)
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

Result<PartInput> PartSource::read(const Vec3& pitch_mm, const std::vector<std::string>& objects,
                                   const std::function<int64_t(const Grid&)>& bytes) const {
    PartInput out;
    const Result<PrintRequest> request = this->request(pitch_mm);
    if (!request) return request.error();
    for (const std::string& name : objects) {
        Result<ObjectVoxels> one = object(name, *request);
        if (!one) return one.error();
        out.objects.push_back(std::move(*one));
    }
    if (Result<void> fits = check_size(pitch_mm, bytes); !fits) return fits.error();
    const Result<fs::path> printed = print_voxels(*request, folder_, "part");
    if (!printed) return printed.error();
    const Result<VoxelFile> file = open_voxels(*printed);
    if (!file) return file.error();
    const Grid grid = Grid::make(file->size, file->pitch_mm, false);
    if (Result<void> fits = check_memory(bytes(grid) + kProgram, o_.memory_bytes, file->size);
        !fits)
        return fits.error();
    Result<std::vector<Material>> materials = materials_of(*file);
    if (!materials) return materials.error();
    for (const Material& m : *materials) {
        if (!m.used) continue;  // the file may not have it
        const std::span<const Material> one(properties_.find(m.name), 1);
        for (std::string& doubt : unit_doubts(one))
            out.doubts.push_back(std::move(doubt));
        for (std::string& doubt : condition_doubts(one, properties_))
            out.doubts.push_back(std::move(doubt));
    }
    for (std::string& one : table_doubts(properties_))
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

Result<PartInput> PartSource::read_halved(const Vec3& pitch_mm, const LoadCase& load_case,
                                          const std::function<int64_t(const Grid&)>& bytes) const {
    if (!o_.codes)
        return read({pitch_mm[0] / 2, pitch_mm[1] / 2, pitch_mm[2] / 2}, load_case, bytes);
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

Result<FootLayers> PartSource::read_foot(const Vec3& pitch_mm, double height_mm) const {
    const Result<BuildSize> size = this->size();
    if (!size) return size.error();
    // Many to a side whatever elements there are, so that what a foot is like does not depend on these; cubes, but in
    // a plate, which has some layers as well.
    constexpr double kAlong = 512, kMostAlong = 2000, kFiner = 4, kOfHeight = 32;
    const double side = std::max(size->mm[0], size->mm[1]);
    const double pitch = std::max(
        std::min(side / kAlong, *std::ranges::min_element(pitch_mm) / kFiner), side / kMostAlong);
    const double layer = std::min(pitch, size->mm[2] / kOfHeight);
    const Result<PrintRequest> asked = request(pitch_mm);
    if (!asked) return asked.error();
    PrintRequest request = *asked;
    request.pitch_mm = {pitch, pitch, layer};
    request.supersample = 0;
    for (size_t a = 0; a < 3; ++a)
        request.lattice_mm[a] = request.pitch_mm[a] / 8;
    // The lowest element may be the second of a part that begins within the first.
    const double above = height_mm + 2 * std::min(pitch_mm[2], size->mm[2]);
    const int slices = static_cast<int>(std::ceil(above / layer)) + kFootLayers;
    // A plate is printed whole.
    const double least = size->mm[2] - 2 * BuildSize::kPitch_mm;
    const Result<fs::path> printed =
        print_lowest(request, slices < std::floor(least / layer) ? slices : 0, folder_);
    if (!printed) return printed.error();
    const Result<VoxelFile> file = open_voxels(*printed);
    if (!file) return file.error();
    Result<std::vector<uint8_t>> codes = read_codes(*file);
    if (!codes) return codes.error();
    FootLayers out{file->size, file->pitch_mm, file->origin_mm, std::move(*codes)};
    std::error_code ignored;
    fs::remove(*printed, ignored);
    return out;
}

Result<void> PartSource::check_gravity(const PartInput& input, const LoadCase& load_case) const {
    if (!load_case.gravity_m_s2) return {};
    for (const Material& m : input.materials)
        if (!m.density_g_cm3 && m.used)
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
