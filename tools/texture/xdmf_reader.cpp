// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/xdmf_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "texture/nrrd_header.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/cell_field.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/crossed_field.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/number_slab.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/structured_cells.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;
using texture::XdmfField;
using texture::XdmfGrid;
using texture::XdmfItem;

constexpr int64_t kMostSide = 16384;

ArrayType type_of(const XdmfItem& item) {
    if (item.kind == XdmfItem::Kind::kFloat)
        return item.bytes == 8 ? ArrayType::kFloat64 : ArrayType::kFloat32;
    const bool is_signed = item.kind == XdmfItem::Kind::kSigned;
    switch (item.bytes) {
        case 1:
            return is_signed ? ArrayType::kInt8 : ArrayType::kUInt8;
        case 2:
            return is_signed ? ArrayType::kInt16 : ArrayType::kUInt16;
        case 4:
            return is_signed ? ArrayType::kInt32 : ArrayType::kUInt32;
        default:
            return is_signed ? ArrayType::kInt64 : ArrayType::kUInt64;
    }
}

/// The numbers of an item, which must outlive this.
class ItemNumbers {
  public:
    /// Fails where the item cannot be read or has not bytes for its numbers; `what` it is, for errors. `sizes`: in
    /// whose order a data set must be.
    static Result<ItemNumbers> open(const XdmfItem& item, const std::vector<int64_t>& sizes,
                                    const std::string& what, const fs::path& path,
                                    const texture::ReadLimits& limits,
                                    const OpenDataSet& open_set) {
        const auto failed = [&](const Error& error) {
            return with_context(error, fmt::format(messages::kCannotBeRead, what));
        };
        if (!item.wrong.empty()) return failed(user_error(item.wrong.what, item.wrong.help));
        const bool is_set = item.place == XdmfItem::Place::kHdf;
        if (is_set && !open_set) {
            return failed(user_error(fmt::format(messages::kLiesInHdf5, item.text, item.set),
                                     messages::kLiesInHdf5Help));
        }
        ItemNumbers out;
        int64_t whole = 1;  // numbers of the array of which it may be a slab
        if (item.slab) {
            for (const int64_t size : item.slab->sizes)
                whole *= size;
        } else {
            whole = item.count;
        }
        Result<std::unique_ptr<ArrayNumbers>> numbers = user_error({});
        if (item.place == XdmfItem::Place::kHere) {
            numbers = open_array_text(item.text, whole);
        } else {
            Result<InputFile> file = texture::open_data_file(path, item.text, limits);
            if (!file) return failed(file.error());
            out.file_ = std::make_unique<InputFile>(std::move(*file));
            if (is_set) {
                numbers = open_set(*out.file_, item.set, sizes, item.slab);
            } else {
                ArrayBytes bytes;
                bytes.file = out.file_.get();
                bytes.begin = item.seek;
                bytes.swapped = item.big_endian;
                bytes.header_bytes = 0;
                numbers = open_array_bytes(bytes, type_of(item), whole);
            }
        }
        if (!numbers) return failed(numbers.error());
        out.numbers_ =
            item.slab && !is_set ? take_slab(std::move(*numbers), *item.slab) : std::move(*numbers);
        return out;
    }
    ArrayNumbers* operator->() const { return numbers_.get(); }
    ArrayNumbers* get() const { return numbers_.get(); }

  private:
    std::unique_ptr<InputFile> file_;
    std::unique_ptr<ArrayNumbers> numbers_;
};

/// Reads the file's structure and what it is made of.
class Source {
  public:
    Source(const fs::path& path, const texture::VolumeOptions& options,
           const texture::ReadLimits& limits, const OpenDataSet& open_set)
        : path_(path), options_(options), limits_(limits), open_set_(open_set) {}

