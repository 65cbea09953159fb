// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/volume_files.h"

#include <fmt/format.h>

#include <cstring>

#include "backends/common/output_file.h"
#include "backends/common/part_file.h"
#include "backends/raster/npy.h"
#include "base/json_text.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;
using backends::PartFile;

template <typename T>
std::span<const uint8_t> bytes_of(const std::vector<T>& values) {
    return {reinterpret_cast<const uint8_t*>(values.data()), values.size() * sizeof(T)};
}

Result<void> write_text(PartFile* file, const std::string& text) {
    return file->write({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

/// The bytes' number before an array of VTK's appended data.
Result<void> write_size(PartFile* file, uint64_t bytes) {
    uint8_t size[8];
    std::memcpy(size, &bytes, sizeof size);
    return file->write(size);
}

}  // namespace

Result<void> write_vti(const fs::path& path, const Grid& g, const Vec3& origin,
                       const VolumeArrays& arrays) {
    Result<std::unique_ptr<PartFile>> opened = PartFile::create(path);
    if (!opened) return opened.error();
    PartFile* file = opened->get();
    const auto nodes = static_cast<uint64_t>(g.node_count());
    const auto elements = static_cast<uint64_t>(g.element_count());
    const auto components = static_cast<size_t>(arrays.components);
    const uint64_t node_bytes = nodes * components * sizeof(float);
    uint64_t offset = 0;
    const auto array = [&](const char* type, const char* name, size_t number, uint64_t bytes) {
        std::string out = fmt::format(
            "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" "
            "format=\"appended\" offset=\"{}\"/>\n",
            type, name, number, offset);
        offset += 8 + bytes;
        return out;
    };
    std::string head = fmt::format(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "  <ImageData WholeExtent=\"0 {0} 0 {1} 0 {2}\" Origin=\"{3:.9g} {4:.9g} {5:.9g}\" "
        "Spacing=\"{6:.9g} {7:.9g} {8:.9g}\">\n    <Piece Extent=\"0 {0} 0 {1} 0 {2}\">\n"
        "      <PointData {9}=\"{10}\">\n",
        g.elements[0], g.elements[1], g.elements[2], origin[0], origin[1], origin[2], g.pitch_mm[0],
        g.pitch_mm[1], g.pitch_mm[2], components == 3 ? "Vectors" : "Scalars", arrays.at_nodes);
    head += array("Float32", arrays.at_nodes, components, node_bytes);
    head += fmt::format("      </PointData>\n      <CellData Scalars=\"{}\">\n",
                        arrays.floats.front().first);
    for (const auto& [name, values] : arrays.floats)
        head += array("Float32", name, 1, elements * 4);
    head += array("UInt8", "material", 1, elements);
    head += "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n_";
    if (Result<void> done = write_text(file, head); !done) return done;
    if (Result<void> done = write_size(file, node_bytes); !done) return done;
    std::vector<float> row(components * static_cast<size_t>(g.nodes[0]));
    for (int32_t z = 0; z < g.nodes[2]; ++z)
        for (int32_t y = 0; y < g.nodes[1]; ++y) {
            for (size_t c = 0; c < components; ++c) {
                const double* from = arrays.row(static_cast<int>(c), y, z);
                for (size_t x = 0; x < static_cast<size_t>(g.nodes[0]); ++x)
                    row[components * x + c] = static_cast<float>(from[x]);
            }
            if (Result<void> done = file->write(bytes_of(row)); !done) return done;
        }
    for (const auto& [name, values] : arrays.floats) {
        if (Result<void> done = write_size(file, elements * 4); !done) return done;
        if (Result<void> done = file->write(bytes_of(*values)); !done) return done;
    }
    if (Result<void> done = write_size(file, elements); !done) return done;
    if (Result<void> done = file->write(bytes_of(*arrays.material)); !done) return done;
    if (Result<void> done = write_text(file, "\n  </AppendedData>\n</VTKFile>\n"); !done)
        return done;
    return file->keep();
}

Result<void> write_npy(const fs::path& path, const Grid& g, const Vec3& origin,
                       const std::vector<std::string>& materials,
                       std::span<const char* const> names,
                       const std::function<void(int32_t y, int32_t z, float* row)>& fill) {
    Result<std::unique_ptr<PartFile>> opened = PartFile::create(path);
    if (!opened) return opened.error();
    const int64_t shape[] = {g.elements[2], g.elements[1], g.elements[0],
                             static_cast<int64_t>(names.size())};
    if (Result<void> done = (*opened)->write(raster::npy_header("<f4", shape)); !done) return done;
    std::vector<float> row(names.size() * static_cast<size_t>(g.elements[0]));
    for (int32_t z = 0; z < g.elements[2]; ++z)
        for (int32_t y = 0; y < g.elements[1]; ++y) {
            fill(y, z, row.data());
            if (Result<void> done = (*opened)->write(bytes_of(row)); !done) return done;
        }
    if (Result<void> done = (*opened)->keep(); !done) return done;
    JsonText json;
    json.begin_object().key("fields").begin_array();
    for (const char* name : names)
        json.value(name);
    json.end_array();
    for (const auto& [key, values] :
         {std::pair("pitch_mm", &g.pitch_mm), std::pair("origin_mm", &origin)}) {
        json.key(key).begin_array();
        for (const double one : *values)
            json.value(one);
        json.end_array();
    }
    json.key("materials").begin_array();
    for (const std::string& name : materials)
        json.value(name);
    json.end_array().end_object();
    return backends::write_whole_file(path.string() + ".json", json.take() + "\n");
}

Result<void> write_vti(const fs::path& path, const PartProblem& problem, const PartFields& fields,
                       const Field<double, kElastic>& moved, const std::vector<float>& weakness) {
    VolumeArrays arrays{"displacement_mm",
                        kElastic,
                        [&](int c, int32_t y, int32_t z) { return moved.row(c, y, z); },
                        {{"von_mises_MPa", &fields.von_mises_MPa},
                         {"tension_MPa", &fields.tension_MPa},
                         {"compression_MPa", &fields.compression_MPa},
                         {"safety", &fields.safety},
                         {"solid", &problem.voxels.solid}},
                        &problem.voxels.code};
    if (!weakness.empty()) arrays.floats.emplace_back("weakness", &weakness);
    return write_vti(path, problem.grid, problem.voxels.origin_mm, arrays);
}

Result<void> write_npy(const fs::path& path, const PartProblem& problem, const PartFields& fields,
                       const Field<double, kElastic>& moved) {
    const Grid& g = problem.grid;
    const Voxels& v = problem.voxels;
    constexpr const char* kNames[] = {"displacement_x_mm",
                                      "displacement_y_mm",
                                      "displacement_z_mm",
                                      "von_mises_MPa",
                                      "tension_MPa",
                                      "compression_MPa",
                                      "safety",
                                      "solid"};
    constexpr size_t kWidth = std::size(kNames);
    const auto fill = [&](int32_t y, int32_t z, float* row) {
        for (int32_t x = 0; x < g.elements[0]; ++x) {
            const size_t e = g.element(x, y, z);
            float* out = row + kWidth * static_cast<size_t>(x);
            for (int c = 0; c < 3; ++c) {
                double sum = 0;
                for (int k = 0; k < 4; ++k) {
                    const double* p = moved.row(c, y + (k & 1), z + (k >> 1)) + x;
                    sum += p[0] + p[1];
                }
                out[c] = static_cast<float>(sum / 8);
            }
            out[3] = fields.von_mises_MPa[e];
            out[4] = fields.tension_MPa[e];
            out[5] = fields.compression_MPa[e];
            out[6] = fields.safety[e];
            out[7] = v.solid[e];
        }
    };
    return write_npy(path, g, v.origin_mm, v.materials, kNames, fill);
}

}  // namespace openfab::mechanics
