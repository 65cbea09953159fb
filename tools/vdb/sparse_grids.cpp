// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/vdb/sparse_grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <fstream>

#include "backends/common/part_file.h"
#include "base/units.h"
#include "tools/vdb/messages.h"
#include "tools/vdb/openvdb.h"

namespace openfab::tools {

namespace {

/// A node above the leaves, of 16 x 16 x 16 of them; the allocator adds a little to each node.
constexpr int64_t kNodeBytes =
    sizeof(openvdb::FloatTree::RootNodeType::ChildNodeType::ChildNodeType);
constexpr int64_t kAllocatorBytes = 32;

template <typename Leaf>
constexpr int64_t leaf_bytes() {
    return static_cast<int64_t>(sizeof(Leaf)) +
           512 * static_cast<int64_t>(sizeof(typename Leaf::ValueType)) + 2 * kAllocatorBytes;
}

/// OpenVDB's own writer of files does not notice a full disk.
class Archive final : public openvdb::io::Archive {
  public:
    using openvdb::io::Archive::write;
};

}  // namespace

struct SparseGrids::Grids {
    openvdb::math::Transform::Ptr transform;
    std::vector<openvdb::GridBase::Ptr> all;
    int64_t leaves_bytes = 0, nodes_bytes = 0;
    int64_t blocks = 0;
};

SparseGrids::SparseGrids(const VoxelFrame& frame, int64_t memory_bytes)
    : grids_(std::make_unique<Grids>()), memory_bytes_(memory_bytes) {
    openvdb::initialize();
    const openvdb::Vec3d scale(frame.pitch_mm.x, frame.pitch_mm.y, frame.pitch_mm.z);
    const openvdb::Vec3d corner(frame.origin_mm.x, frame.origin_mm.y, frame.origin_mm.z);
    grids_->transform =
        openvdb::math::Transform::Ptr(new openvdb::math::Transform(openvdb::math::MapBase::Ptr(
            new openvdb::math::ScaleTranslateMap(scale, corner + scale * 0.5))));
}

SparseGrids::~SparseGrids() = default;

size_t SparseGrids::add_codes(const std::string& name) {
    openvdb::Int32Grid::Ptr grid = openvdb::Int32Grid::create(0);
    grid->setName(name);
    grid->setTransform(grids_->transform);
    grids_->all.push_back(grid);
    return grids_->all.size() - 1;
}

size_t SparseGrids::add_amounts(const std::string& name) {
    openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(0);
    grid->setName(name);
    grid->setTransform(grids_->transform);
    grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    grids_->all.push_back(grid);
    return grids_->all.size() - 1;
}

void SparseGrids::note(size_t grid, const std::string& key, const std::string& text) {
    grids_->all[grid]->insertMeta(key, openvdb::StringMetadata(text));
}

Result<void> SparseGrids::set(size_t grid, const Vec3i& corner, const VoxelBlock<int32_t>& codes) {
    return set_block(static_cast<openvdb::Int32Grid&>(*grids_->all[grid]), corner, codes);
}

Result<void> SparseGrids::set(size_t grid, const Vec3i& corner, const VoxelBlock<float>& amounts) {
    return set_block(static_cast<openvdb::FloatGrid&>(*grids_->all[grid]), corner, amounts);
}

template <typename Grid, typename T>
Result<void> SparseGrids::set_block(Grid& grid, const Vec3i& corner, const VoxelBlock<T>& values) {
    using Leaf = typename Grid::TreeType::LeafNodeType;
    const openvdb::Coord at(corner.x, corner.y, corner.z);
    const bool uniform =
        std::all_of(values.begin(), values.end(), [&](T value) { return value == values.front(); });
    if (uniform && values.front() == T{}) return {};
    if (uniform) {
        grid.tree().addTile(1, at, values.front(), true);
    } else {
        auto leaf = std::make_unique<Leaf>(at, T{}, false);
        for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
            if (values[n] != T{}) leaf->setValueOn(n, values[n]);
        grid.tree().addLeaf(leaf.release());
        grids_->leaves_bytes += leaf_bytes<Leaf>();
    }
    constexpr int64_t kBlocksACount = 1024;
    if (grids_->blocks++ % kBlocksACount == 0) {
        grids_->nodes_bytes = 0;
        for (const openvdb::GridBase::Ptr& each : grids_->all)
            grids_->nodes_bytes += static_cast<int64_t>(each->baseTree().nonLeafCount()) *
                                   (kNodeBytes + kAllocatorBytes);
    }
    if (grids_->leaves_bytes + grids_->nodes_bytes <= memory_bytes_) return {};
    return user_error(
        fmt::format(messages::kGridsTooLarge, corner.z + 7, format_bytes(memory_bytes_)));
}

Result<void> SparseGrids::write(const std::filesystem::path& path) const {
    Result<std::unique_ptr<backends::PartFile>> file = backends::PartFile::create(path);
    if (!file) return file.error();
    const auto failed = [&](const char* why) {
        return outside_error(fmt::format(messages::kCannotWriteTo, path.string(), why));
    };
    // Opened again by its name: the other is for its lock, and to be synced.
    std::ofstream out((*file)->temporary_path(), std::ios::binary);
    errno = 0;
    try {
        openvdb::MetaMap metadata;
        metadata.insertMeta("creator", openvdb::StringMetadata("OpenFab"));
        metadata.insertMeta("unit", openvdb::StringMetadata("mm"));
        for (const openvdb::GridBase::Ptr& grid : grids_->all)
            grid->pruneGrid();
        const openvdb::GridCPtrVec all(grids_->all.begin(), grids_->all.end());
        Archive().write(out, all, /*seekable=*/true, metadata);
    } catch (const std::exception& error) {
        return failed(error.what());
    }
    if (!out.flush()) return failed(errno != 0 ? std::strerror(errno) : messages::kDiskFailed);
    out.close();
    return (*file)->keep();
}

}  // namespace openfab::tools