    MadeReader open() {
        Result<InputFile> file = InputFile::open(path_);
        if (!file) return file.error();
        Result<XdmfGrid> grid =
            texture::read_xdmf_grid(*file, options_.time, options_.field, limits_);
        if (!grid) return grid.error();
        grid_ = std::move(*grid);
        std::vector<std::string> names;
        names.reserve(grid_.fields.size());
        for (const XdmfField& field : grid_.fields)
            names.push_back(field.name);
        const Result<size_t> picked = pick_field(names, options_.field);
        if (!picked) return picked.error();
        field_ = &grid_.fields[*picked];
        if (!grid_.wrong_topology.empty())
            return user_error(grid_.wrong_topology.what, grid_.wrong_topology.help);
        if (grid_.topology.starts_with("2d"))
            return user_error(fmt::format(messages::kXdmfTypesNotSampled, grid_.topology));
        if (!options_.time && grid_.steps > 1)
            tell(fmt::format(messages::kFirstOfSteps, path_.filename().string(), grid_.steps));
        if (grid_.topology == "3dcorectmesh") return open_regular();
        const bool is_rectilinear = grid_.topology == "3drectmesh";
        if (is_rectilinear || grid_.topology == "3dsmesh") return open_structured(is_rectilinear);
        return open_cells();
    }

  private:
    Result<ItemNumbers> numbers(const XdmfItem& item, const std::string& what,
                                const std::vector<int64_t>& sizes = {}) const {
        return ItemNumbers::open(item, sizes.empty() ? item.sizes : sizes, what, path_, limits_,
                                 open_set_);
    }

    /// Opens the field, which has a value for each of `items`, and says how many channels it has.
    Result<ItemNumbers> open_field(int64_t items, int32_t* channels) const {
        const int64_t count = field_->item.count;
        const std::string what = fmt::format(messages::kItsField, field_->name);
        // A data set may have more sides than the field says.
        const std::vector<int64_t> whole = sides_of(items, std::max<int64_t>(1, count / items));
        const bool is_finer =
            are_in_one_order(field_->item.sizes, whole) && field_->item.sizes.size() < whole.size();
        Result<ItemNumbers> opened =
            numbers(field_->item, what, is_finer ? whole : field_->item.sizes);
        if (!opened) return opened;
        if (count % items != 0) {
            return user_error(fmt::format(messages::kNumbersFor, what, count, items,
                                          field_->of_points ? "points" : "cells"));
        }
        const Result<int32_t> found = field_channels(field_->name, count / items);
        if (!found) return found.error();
        if (Result<void> fits = check_sides(items, *found); !fits) return fits.error();
        *channels = *found;
        return opened;
    }

    /// The sides of an array of the grid's items, and of the components of each.
    std::vector<int64_t> sides_of(int64_t items, int64_t components) const {
        std::vector<int64_t> out{items};
        if (grid_.topology.starts_with("3d") && grid_.points_along.size() == 3) {
            out = grid_.points_along;
            for (int64_t& side : out)
                side = field_->of_points ? side : std::max<int64_t>(1, side - 1);
        }
        out.push_back(components);
        return out;
    }

    /// Refuses a field whose numbers are not in the order of the `items` of the grid, those of an item behind each
    /// other.
    Result<void> check_sides(int64_t items, int32_t channels) const {
        const std::vector<int64_t>& sides = field_->item.sizes;
        if (field_->item.slab) return {};
        std::vector<int64_t> wanted = sides_of(items, channels);
        if (are_in_one_order(sides, wanted)) return {};
        if (channels == 1) wanted.pop_back();
        return user_error(fmt::format(messages::kFieldSides, field_->name, fmt::join(sides, " "),
                                      fmt::join(wanted, " ")),
                          messages::kFieldSidesHelp);
    }

    /// Reads three numbers, which XDMF has in the order z, y, x.
    Result<Vec3d> read_vector(const XdmfItem& item, const std::string& what) const {
        if (item.wrong.empty() && item.count != 3)
            return user_error(what + messages::kNotThreeNumbers);
        const Result<ItemNumbers> opened = numbers(item, what);
        if (!opened) return opened.error();
        std::array<double, 3> zyx{};
        if (Result<void> got = (*opened)->next(zyx.data(), 3); !got) return got.error();
        return Vec3d{zyx[2], zyx[1], zyx[0]} * unit_mm(options_);
    }

