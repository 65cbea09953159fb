// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/hdf5/vtk_hdf.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tools/hdf5/data_set.h"
#include "tools/hdf5/hdf5_handle.h"
#include "tools/hdf5/messages.h"
#include "tools/texture/array_numbers.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/vtk_image.h"

namespace openfab::tools {

namespace {

constexpr char kRoot[] = "/VTKHDF";

/// Slices of one data set, one after the other.
class SetReader final : public VolumeReader {
  public:
    SetReader(InputFile file) : file_(std::move(file)) {}
    InputFile& file() { return file_; }
    std::unique_ptr<ArrayNumbers> numbers;

    Result<void> read_slice(int32_t, float* out, const Wrote& wrote) override {
        for (int32_t y = 0; y < size.y; ++y) {
            if (Result<void> got = read_floats(numbers.get(), out, row_floats()); !got) return got;
            out += row_floats();
            wrote(4 * row_floats());
        }
        return {};
    }

  private:
    InputFile file_;
};

/// Reads an attribute of `count` numbers; leaves `out` as it is where there is none.
template <size_t count>
bool read_numbers(hid_t of, const char* name, std::array<double, count>* out) {
    if (H5Aexists(of, name) <= 0) return true;
    const Hdf5Handle attribute(H5Aopen(of, name, H5P_DEFAULT), H5Aclose);
    if (!attribute.ok()) return false;
    const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
    if (!space.ok() || H5Sget_simple_extent_npoints(space) != static_cast<hssize_t>(count))
        return false;
    return H5Aread(attribute, H5T_NATIVE_DOUBLE, out->data()) >= 0;
}

/// Returns an attribute that is a text; an empty one where there is none.
std::string read_text(hid_t of, const char* name) {
    if (H5Aexists(of, name) <= 0) return {};
    const Hdf5Handle attribute(H5Aopen(of, name, H5P_DEFAULT), H5Aclose);
    const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
    const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
    if (!type.ok() || H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1)
        return {};
    if (H5Tis_variable_str(type) > 0) {
        char* text = nullptr;
        if (H5Aread(attribute, type, static_cast<void*>(&text)) < 0 || text == nullptr) return {};
        std::string out(text);
        H5free_memory(text);
        return out;
    }
    constexpr size_t kMostLetters = 4096;
    const size_t size = H5Tget_size(type);
    if (size == 0 || size > kMostLetters) return {};
    std::string out(size, '\0');
    if (H5Aread(attribute, type, out.data()) < 0) return {};
    return out.substr(0, out.find('\0'));
}

/// The fields of points or of cells.
struct Fields {
    bool of_points = true;
    std::vector<std::string> names;
    std::string usual;  ///< what the file calls its scalars
};

Fields list_fields(hid_t root, bool of_points, const std::string& file_name) {
    Fields out;
    out.of_points = of_points;
    const char* const name = of_points ? "PointData" : "CellData";
    if (H5Lexists(root, name, H5P_DEFAULT) <= 0) return out;
    const Hdf5Handle access = within_file(H5P_GROUP_ACCESS);
    const Hdf5Handle group(H5Gopen2(root, name, access), H5Gclose);
    H5G_info_t info{};
    if (!group.ok() || H5Gget_info(group, &info) < 0) return out;
    out.usual = read_text(group, "Scalars");
    for (hsize_t i = 0; i < info.nlinks; ++i) {
        std::array<char, 256> letters{};
        if (H5Lget_name_by_idx(group, ".", H5_INDEX_NAME, H5_ITER_INC, i, letters.data(),
                               letters.size(), H5P_DEFAULT) <= 0)
            continue;
        std::string field(letters.data());
        if (field == "vtkGhostType" || field == "vtkGhostLevels") {
            tell(fmt::format(messages::kGhostsLeftOut, file_name, field));
        } else {
            out.names.push_back(std::move(field));
        }
    }
    return out;
}

/// A field's sides in the file, z, y, x and components where there are several.
Result<int64_t> components(hid_t file, const std::string& set, const Vec3i& size, bool one_step) {
    const Hdf5Handle access = within_file(H5P_DATASET_ACCESS);
    const Hdf5Handle opened(H5Dopen2(file, set.c_str(), access), H5Dclose);
    if (!opened.ok()) return user_error(fmt::format(messages::kNoDataSetOfName, set));
    const Hdf5Handle space(H5Dget_space(opened), H5Sclose);
    std::array<hsize_t, H5S_MAX_RANK> sides{};
    const int rank = H5Sget_simple_extent_dims(space, sides.data(), nullptr);
    std::vector<hsize_t> left(sides.begin(), sides.begin() + std::max(rank, 0));
    const std::string all = fmt::format("{}", fmt::join(left, " "));
    if (one_step && !left.empty() && left.front() == 1) left.erase(left.begin());
    const std::array<hsize_t, 3> wanted{static_cast<hsize_t>(size.z), static_cast<hsize_t>(size.y),
                                        static_cast<hsize_t>(size.x)};
    if (left.size() < 3 || left.size() > 4 ||
        !std::equal(wanted.begin(), wanted.end(), left.begin()))
        return user_error(fmt::format(messages::kVtkHdfSides, set, all, fmt::join(wanted, " ")));
    return left.size() == 4 ? static_cast<int64_t>(left[3]) : 1;
}

}  // namespace

MadeReader open_vtk_hdf(const std::filesystem::path& path, const texture::VolumeOptions& options,
                        const texture::ReadLimits& limits) {
    Result<InputFile> input = InputFile::open(path);
    if (!input) return input.error();
    const Hdf5Handle file = open_hdf5(*input);
    if (!file.ok()) return user_error(messages::kNotHdf5);
    const Hdf5Handle access = within_file(H5P_GROUP_ACCESS);
    const Hdf5Handle root(H5Gopen2(file, kRoot, access), H5Gclose);
    if (!root.ok()) return user_error(messages::kIsHdf5, messages::kIsHdf5Help);
    if (const std::string type = read_text(root, "Type"); type != "ImageData")
        return user_error(
            fmt::format(messages::kVtkHdfKind, type),
            type == "PolyData" ? messages::kVtkHdfSurfaceHelp : messages::kVtkHdfKindHelp);
    VtkImage image;
    // -1 and 0: an extent must be given.
    image.extent = {0, -1, 0, -1, 0, -1};
    std::array<double, 1> steps{1};
    const bool has_steps = H5Lexists(root, "Steps", H5P_DEFAULT) > 0;
    if (has_steps) {
        const Hdf5Handle group(H5Gopen2(root, "Steps", access), H5Gclose);
        if (!group.ok() || !read_numbers(group, "NSteps", &steps))
            return user_error(messages::kDataSetDamaged);
        if (steps[0] != 1)
            return user_error(fmt::format(messages::kVtkHdfSteps, steps[0]),
                              messages::kVtkHdfStepsHelp);
    }
    for (const bool got : {read_numbers(root, "WholeExtent", &image.extent),
                           read_numbers(root, "Origin", &image.origin),
                           read_numbers(root, "Spacing", &image.spacing),
                           read_numbers(root, "Direction", &image.direction)}) {
        if (!got) return user_error(messages::kVtkHdfPlace);
    }
    std::vector<std::string> names;
    const std::string file_name = path.filename().string();
    const Fields points = list_fields(root, true, file_name),
                 cells = list_fields(root, false, file_name);
    names.insert(names.end(), points.names.begin(), points.names.end());
    names.insert(names.end(), cells.names.begin(), cells.names.end());
    const Result<size_t> picked =
        pick_field(names, options.field, points.usual.empty() ? cells.usual : points.usual);
    if (!picked) return picked.error();
    const bool of_points = *picked < points.names.size();
    const std::string set =
        fmt::format("{}/{}/{}", kRoot, of_points ? "PointData" : "CellData", names[*picked]);
    GridFrame frame;
    const Result<Vec3i> size = image_size(image, of_points, unit_mm(options), &frame);
    if (!size) return size.error();
    const Result<int64_t> parts = components(file, set, *size, has_steps);
    if (!parts) return parts.error();
    const Result<int32_t> channels = field_channels(names[*picked], *parts);
    if (!channels) return channels.error();
    auto reader = std::make_unique<SetReader>(std::move(*input));
    reader->size = *size;
    reader->channels = *channels;
    Result<std::unique_ptr<ArrayNumbers>> numbers =
        open_data_set(reader->file(), set, {size->z, size->y, size->x, *channels}, {});
    if (!numbers) return numbers.error();
    reader->numbers = std::move(*numbers);
    return place_reader(std::move(reader), frame, options, limits);
}

}  // namespace openfab::tools
