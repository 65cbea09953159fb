// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/gcvf/coarse_mesh.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "backends/boundary/stl_facet.h"
#include "backends/common/messages.h"
#include "backends/gcvf/messages.h"
#include "backends/gcvf/solid_bits.h"

namespace openfab::gcvf {

namespace {

constexpr int32_t kCell = 8;  // voxels a side: what a byte of solid bits holds
constexpr int64_t kMostTriangles = UINT32_MAX;

std::string_view text_of(std::span<const uint8_t> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Result<std::unique_ptr<CoarseMesh>> CoarseMesh::create(const pipeline::PrintInfo& info,
                                                       const std::filesystem::path& folder) {
    Result<std::unique_ptr<backends::DeflateSpool>> spool =
        backends::DeflateSpool::create(folder.empty() ? "." : folder);
    if (!spool) return spool.error();
    const Vec3i voxels{info.size.x, info.size.y, info.slice_end - info.slice_begin};
    return std::unique_ptr<CoarseMesh>(new CoarseMesh(info, voxels, std::move(*spool)));
}

CoarseMesh::CoarseMesh(const pipeline::PrintInfo& info, Vec3i voxels,
                       std::unique_ptr<backends::DeflateSpool> spool)
    : voxels_(voxels),
      origin_mm_(info.origin_mm),
      pitch_mm_(info.pitch_mm),
      width_(static_cast<int32_t>(solid_row_bytes(voxels.x))),
      height_((voxels.y + kCell - 1) / kCell),
      cells_(static_cast<size_t>(width_) * static_cast<size_t>(height_)),
      spool_(std::move(spool)),
      mesher_(width_, height_, 0, this) {
    origin_mm_.z += info.slice_begin * info.pitch_mm.z;
}

Result<void> CoarseMesh::add(std::span<const uint8_t> solid) {
    const auto width = static_cast<size_t>(width_);
    for (size_t y = 0; y < static_cast<size_t>(voxels_.y); ++y) {
        uint8_t* const cells = cells_.data() + y / kCell * width;
        for (size_t x = 0; x < width; ++x)
            cells[x] = static_cast<uint8_t>(cells[x] | (solid[y * width + x] != 0 ? 1 : 0));
    }
    return ++slices_ % kCell == 0 ? add_cells() : Result<void>();
}

Result<void> CoarseMesh::add_cells() {
    const pipeline::SliceView cells{(slices_ - 1) / kCell, cells_.data(),
                                    static_cast<size_t>(width_), width_, height_};
    Result<void> done = mesher_.add(cells, 8);
    std::fill(cells_.begin(), cells_.end(), uint8_t{0});
    return done;
}

Vec3f CoarseMesh::at(const boundary::MeshCorner& corner) const {
    Vec3f out;
    for (int axis = 0; axis < 3; ++axis) {
        const auto lattice = [&](int32_t point) { return std::min(point * kCell, voxels_[axis]); };
        // In half cells, so an odd one is the midpoint of an edge, also of one that is cut off.
        const int32_t low = corner.point[axis] >> 1, high = (corner.point[axis] + 1) >> 1;
        const double voxels =
            0.5 * (lattice(low) + lattice(high)) + corner.off[axis] * (1.0 / boundary::kSteps);
        out[axis] = static_cast<float>(origin_mm_[axis] + voxels * pitch_mm_[axis]);
    }
    return out;
}

Result<void> CoarseMesh::take_triangles(uint8_t,
                                        std::span<const boundary::MeshTriangle> triangles) {
    triangles_ += static_cast<int64_t>(triangles.size());
    if (triangles_ > kMostTriangles) return user_error(messages::kTooManyTriangles);
    facets_.resize(triangles.size() * boundary::kStlFacetBytes);
    uint8_t* out = facets_.data();
    for (const boundary::MeshTriangle& t : triangles) {
        boundary::put_stl_facet({at(t[0]), at(t[1]), at(t[2])}, out);
        out += boundary::kStlFacetBytes;
    }
    return spool_->append(text_of(facets_));
}

Result<void> CoarseMesh::finish(backends::Package* package, const std::string& name) {
    Result<void> done = slices_ % kCell == 0 ? Result<void>() : add_cells();
    if (done) done = mesher_.finish();
    if (done) done = spool_->end();
    if (!done) return done;
    backends::TextSum sum;
    const auto header = boundary::stl_header("binary STL in millimetres, 8 voxels at a time",
                                             static_cast<uint32_t>(triangles_));
    const std::vector<uint8_t> head = backends::deflate_text(text_of(header), false, &sum);
    sum.add(spool_->sum());
    const std::vector<uint8_t> tail = backends::deflate_text({}, true, &sum);
    if (head.empty() || tail.empty()) return outside_error(backends::messages::kOutOfMemory);
    constexpr int64_t kEnds = 1 << 10;
    done = package->begin_packed(name, std::max(spool_->packed_bytes() + kEnds, sum.bytes));
    if (done) done = package->write_packed(head);
    if (done) {
        done = spool_->read(
            [&](std::span<const uint8_t> bytes) { return package->write_packed(bytes); });
    }
    if (done) done = package->write_packed(tail);
    return done ? package->end_packed(sum) : done;
}

}  // namespace openfab::gcvf