    MadeReader open_regular() const {
        if (grid_.geometry != "origin_dxdydz" || grid_.point_items.size() != 2)
            return user_error(fmt::format(messages::kRegularGeometry, grid_.geometry));
        const Result<Vec3d> origin = read_vector(grid_.point_items[0], messages::kOriginOfGrid);
        if (!origin) return origin.error();
        const Result<Vec3d> step = read_vector(grid_.point_items[1], messages::kSpacingOfGrid);
        if (!step) return step.error();
        const Result<std::array<int64_t, 3>> along = sides();
        if (!along) return along.error();
        Vec3i size;
        for (int a = 0; a < 3; ++a) {
            const int64_t side = (*along)[static_cast<size_t>(a)] - (field_->of_points ? 0 : 1);
            if (side < 1 || side > kMostSide)
                return user_error(fmt::format(messages::kSideNotPossible, side));
            size[a] = static_cast<int32_t>(side);
        }
        GridFrame frame;
        frame.first = field_->of_points ? *origin : *origin + *step * 0.5;
        frame.steps = {Vec3d{step->x, 0, 0}, Vec3d{0, step->y, 0}, Vec3d{0, 0, step->z}};
        int32_t channels = 0;
        const Result<ItemNumbers> opened = open_field(int64_t{size.x} * size.y * size.z, &channels);
        if (!opened) return opened.error();
        const int64_t count = field_->item.count;
        if (Result<void> fits = check_memory(4 * count, limits_.memory_bytes / 2); !fits)
            return fits.error();
        std::vector<float> values(static_cast<size_t>(count));
        if (Result<void> got = read_floats(opened->get(), values.data(), count); !got)
            return got.error();
        return open_placed_grid(size, channels, std::move(values), frame, options_);
    }

    /// Of the three sides that a topology gives in the order z, y, x.
    Result<std::array<int64_t, 3>> sides() const {
        if (grid_.points_along.size() != 3) return user_error(messages::kStructuredDimensions);
        return std::array<int64_t, 3>{grid_.points_along[2], grid_.points_along[1],
                                      grid_.points_along[0]};
    }

    MadeReader open_structured(bool is_rectilinear) const {
        const Result<std::array<int64_t, 3>> along = sides();
        if (!along) return along.error();
        int64_t items = 1;
        for (const int64_t n : *along)
            items *= field_->of_points ? n : std::max<int64_t>(1, n - 1);
        int32_t channels = 0;
        const Result<ItemNumbers> values = open_field(items, &channels);
        if (!values) return values.error();
        const int64_t count = field_->item.count;
        if (is_rectilinear) return open_crossed(*along, channels, values->get());
        Result<CellMesh> mesh = structured_cells(*along, channels, field_->of_points, limits_);
        if (!mesh) return mesh.error();
        const Result<int64_t> points = point_count();
        if (!points) return points.error();
        const int64_t wanted = (*along)[0] * (*along)[1] * (*along)[2];
        if (*points != wanted) {
            return user_error(fmt::format(messages::kGridPoints, *points, wanted));
        }
        if (Result<void> got = read_points(*points, &*mesh); !got) return got.error();
        mesh->values.resize(static_cast<size_t>(count));
        if (Result<void> got = read_floats(values->get(), mesh->values.data(), count); !got)
            return got.error();
        return open_cell_field(std::move(*mesh), options_, limits_);
    }

