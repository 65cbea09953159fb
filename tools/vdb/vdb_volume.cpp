// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/vdb/vdb_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <type_traits>

#include "base/input_file.h"
#include "base/units.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/write_volume.h"
#include "tools/vdb/messages.h"
#include "tools/vdb/openvdb.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

template <typename T>
constexpr int32_t kChannels = openvdb::VecTraits<T>::Size;

template <typename T>
float component(const T& value, [[maybe_unused]] int32_t channel) {
    if constexpr (kChannels<T> == 1) {
        return static_cast<float>(value);
    } else {
        return static_cast<float>(value[channel]);
    }
}

/// Whether a float holds an integer.
bool is_held(int64_t value) {
    const auto bits = static_cast<uint64_t>(value);
    const uint64_t size = value < 0 ? 0 - bits : bits;
    return size == 0 ||
           std::bit_width(size) - std::countr_zero(size) <= std::numeric_limits<float>::digits;
}

/// A grid whose axes are those of space, slice by slice.
template <typename Grid>
class GridReader final : public VolumeReader {
  public:
    GridReader(typename Grid::Ptr grid, const openvdb::CoordBBox& box,
               std::optional<double> outside)
        : grid_(std::move(grid)), low_(box.min()), outside_(outside) {
        const openvdb::Coord extent = box.dim();
        size = {extent.x(), extent.y(), extent.z()};
        channels = kChannels<typename Grid::ValueType>;
        // A grid has its background wherever it has no voxels.
        for (int32_t c = 0; c < channels; ++c)
            beyond[static_cast<size_t>(c)] = component(grid_->background(), c);
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        typename Grid::ConstAccessor accessor = grid_->getConstAccessor();
        for (int32_t y = 0; y < size.y; ++y) {
            for (int32_t x = 0; x < size.x; ++x) {
                typename Grid::ValueType value;
                const bool active = accessor.probeValue(low_.offsetBy(x, y, z), value);
                if constexpr (std::is_integral_v<typename Grid::ValueType>)
                    rounded = rounded || (active && !is_held(value));
                for (int32_t c = 0; c < channels; ++c)
                    *out++ =
                        active || !outside_ ? component(value, c) : static_cast<float>(*outside_);
            }
            wrote(4 * row_floats());
        }
        return {};
    }

  private:
    typename Grid::Ptr grid_;
    openvdb::Coord low_;
    std::optional<double> outside_;
};

/// Where voxels of the box lie, mm.
GridFrame frame_of(const openvdb::GridBase& grid, const openvdb::Coord& low, double unit) {
    const auto at = [&](const openvdb::Coord& index) {
        const openvdb::Vec3d p = grid.transform().indexToWorld(index) * unit;
        return Vec3d{p[0], p[1], p[2]};
    };
    GridFrame frame;
    frame.first = at(low);
    for (int a = 0; a < 3; ++a) {
        openvdb::Coord next = low;
        next[a] += 1;
        frame.steps[static_cast<size_t>(a)] = at(next) - frame.first;
    }
    return frame;
}

Result<openvdb::CoordBBox> box_of(const openvdb::GridBase& grid) {
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) return user_error(fmt::format(messages::kGridEmpty, grid.getName()));
    for (int a = 0; a < 3; ++a) {
        constexpr int64_t kMost = 16384;
        const int64_t side = int64_t{box.max()[a]} - box.min()[a] + 1;
        if (side > kMost) {
            return user_error(
                fmt::format(messages::kGridTooLarge, grid.getName(), side, "xyz"[a], kMost));
        }
    }
    return box;
}

template <typename Grid>
MadeReader open_grid(const openvdb::GridBase::Ptr& base, double unit,
                     const texture::VolumeOptions& options, const texture::ReadLimits& limits) {
    const Result<openvdb::CoordBBox> box = box_of(*base);
    if (!box) return box.error();
    const GridFrame frame = frame_of(*base, box->min(), unit);
    auto reader =
        std::make_unique<GridReader<Grid>>(openvdb::gridPtrCast<Grid>(base), *box, options.outside);
    return place_reader(std::move(reader), frame, options, limits);
}

Result<std::string> choose(openvdb::io::File* file, const std::string& wanted) {
    std::vector<std::string> names;
    for (auto name = file->beginName(); name != file->endName(); ++name)
        names.push_back(name.gridName());
    if (names.empty()) return user_error(messages::kNoGrid);
    if (wanted.empty() && names.size() == 1) return names.front();
    if (std::find(names.begin(), names.end(), wanted) != names.end()) return wanted;
    std::string all;
    for (const std::string& name : names)
        all += fmt::format("{}`{}`", all.empty() ? "" : ", ", name);
    if (wanted.empty())
        return user_error(messages::kSeveralGrids + all + messages::kSeveralGridsHelp);
    return user_error(fmt::format(messages::kNoSuchGrid, wanted, all));
}

/// The unit that the options or the file name, in mm.
double unit_of(const openvdb::io::File& file, const texture::VolumeOptions& options) {
    if (!options.unit.empty()) return unit_mm(options);
    const openvdb::MetaMap::Ptr metadata = file.getMetadata();
    const auto unit = metadata->getMetadata<openvdb::StringMetadata>("unit");
    if (unit == nullptr) return 1;
    const Result<double> size = parse_length_mm("1" + unit->value());
    return size && *size > 0 ? *size : 1;
}

}  // namespace

MadeReader open_vdb_grid(const fs::path& path, const texture::VolumeOptions& options,
                         const texture::ReadLimits& limits) {
    const Result<InputFile> opened = InputFile::open(path);
    if (!opened) return opened.error();
    openvdb::initialize();
    openvdb::io::File file(opened->name());
    file.open(/*delayLoad=*/false);
    const Result<std::string> name = choose(&file, options.field);
    if (!name) return name.error();
    const double unit = unit_of(file, options);
    const openvdb::GridBase::Ptr grid = file.readGrid(*name);
    if (!grid->transform().isLinear())
        return user_error(fmt::format(messages::kGridNotLinear, *name));
    if (grid->getGridClass() == openvdb::GRID_STAGGERED)
        return user_error(fmt::format(messages::kGridStaggered, *name),
                          messages::kGridStaggeredHelp);
    if (grid->isType<openvdb::FloatGrid>())
        return open_grid<openvdb::FloatGrid>(grid, unit, options, limits);
    if (grid->isType<openvdb::DoubleGrid>())
        return open_grid<openvdb::DoubleGrid>(grid, unit, options, limits);
    if (grid->isType<openvdb::Int32Grid>())
        return open_grid<openvdb::Int32Grid>(grid, unit, options, limits);
    if (grid->isType<openvdb::Int64Grid>())
        return open_grid<openvdb::Int64Grid>(grid, unit, options, limits);
    if (grid->isType<openvdb::Vec3SGrid>())
        return open_grid<openvdb::Vec3SGrid>(grid, unit, options, limits);
    if (grid->isType<openvdb::Vec3DGrid>())
        return open_grid<openvdb::Vec3DGrid>(grid, unit, options, limits);
    return user_error(fmt::format(messages::kGridTypeNotRead, *name, grid->valueType()));
}

Result<void> make_vdb_volume_file(const fs::path& source, const fs::path& out,
                                  const texture::VolumeOptions& options,
                                  const texture::ReadLimits& limits) {
    return write_volume(source, out, options, limits,
                        [&] { return open_vdb_grid(source, options, limits); });
}

}  // namespace openfab::tools
