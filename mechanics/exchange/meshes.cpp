// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "backends/common/xml_text.h"
#include "mechanics/exchange/element_mesh.h"
#include "mechanics/exchange/hdf5.h"
#include "mechanics/exchange/text_file.h"

namespace openfab::mechanics {

namespace {

std::vector<double> points_of(const ElementMesh& mesh) {
    std::vector<double> out;
    for (size_t n = 0; n < mesh.nodes.size(); ++n)
        for (const double v : mesh.place_mm(n))
            out.push_back(v);
    return out;
}

std::vector<int64_t> corners_of(const ElementMesh& mesh) {
    std::vector<int64_t> out;
    for (size_t e = 0; e < mesh.elements.size(); ++e)
        for (const int64_t n : mesh.corners(e))
            out.push_back(n);
    return out;
}

}  // namespace

Result<void> write_vtu(const std::filesystem::path& path, const ElementMesh& mesh) {
    Result<std::unique_ptr<TextFile>> opened = TextFile::create(path);
    if (!opened) return opened.error();
    TextFile* out = opened->get();
    const auto fields = element_fields(mesh);
    const uint64_t nodes = mesh.nodes.size(), elements = mesh.elements.size();
    uint64_t offset = 0;
    const auto array = [&](const char* type, const std::string& name, int components,
                           uint64_t bytes) {
        // Arrays of numbers say none, as VTK writes them: readers take one component for a table.
        const std::string width =
            components > 1 ? fmt::format(" NumberOfComponents=\"{}\"", components) : "";
        out->put(
            fmt::format("        <DataArray type=\"{}\" Name=\"{}\"{} format=\"appended\" "
                        "offset=\"{}\"/>\n",
                        type, backends::escape_xml(name), width, offset));
        offset += 8 + bytes;
    };
    out->put(
        fmt::format("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <UnstructuredGrid>\n"
                    "    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n      <Points>\n",
                    nodes, elements));
    array("Float64", "points", 3, nodes * 24);
    out->put("      </Points>\n      <Cells>\n");
    array("Int64", "connectivity", 1, elements * 64);
    array("Int64", "offsets", 1, elements * 8);
    array("UInt8", "types", 1, elements);
    out->put("      </Cells>\n      <CellData Scalars=\"material\">\n");
    array("UInt8", "material", 1, elements);
    for (const auto& [name, values] : fields)
        array("Float32", name, 1, elements * 4);
    out->put(
        "      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n  <AppendedData "
        "encoding=\"raw\">\n_");
    const auto put = [&](const auto& values) {
        out->put_value(uint64_t{values.size() * sizeof(values[0])});
        out->put_values(values);
    };
    put(points_of(mesh));
    put(corners_of(mesh));
    std::vector<int64_t> ends;
    for (uint64_t e = 1; e <= elements; ++e)
        ends.push_back(static_cast<int64_t>(8 * e));
    put(ends);
    constexpr uint8_t kHexahedron = 12;
    put(std::vector<uint8_t>(elements, kHexahedron));
    put(mesh.material);
    for (const auto& [name, values] : fields)
        put(values);
    out->put("\n  </AppendedData>\n</VTKFile>\n");
    return out->keep();
}

Result<void> write_msh(const std::filesystem::path& path, const ElementMesh& mesh) {
    Result<std::unique_ptr<TextFile>> opened = TextFile::create(path);
    if (!opened) return opened.error();
    TextFile* out = opened->get();
    // A volume a material; blocks of elements by it.
    std::vector<std::vector<size_t>> of(mesh.materials.size());
    for (size_t e = 0; e < mesh.elements.size(); ++e)
        of[mesh.material[e] > 0 ? mesh.material[e] - 1U : 0U].push_back(e);
    size_t volumes = 0;
    for (const auto& one : of)
        volumes += one.empty() ? 0 : 1;
    out->put("$MeshFormat\n4.1 1 8\n");
    out->put_value(int32_t{1});
    out->put("\n$EndMeshFormat\n");
    out->put(fmt::format("$PhysicalNames\n{}\n", volumes));
    const std::vector<std::string> names = shown_names(mesh.materials);
    for (size_t k = 0; k < of.size(); ++k)
        if (!of[k].empty()) out->put(fmt::format("3 {} \"{}\"\n", k + 1, names[k]));
    out->put("$EndPhysicalNames\n$Entities\n");
    for (const uint64_t n : {uint64_t{0}, uint64_t{0}, uint64_t{0}, uint64_t{volumes}})
        out->put_value(n);
    for (size_t k = 0; k < of.size(); ++k) {
        if (of[k].empty()) continue;
        out->put_value(static_cast<int32_t>(k + 1));
        for (size_t side = 0; side < 2; ++side)
            for (size_t a = 0; a < 3; ++a)
                out->put_value(mesh.origin_mm[a] +
                               (side == 1 ? mesh.grid.elements[a] * mesh.grid.pitch_mm[a] : 0.0));
        out->put_value(uint64_t{1});
        out->put_value(static_cast<int32_t>(k + 1));
        out->put_value(uint64_t{0});
    }
    const uint64_t nodes = mesh.nodes.size();
    size_t first = 0;
    while (first < of.size() && of[first].empty())
        ++first;
    out->put("\n$EndEntities\n$Nodes\n");
    for (const uint64_t n : {uint64_t{1}, nodes, uint64_t{1}, nodes})
        out->put_value(n);
    for (const int32_t n : {int32_t{3}, static_cast<int32_t>(first + 1), int32_t{0}})
        out->put_value(n);
    out->put_value(nodes);
    for (uint64_t n = 1; n <= nodes; ++n)
        out->put_value(n);
    out->put_values(points_of(mesh));
    const uint64_t elements = mesh.elements.size();
    out->put("\n$EndNodes\n$Elements\n");
    for (const uint64_t n : {uint64_t{volumes}, elements, uint64_t{1}, elements})
        out->put_value(n);
    constexpr int32_t kHexahedron = 5;
    // Elements have the numbers of their order in the file: some readers skip the numbers.
    std::vector<size_t> order;
    order.reserve(elements);
    for (size_t k = 0; k < of.size(); ++k) {
        if (of[k].empty()) continue;
        for (const int32_t n : {int32_t{3}, static_cast<int32_t>(k + 1), kHexahedron})
            out->put_value(n);
        out->put_value(uint64_t{of[k].size()});
        for (const size_t e : of[k]) {
            order.push_back(e);
            out->put_value(uint64_t{order.size()});
            for (const int64_t n : mesh.corners(e))
                out->put_value(static_cast<uint64_t>(n + 1));
        }
    }
    out->put("\n$EndElements\n");
    for (const auto& [name, values] : element_fields(mesh)) {
        out->put(fmt::format("$ElementData\n1\n\"{}\"\n1\n0\n3\n0\n1\n{}\n", name, elements));
        for (size_t i = 0; i < order.size(); ++i) {
            out->put_value(static_cast<int32_t>(i + 1));
            out->put_value(static_cast<double>(values[order[i]]));
        }
        out->put("\n$EndElementData\n");
    }
    return out->keep();
}

Result<void> write_xdmf(const std::filesystem::path& path, const ElementMesh& mesh) {
    Result<std::unique_ptr<TextFile>> opened = TextFile::create(path);
    if (!opened) return opened.error();
    TextFile* out = opened->get();
    const uint64_t nodes = mesh.nodes.size(), elements = mesh.elements.size();
    std::filesystem::path numbers = path;
    numbers.replace_extension(".h5");
    const std::string beside = backends::escape_xml(numbers.filename().string());
    std::vector<Hdf5Array> arrays;
    const auto item = [&](Hdf5Array array, const char* type, int precision) {
        std::string shape;
        for (const uint64_t n : array.shape)
            shape += fmt::format("{}{}", shape.empty() ? "" : " ", n);
        out->put(
            fmt::format("<DataItem Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\" "
                        "Format=\"HDF\">{}:/{}</DataItem>\n",
                        shape, type, precision, beside, array.name));
        arrays.push_back(std::move(array));
    };
    out->put(
        "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"part\" "
        "GridType=\"Uniform\">\n");
    out->put(
        fmt::format("<Topology TopologyType=\"Hexahedron\" NumberOfElements=\"{}\">\n", elements));
    item({"corners",
          {elements, 8},
          Hdf5Type::kInt64,
          [&](TextFile* file) { file->put_values(corners_of(mesh)); }},
         "Int", 8);
    out->put("</Topology>\n<Geometry GeometryType=\"XYZ\">\n");
    item({"points",
          {nodes, 3},
          Hdf5Type::kFloat64,
          [&](TextFile* file) { file->put_values(points_of(mesh)); }},
         "Float", 8);
    out->put("</Geometry>\n");
    const auto attribute = [&](const std::string& name, Hdf5Array array, const char* type,
                               int precision) {
        out->put(fmt::format("<Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"Cell\">\n",
                             backends::escape_xml(name)));
        item(std::move(array), type, precision);
        out->put("</Attribute>\n");
    };
    attribute("material",
              {"material",
               {elements},
               Hdf5Type::kUint8,
               [&](TextFile* file) { file->put_values(mesh.material); }},
              "UChar", 1);
    // A name of a material may have what is no name here, as a `/`: attributes say it, arrays are numbered.
    int number = 0;
    const auto fields = element_fields(mesh);
    for (const auto& [name, values] : fields)
        attribute(name,
                  {fmt::format("field{}", ++number),
                   {elements},
                   Hdf5Type::kFloat32,
                   [&values](TextFile* file) { file->put_values(values); }},
                  "Float", 4);
    out->put("</Grid>\n</Domain>\n</Xdmf>\n");
    if (Result<void> done = write_hdf5(numbers, arrays); !done) return done;
    return out->keep();
}

}  // namespace openfab::mechanics