    MadeReader open_crossed(const std::array<int64_t, 3>& along, int32_t channels,
                            ArrayNumbers* values) const {
        if (grid_.geometry != "vxvyvz" || grid_.point_items.size() != 3) {
            return user_error(fmt::format(messages::kRectilinearGeometry, grid_.geometry));
        }
        CrossedField crossed;
        crossed.channels = channels;
        crossed.of_points = field_->of_points;
        const Result<int64_t> items = crossed_items(along, channels, field_->of_points, limits_);
        if (!items) return items.error();
        for (size_t a = 0; a < 3; ++a) {
            const XdmfItem& item = grid_.point_items[a];
            if (item.wrong.empty() && item.count != along[a]) {
                return user_error(
                    fmt::format(messages::kAxisPlaces, "xyz"[a], item.count, along[a]));
            }
            const Result<ItemNumbers> opened = numbers(item, messages::kAxisOfGrid);
            if (!opened) return opened.error();
            std::vector<double>& axis = crossed.axes[a];
            axis.resize(static_cast<size_t>(item.count));
            if (Result<void> got = (*opened)->next(axis.data(), axis.size()); !got)
                return got.error();
            for (double& place : axis)
                place *= unit_mm(options_);
        }
        crossed.values.resize(static_cast<size_t>(field_->item.count));
        if (Result<void> got = read_floats(values, crossed.values.data(), field_->item.count); !got)
            return got.error();
        return open_crossed_field(std::move(crossed), options_);
    }

    MadeReader open_cells() const {
        if (grid_.cell_items.size() != 1) return user_error(messages::kOneCellArray);
        CellMesh mesh;
        const Result<int64_t> points = point_count();
        if (!points) return points.error();
        mesh.of_points = field_->of_points;
        const int64_t items = mesh.of_points ? *points : grid_.cells;
        const Result<ItemNumbers> values = open_field(items, &mesh.channels);
        if (!values) return values.error();
        const int64_t count = field_->item.count;
        constexpr int64_t kBytesOfPoint = 24, kBytesOfCell = 37;
        if (grid_.cells > INT32_MAX || *points > INT32_MAX)
            return user_error(fmt::format(messages::kMoreThanPointsOrCells, INT32_MAX));
        if (Result<void> fits =
                check_memory(*points * kBytesOfPoint + grid_.cells * kBytesOfCell + 4 * count,
                             limits_.memory_bytes);
            !fits)
            return fits.error();
        if (Result<void> got = read_points(*points, &mesh); !got) return got.error();
        const Result<std::vector<int32_t>> kept = read_cells(*points, &mesh);
        if (!kept) return kept.error();
        mesh.values.resize(static_cast<size_t>(count));
        if (Result<void> got = read_floats(values->get(), mesh.values.data(), count); !got)
            return got.error();
        if (!mesh.of_points) mesh.keep_values(*kept);
        return open_cell_field(std::move(mesh), options_, limits_);
    }

    Result<int64_t> point_count() const {
        const std::vector<XdmfItem>& items = grid_.point_items;
        const bool apart = grid_.geometry == "x_y_z";
        if (!apart && grid_.geometry != "xyz" && !grid_.geometry.empty())
            return user_error(fmt::format(messages::kPointsGivenAs, grid_.geometry));
        if (items.size() != (apart ? 3 : 1)) return user_error(messages::kPointArrays);
        for (const XdmfItem& item : items) {
            // Opening it says what is wrong, and that the file has bytes for its numbers.
            if (const Result<ItemNumbers> opened = numbers(item, messages::kItsPoints); !opened)
                return opened.error();
            if (item.count != items[0].count || (!apart && item.count % 3 != 0))
                return user_error(messages::kPointsNotThree);
        }
        return apart ? items[0].count : items[0].count / 3;
    }

    Result<void> read_points(int64_t points, CellMesh* mesh) const {
        mesh->points.resize(static_cast<size_t>(3 * points));
        const std::vector<XdmfItem>& items = grid_.point_items;
        for (size_t i = 0; i < items.size(); ++i) {
            const Result<ItemNumbers> opened = numbers(items[i], messages::kItsPoints);
            if (!opened) return opened.error();
            if (items.size() == 1) {
                if (Result<void> got = (*opened)->next(mesh->points.data(), mesh->points.size());
                    !got)
                    return got;
                continue;
            }
            for (size_t at = i; at < mesh->points.size(); at += 3) {
                if (Result<void> got = (*opened)->next(&mesh->points[at], 1); !got) return got;
            }
        }
        for (double& coordinate : mesh->points)
            coordinate *= unit_mm(options_);
        return {};
    }

