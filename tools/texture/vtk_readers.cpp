// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Volumes from VTK's image data (.vti), rectilinear (.vtr), curvilinear (.vts) and unstructured grids
// (.vtu).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/at.h"
#include "tools/texture/cell_field.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/crossed_field.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/structured_cells.h"
#include "tools/texture/volume_reader.h"
#include "tools/texture/vtk_file.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using Where = VtkFile::Where;

/// Image data along the axes, slice by slice.
class ImageReader final : public VolumeReader {
  public:
    std::unique_ptr<VtkFile> file;
    std::unique_ptr<ArrayNumbers> numbers;

    Result<void> read_slice(int32_t, float* out, const Wrote& wrote) override {
        for (int32_t y = 0; y < size.y; ++y) {
            if (Result<void> got = read_floats(numbers.get(), out, row_floats()); !got) return got;
            out += row_floats();
            wrote(4 * row_floats());
        }
        return {};
    }
};

/// Reads points, in mm.
Result<void> read_places(const VtkFile& file, int64_t points, double unit, CellMesh* mesh) {
    const Result<const VtkFile::Array*> places = file.part(Where::kPlaces, {});
    if (!places) return places.error();
    if ((*places)->components != 3) return user_error(messages::kPointsNotThree);
    Result<std::unique_ptr<ArrayNumbers>> numbers = file.numbers(**places, 3 * points);
    if (!numbers) return numbers.error();
    mesh->points.resize(static_cast<size_t>(3 * points));
    if (Result<void> got = (*numbers)->next(mesh->points.data(), mesh->points.size()); !got)
        return got;
    for (double& coordinate : mesh->points)
        coordinate *= unit;
    return {};
}

/// Reads the places of a rectilinear grid, in mm.
Result<void> read_axes(const VtkFile& file, const std::array<int64_t, 3>& along, double unit,
                       CrossedField* out) {
    const Result<std::array<const VtkFile::Array*, 3>> arrays = file.axes();
    if (!arrays) return arrays.error();
    for (size_t a = 0; a < 3; ++a) {
        std::vector<double>& axis = out->axes[a];
        const Result<std::unique_ptr<ArrayNumbers>> numbers = file.numbers(*(*arrays)[a], along[a]);
        if (!numbers) return numbers.error();
        axis.resize(static_cast<size_t>(along[a]));
        if (Result<void> got = (*numbers)->next(axis.data(), axis.size()); !got) return got;
        for (double& place : axis)
            place *= unit;
    }
    return {};
}

/// Reads the values of a field.
Result<std::vector<float>> read_values(const VtkFile& file, const VtkFile::Array& field,
                                       int64_t count) {
    const Result<std::unique_ptr<ArrayNumbers>> numbers = file.numbers(field, count);
    if (!numbers) return numbers.error();
    std::vector<float> out(static_cast<size_t>(count));
    if (Result<void> got = read_floats(numbers->get(), out.data(), count); !got) return got.error();
    return out;
}

/// Lines and faces, which exporters write beside the cells that they bound.
bool is_flat(int type) {
    return (type >= 0 && type <= 9) || (type >= 21 && type <= 23) || type == 28 || type == 30 ||
           type == 34;
}

/// Reads the cells with a volume, and which of all cells they are.
Result<std::vector<int32_t>> read_cells(const VtkFile& file, CellMesh* mesh) {
    std::array<std::unique_ptr<ArrayNumbers>, 2> parts;  // types and ends, read side by side
    const VtkFile::Array* corners = nullptr;
    for (size_t i = 0; i < 3; ++i) {
        constexpr std::array kNames{"types", "offsets", "connectivity"};
        const Result<const VtkFile::Array*> part = file.part(Where::kTopology, kNames[i]);
        if (!part) return part.error();
        if (i == 2) {
            corners = *part;
            continue;
        }
        Result<std::unique_ptr<ArrayNumbers>> numbers = file.numbers(**part, file.cells);
        if (!numbers) return numbers.error();
        parts[i] = std::move(*numbers);
    }
    std::vector<int32_t> kept;
    std::vector<int64_t> ends(static_cast<size_t>(file.cells));
    std::vector<uint8_t> types(static_cast<size_t>(file.cells));
    int64_t total = 0;
    for (int64_t i = 0; i < file.cells; ++i) {
        double type = 0, end = 0;
        if (Result<void> got = parts[0]->next(&type, 1); !got) return got.error();
        if (Result<void> got = parts[1]->next(&end, 1); !got) return got.error();
        if (!(end >= static_cast<double>(total) && end <= 1e15 && type >= 0 && type < 256))
            return user_error(fmt::format(messages::kCellDamaged, i));
        const auto count = static_cast<int64_t>(end) - total;
        const int wanted = corner_count(static_cast<int>(type));
        if (wanted == 0 && !is_flat(static_cast<int>(type))) {
            return user_error(fmt::format(messages::kVtkCellTypeNotSampled, i, type));
        }
        if (wanted != 0 && count != wanted)
            return user_error(fmt::format(messages::kCellCorners, i, count, wanted));
        total = static_cast<int64_t>(end);
        at(ends, i) = total;
        at(types, i) = static_cast<uint8_t>(type);
    }
    Result<std::unique_ptr<ArrayNumbers>> numbers = file.numbers(*corners, total);
    if (!numbers) return numbers.error();
    int64_t corner = 0;
    for (int64_t i = 0; i < file.cells; ++i) {
        const int type = at(types, i);
        const bool solid = corner_count(type) != 0;
        for (; corner < at(ends, i); ++corner) {
            double point = 0;
            if (Result<void> got = (*numbers)->next(&point, 1); !got) return got.error();
            if (!(point >= 0 && point < static_cast<double>(file.points)))
                return user_error(fmt::format(messages::kCornerIsNoPoint, i));
            if (solid) mesh->corners.push_back(static_cast<int32_t>(point));
        }
        if (!solid) continue;
        mesh->types.push_back(static_cast<CellType>(type));
        kept.push_back(static_cast<int32_t>(i));
    }
    if (const int64_t flat = file.cells - static_cast<int64_t>(kept.size());
        flat > 0 && !kept.empty())
        tell(fmt::format(messages::kCellsWithoutVolume, flat));
    return kept;
}

