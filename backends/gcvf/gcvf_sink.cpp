// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/gcvf_sink.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "backends/common/messages.h"
#include "backends/common/xml_text.h"
#include "backends/gcvf/messages.h"
#include "backends/gcvf/solid_bits.h"
#include "backends/raster/png_slice.h"
#include "base/check.h"
#include "base/text.h"

namespace openfab::gcvf {

namespace {

constexpr const char* kPrefix = "slice_";
constexpr int32_t kMostSlices = 1 << 16;  // that 16-bit grey can tell apart

static_assert(std::endian::native == std::endian::little, "floats are written as they lie");

std::string_view text_of(std::span<const uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string rgba(const std::array<uint8_t, 4>& c) {
    return fmt::format("{} {} {} {}", c[0], c[1], c[2], c[3]);
}

/// The box of the printed voxels, counted from the first slice; nothing printed: all 0.
std::array<float, 6> bounds(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals) {
    if (totals.voxels_solid == 0) return {};
    Box3i box = totals.tight;
    box.lo.z -= info.slice_begin;
    box.hi.z -= info.slice_begin;
    std::array<float, 6> out{};
    for (int axis = 0; axis < 3; ++axis) {
        out[static_cast<size_t>(axis)] = static_cast<float>(box.lo[axis]);
        out[static_cast<size_t>(axis) + 3] = static_cast<float>(box.hi[axis]);
    }
    return out;
}

}  // namespace

std::string config_xml(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                       bool flip_x) {
    std::string materials;
    for (size_t m = 0; m < info.materials.size(); ++m) {
        const size_t code = m + 1;
        materials += fmt::format(
            "    <Material>\n      <Name>{}</Name>\n      <RGBA>{}</RGBA>\n"
            "      <VoxelCount>{}</VoxelCount>\n    </Material>\n",
            backends::escape_xml(valid_utf8(info.materials[m].name)), rgba(info.materials[m].key),
            code < totals.voxels_by_code.size() ? totals.voxels_by_code[code] : 0);
    }
    // Six digits are finer than any printer, and avoid 599.9999999999999.
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<GCVF>\n"
        "  <Version>2</Version>\n"
        "  <Resolution>\n"
        "    <XDpi>{:.6g}</XDpi>\n"
        "    <YDpi>{:.6g}</YDpi>\n"
        "    <SliceThicknessNanoMeter>{}</SliceThicknessNanoMeter>\n"
        "  </Resolution>\n"
        "  <SliceDimensions>\n"
        "    <SliceWidth>{}</SliceWidth>\n"
        "    <SliceHeight>{}</SliceHeight>\n"
        "  </SliceDimensions>\n"
        "  <SliceRange>\n"
        "    <StartIndex>0</StartIndex>\n"
        "    <NumberOfSlices>{}</NumberOfSlices>\n"
        "  </SliceRange>\n"
        "  <BitDepth>4</BitDepth>\n"
        "  <MaxNumberOfColors>{}</MaxNumberOfColors>\n"
        "  <DataSemantics>Materials</DataSemantics>\n"
        "  <CreationMode>MODEL_ONLY</CreationMode>\n"
        "  <ImageFilePrefix>{}</ImageFilePrefix>\n"
        "  <MaterialList>\n"
        "    <BackGroundMaterialRGBA>{}</BackGroundMaterialRGBA>\n"
        "{}"
        "  </MaterialList>\n"
        "  <!-- openfab slices=\"{}:{}\" of=\"{}\" flipped=\"{}\" hash=\"{:016x}\" -->\n"
        "</GCVF>\n",
        25.4 / info.pitch_mm.x, 25.4 / info.pitch_mm.y, std::llround(info.pitch_mm.z * 1e6),
        info.size.x, info.size.y, info.slice_end - info.slice_begin, kMostMaterials, kPrefix,
        rgba({0, 0, 0, 0}), materials, info.slice_begin, info.slice_end, info.size.z,
        flip_x ? 1 : 0, totals.hash);
}

Result<void> GcvfSink::begin(const pipeline::PrintInfo& info) {
    info_ = info;
    broken_ = true;  // until all of this is done
    if (info.materials.size() > kMostMaterials) {
        return user_error(
            fmt::format(messages::kTooManyMaterials, info.materials.size(), kMostMaterials));
    }
    if (raster::shares_a_color(info)) {
        return user_error(messages::kSameKeys);
    }
    if (info.slice_end - info.slice_begin > kMostSlices) {
        return user_error(fmt::format(messages::kTooManySlices, info.slice_end - info.slice_begin,
                                      kMostSlices, kMostSlices));
    }
    Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(path_);
    if (!file) return file.error();
    file_ = std::move(*file);
    Result<backends::OutputFile*> out = file_->flushed();
    if (!out) return out.error();
    Result<std::unique_ptr<backends::Package>> package = backends::Package::create(*out);
    if (!package) return package.error();
    package_ = std::move(*package);
    Result<std::unique_ptr<CoarseMesh>> mesh = CoarseMesh::create(info, path_.parent_path());
    if (!mesh) return mesh.error();
    mesh_ = std::move(*mesh);
    heights_.emplace(info.size.x, info.size.y);
    solid_bytes_ = solid_row_bytes(info.size.x) * static_cast<size_t>(info.size.y);
    broken_ = false;
    return {};
}

/// Returns the solid bits, the size and checksum of the PNG, and the PNG deflated.
std::vector<uint8_t> GcvfSink::encode(const pipeline::SliceView& slice) const {
    const std::vector<uint8_t> png = raster::encode_png_slice(slice, info_, false, flip_x_);
    backends::TextSum sum;
    const std::vector<uint8_t> packed = backends::deflate_text(text_of(png), true, &sum);
    if (png.empty() || packed.empty()) return {};
    std::vector<uint8_t> out(solid_bytes_ + sizeof sum + packed.size());
    put_solid_bits(slice, info_.bits, std::span(out).first(solid_bytes_));
    std::memcpy(out.data() + solid_bytes_, &sum, sizeof sum);
    std::memcpy(out.data() + solid_bytes_ + sizeof sum, packed.data(), packed.size());
    return out;
}

Result<void> GcvfSink::commit(int32_t z, std::vector<uint8_t> bytes) {
    OPENFAB_CHECK(package_ != nullptr);  // begun, and not finished
    Result<void> done =
        bytes.empty() ? internal_error(fmt::format(backends::messages::kSliceNotCompressed, z))
                      : add(z - info_.slice_begin, bytes);
    broken_ = broken_ || !done;
    return done;
}

Result<void> GcvfSink::add(int32_t z, std::span<const uint8_t> bytes) {
    backends::TextSum sum;
    const std::span<const uint8_t> solid = bytes.first(solid_bytes_);
    std::memcpy(&sum, bytes.data() + solid_bytes_, sizeof sum);
    const std::span<const uint8_t> packed = bytes.subspan(solid_bytes_ + sizeof sum);
    heights_->add(static_cast<uint16_t>(z), solid);
    Result<void> done = mesh_->add(solid);
    if (done) {
        done = package_->begin_packed(fmt::format("{}{}.png", kPrefix, z),
                                      std::max(sum.bytes, static_cast<int64_t>(packed.size())));
    }
    if (done) done = package_->write_packed(packed);
    return done ? package_->end_packed(sum) : done;
}

Result<void> GcvfSink::write_rest(const pipeline::PrintTotals& totals) {
    Result<void> done = package_->add("ConfigFile.xml", config_xml(info_, totals, flip_x_));
    if (done) done = mesh_->finish(package_.get(), "Mesh.stl");
    if (done) {
        const std::array<float, 6> box = bounds(info_, totals);
        done =
            package_->add("MeshBbx.ktn", {reinterpret_cast<const char*>(box.data()), sizeof box});
    }
    if (done) {
        const std::vector<uint8_t> png = heights_->png(flip_x_);
        done = png.empty() ? outside_error(backends::messages::kOutOfMemory)
                           : package_->add("Zbuffer.png", text_of(png));
    }
    if (done) done = package_->close();
    return done ? file_->keep() : done;
}

Result<void> GcvfSink::finish(const pipeline::PrintTotals& totals) {
    Result<void> done;
    if (broken_) {
        // Reported already.
    } else if (!totals.complete) {
        done = Error{ErrorCode::kInterrupted, messages::kEndedEarly};
    } else {
        done = write_rest(totals);
    }
    mesh_.reset();
    package_.reset();
    file_.reset();
    return done;
}

}  // namespace openfab::gcvf