    /// What a code of a Mixed topology stands for, or the name of one that is not.
    struct Kind {
        int code;
        const char* name;
        int corners;  ///< 0: their number follows the code
        CellType type;
        bool solid;
    };
    static constexpr CellType kNone = CellType::kTetrahedron;
    static constexpr std::array<Kind, 12> kKinds{{
        {1, "polyvertex", 0, kNone, false},
        {2, "polyline", 0, kNone, false},
        {3, "polygon", 0, kNone, false},
        {4, "triangle", 3, kNone, false},
        {5, "quadrilateral", 4, kNone, false},
        {6, "tetrahedron", 4, CellType::kTetrahedron, true},
        {8, "wedge", 6, CellType::kWedge, true},
        {9, "hexahedron", 8, CellType::kHexahedron, true},
        {0x22, "edge_3", 3, kNone, false},
        {0x23, "quadrilateral_9", 9, kNone, false},
        {0x24, "triangle_6", 6, kNone, false},
        {0x25, "quadrilateral_8", 8, kNone, false},
    }};

    /// Reads the cells with a volume, and which of all cells they are.
    Result<std::vector<int32_t>> read_cells(int64_t points, CellMesh* mesh) const {
        const bool mixed = grid_.topology == "mixed";
        const auto* const all = std::find_if(kKinds.begin(), kKinds.end(), [&](const Kind& kind) {
            return grid_.topology == kind.name;
        });
        if (!mixed && (all == kKinds.end() || !all->solid)) {
            return user_error(fmt::format(messages::kXdmfTypesNotSampled, grid_.topology));
        }
        const XdmfItem& item = grid_.cell_items[0];
        const Result<ItemNumbers> opened = numbers(item, messages::kItsTopology);
        if (!opened) return opened.error();
        if (mixed ? item.count < 2 * grid_.cells : item.count != grid_.cells * all->corners)
            return user_error(fmt::format(messages::kTopologyCount, item.count, grid_.cells));
        std::vector<int32_t> kept;
        int64_t left = item.count;
        const auto next = [&](double* out) -> Result<void> {
            if (--left < 0) return user_error(messages::kTopologyTooShort);
            return (*opened)->next(out, 1);
        };
        for (int64_t i = 0; i < grid_.cells; ++i) {
            const Kind* kind = mixed ? nullptr : all;
            double corners = mixed ? 0 : all->corners;
            if (mixed) {
                double code = 0;
                if (Result<void> got = next(&code); !got) return got.error();
                kind = std::find_if(kKinds.begin(), kKinds.end(),
                                    [&](const Kind& k) { return k.code == code; });
                if (kind == kKinds.end()) {
                    return user_error(fmt::format(messages::kXdmfCellTypeNotSampled, i, code));
                }
                corners = kind->corners;
                if (kind->corners == 0) {
                    if (Result<void> got = next(&corners); !got) return got.error();
                }
            }
            for (double k = 0; k < corners; ++k) {
                double number = 0;
                if (Result<void> got = next(&number); !got) return got.error();
                const double point = number - static_cast<double>(grid_.first_point);
                if (!(point >= 0 && point < static_cast<double>(points)))
                    return user_error(fmt::format(messages::kCornerIsNoPoint, i));
                if (kind->solid) mesh->corners.push_back(static_cast<int32_t>(point));
            }
            if (!kind->solid) continue;
            mesh->types.push_back(kind->type);
            kept.push_back(static_cast<int32_t>(i));
        }
        if (left != 0) return user_error(messages::kTopologyTooLong);
        return kept;
    }

    const fs::path& path_;
    const texture::VolumeOptions& options_;
    const texture::ReadLimits& limits_;
    const OpenDataSet& open_set_;
    XdmfGrid grid_;
    const XdmfField* field_ = nullptr;
};

}  // namespace

MadeReader open_xdmf(const fs::path& path, const texture::VolumeOptions& options,
                     const texture::ReadLimits& limits, const OpenDataSet& open_set) {
    return Source(path, options, limits, open_set).open();
}

}  // namespace openfab::tools