/// Opens image data: the field that the options name, as it is; in place by its origin, spacing and
/// direction, which may be turned (placed_grid.h).
MadeReader open_image(std::unique_ptr<VtkFile> file, const VtkFile::Array& field, int32_t channels,
                      const texture::VolumeOptions& options, const texture::ReadLimits& limits) {
    GridFrame frame;
    const Result<Vec3i> size =
        image_size(*file, field.where == Where::kPoints, unit_mm(options), &frame);
    if (!size) return size.error();
    const int64_t count = int64_t{size->x} * size->y * size->z * channels;
    Result<std::unique_ptr<ArrayNumbers>> numbers = file->numbers(field, count);
    if (!numbers) return numbers.error();
    auto reader = std::make_unique<ImageReader>();
    reader->size = *size;
    reader->channels = channels;
    reader->numbers = std::move(*numbers);
    reader->file = std::move(file);
    return place_reader(std::move(reader), frame, options, limits);
}

/// Opens a rectilinear grid or a curvilinear one, whose cells are hexahedra.
MadeReader open_structured(const VtkFile& file, const VtkFile::Array& field, int32_t channels,
                           const texture::VolumeOptions& options,
                           const texture::ReadLimits& limits) {
    std::array<int64_t, 3> along{};
    for (size_t a = 0; a < 3; ++a) {
        const double low = file.extent[2 * a], high = file.extent[2 * a + 1];
        if (!(high >= low && high - low < INT32_MAX && low == std::floor(low) &&
              high == std::floor(high)))
            return user_error(fmt::format(messages::kExtentNotPossible, low, high));
        along[a] = static_cast<int64_t>(high - low) + 1;
    }
    const bool of_points = field.where == Where::kPoints;
    const double unit = unit_mm(options);
    if (file.kind() == "RectilinearGrid") {
        CrossedField crossed;
        crossed.channels = channels;
        crossed.of_points = of_points;
        const Result<int64_t> items = crossed_items(along, channels, of_points, limits);
        if (!items) return items.error();
        if (Result<void> got = read_axes(file, along, unit, &crossed); !got) return got.error();
        Result<std::vector<float>> values = read_values(file, field, *items * channels);
        if (!values) return values.error();
        crossed.values = std::move(*values);
        return open_crossed_field(std::move(crossed), options);
    }
    Result<CellMesh> mesh = structured_cells(along, channels, of_points, limits);
    if (!mesh) return mesh.error();
    const int64_t points = along[0] * along[1] * along[2];
    if (Result<void> got = read_places(file, points, unit, &*mesh); !got) return got.error();
    const int64_t items = of_points ? points : static_cast<int64_t>(mesh->types.size());
    Result<std::vector<float>> values = read_values(file, field, items * channels);
    if (!values) return values.error();
    mesh->values = std::move(*values);
    return open_cell_field(std::move(*mesh), options, limits);
}

/// Opens an unstructured grid (cell_field.h); lines and faces beside its cells are left out.
MadeReader open_mesh(const VtkFile& file, const VtkFile::Array& field, int32_t channels,
                     const texture::VolumeOptions& options, const texture::ReadLimits& limits) {
    CellMesh mesh;
    mesh.channels = channels;
    mesh.of_points = field.where == Where::kPoints;
    const int64_t items = mesh.of_points ? file.points : file.cells;
    // Points, values, types, ends and eight corners, as far as they are known by now.
    constexpr int64_t kBytesOfPoint = 24, kBytesOfCell = 46;
    const int64_t needed =
        file.points * kBytesOfPoint + file.cells * kBytesOfCell + items * channels * 4;
    if (Result<void> fits = check_memory(needed, limits.memory_bytes); !fits) return fits.error();
    if (Result<void> got = read_places(file, file.points, unit_mm(options), &mesh); !got)
        return got.error();
    const Result<std::vector<int32_t>> kept = read_cells(file, &mesh);
    if (!kept) return kept.error();
    Result<std::vector<float>> values = read_values(file, field, items * channels);
    if (!values) return values.error();
    mesh.values = std::move(*values);
    if (!mesh.of_points) mesh.keep_values(*kept);
    return open_cell_field(std::move(mesh), options, limits);
}

}  // namespace

MadeReader open_vtk(const fs::path& path, const texture::VolumeOptions& options,
                    const texture::ReadLimits& limits) {
    Result<std::unique_ptr<VtkFile>> file = VtkFile::open(path, limits);
    if (!file) return file.error();
    const Result<const VtkFile::Array*> field = (*file)->field(options.field);
    if (!field) return field.error();
    const Result<int32_t> channels = field_channels((*field)->name, (*field)->components);
    if (!channels) return channels.error();
    const std::string& kind = (*file)->kind();
    if (kind == "ImageData")
        return open_image(std::move(*file), **field, *channels, options, limits);
    if (kind == "UnstructuredGrid") return open_mesh(**file, **field, *channels, options, limits);
    return open_structured(**file, **field, *channels, options, limits);
}

}  // namespace openfab::tools
