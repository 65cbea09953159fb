// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What files of volumes hold beside their numbers: each is carried over, is told, or is why the file
// is refused. All volumes are of two texels, 0.25 and 0.75, unless a row says otherwise.

#include <fmt/format.h>

#include "base/text.h"
#include "tests/support/says/says.h"
#include "tests/unit/texture/field_test.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

struct Feature {
    const char* name;
    const char* file;  ///< its name
    std::string text;
    std::string told;  ///< or why it is refused
    std::vector<float> values{0.25F, 0.75F};
    /// Where it begins and how large it is.
    std::vector<float> domain{};
    std::string field{};
};
/// In place of values.
const std::vector<float> kRefused, kSampled{-1};

std::string nrrd(const std::string& more, const std::string& numbers = "0.25 0.75\n",
                 const std::string& type = "float") {
    return "NRRD0005\ntype: " + type + "\ndimension: 3\nsizes: 2 1 1\n" +
           (more.find("encoding") == std::string::npos ? "encoding: text\n" : "") + more + "\n" +
           numbers;
}
std::string meta(const std::string& more, const std::string& numbers = "0.25 0.75\n") {
    return "ObjectType = Image\nNDims = 3\nDimSize = 2 1 1\nElementType = MET_FLOAT\n"
           "BinaryData = False\n" +
           more + "ElementDataFile = LOCAL\n" + numbers;
}
std::string vti(const std::string& more = "", const std::string& fields = "") {
    return R"(<VTKFile type="ImageData"><ImageData WholeExtent="0 2 0 1 0 1">)" + more +
           R"(<Piece Extent="0 2 0 1 0 1"><CellData>
<DataArray type="Float32" Name="a" format="ascii">0.25 0.75</DataArray>)" +
           fields + "</CellData></Piece></ImageData></VTKFile>";
}
/// Two cubes, beside them a cell of `type` of `corners`.
std::string vtu(int type, const std::string& corners, int end) {
    std::string points;
    for (int i = 0; i < 12; ++i)
        points += fmt::format("{} {} {} ", i % 3, i / 3 % 2, i / 6);
    return fmt::format(
        R"(<VTKFile type="UnstructuredGrid"><UnstructuredGrid><Piece NumberOfPoints="12" NumberOfCells="3">
<CellData><DataArray type="Float32" Name="a" format="ascii">0.25 0.75 9</DataArray></CellData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">{}</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 4 3 6 7 10 9 1 2 5 4 7 8 11 10 {}</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">8 16 {}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">12 12 {}</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>)",
        points, corners, end, type);
}
std::string vtk(const std::string& more = "") {
    return "# vtk DataFile Version 3.0\nof a test\nASCII\nDATASET STRUCTURED_POINTS\n"
           "DIMENSIONS 3 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n" +
           more + "CELL_DATA 2\nSCALARS a float 1\nLOOKUP_TABLE default\n0.25 0.75\n";
}
std::string xdmf(const std::string& grid, const std::string& more = "") {
    return R"(<Xdmf Version="3.0"><Domain><Grid Name="g" GridType="Uniform">
<Topology TopologyType="3DCoRectMesh" Dimensions="2 2 3"/><Geometry GeometryType="ORIGIN_DXDYDZ">
<DataItem Dimensions="3" Format="XML">0 0 0</DataItem><DataItem Dimensions="3" Format="XML">1 1 1</DataItem></Geometry>
<Attribute Name="a" Center="Cell"><DataItem Dimensions="1 1 2" Format="XML">0.25 0.75</DataItem></Attribute>)" +
           grid + "</Grid>" + more + "</Domain></Xdmf>";
}
std::string npy(const std::string& descr, const std::string& bytes) {
    const std::string header =
        "{'descr': '" + descr + "', 'fortran_order': False, 'shape': (1, 1, 2), }\n";
    return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(header.size()) + '\0' + header +
           bytes;
}
std::string cube(const std::string& more) {
    std::string text = more + "LUT_3D_SIZE 2\n";
    for (int i = 0; i < 8; ++i)
        text += fmt::format("{} {} {}\n", i & 1, i >> 1 & 1, i >> 2);
    return text;
}
const std::vector<float> kCube{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                               0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};

std::vector<Feature> features() {
    const std::string other =
        R"(<DataArray type="Float32" Name="b" format="ascii">5 6</DataArray>)";
    const std::string ghost =
        R"(<DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 32</DataArray>)";
    const std::string attribute =
        R"(<Attribute Name="b" Center="Cell"><DataItem Dimensions="1 1 2" Format="XML">5 6</DataItem></Attribute>)";
    return {
        // NRRD
        {"comments and keys", "a.nrrd", nrrd("# one\nby:=hand\ncontent: a scan\n"), ""},
        {"names of a field in another spelling", "a.nrrd", nrrd("space dimension: 3\n"), ""},
        {"spacings", "a.nrrd", nrrd("spacings: 2 3 4\n"), "", {0.25F, 0.75F}, {0, 0, 0, 4, 3, 4}},
        {"an origin",
         "a.nrrd",
         nrrd("space dimension: 3\nspace directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: "
              "(5,6,7)\n"),
         "",
         {0.25F, 0.75F},
         {4, 5, 6, 4, 2, 2}},
        {"units",
         "a.nrrd",
         nrrd("spacings: 2 3 4\nunits: \"cm\" \"cm\" \"cm\"\n"),
         "",
         {0.25F, 0.75F},
         {0, 0, 0, 40, 30, 40}},
        {"axis mins", "a.nrrd", nrrd("spacings: 1 1 1\naxis mins: 5 6 7\n"),
         messages::kAxisMinsLeftOut},
        {"axis maxs", "a.nrrd", nrrd("axis maxs: 5 6 7\n"), messages::kAxisMaxsLeftOut},
        {"what only shows", "a.nrrd",
         nrrd("kinds: domain domain domain\nlabels: \"x\" \"y\" \"z\"\ncenters: cell cell cell\n"
              "thicknesses: 1 1 1\nold min: 0\nold max: 1\nsample units: HU\n"),
         ""},
        {"the frame of measurements", "a.nrrd",
         nrrd("space dimension: 3\nmeasurement frame: (1,0,0) (0,1,0) (0,0,1)\n"), ""},
        {"hexadecimal", "a.nrrd", nrrd("encoding: hex\n"),
         fmt::format(messages::kUnknownEncoding, "hex"), kRefused},
        {"bzip2", "a.nrrd", nrrd("encoding: bzip2\n"),
         fmt::format(messages::kUnknownEncoding, "bzip2"), kRefused},
        {"blocks", "a.nrrd", nrrd("block size: 8\n", "", "block"),
         fmt::format(messages::kUnknownNumberType, "block"), kRefused},
        {"several data files", "a.nhdr", nrrd("data file: LIST\na.raw\n"),
         messages::kTextInSeveralFiles, kRefused},
        // MetaImage
        {"what only shows", "a.mha",
         meta("Comment = a\nModality = MET_MOD_CT\nAnatomicalOrientation = RAI\nID = 1\n"
              "CenterOfRotation = 1 1 1\nElementMin = 0\nElementMax = 1\n"),
         ""},
        {"spacing and offset",
         "a.mha",
         meta("ElementSpacing = 2 2 2\nOffset = 5 6 7\n"),
         "",
         {0.25F, 0.75F},
         {4, 5, 6, 4, 2, 2}},
        {"a unit of length",
         "a.mha",
         meta("DistanceUnits = cm\n"),
         "",
         {0.25F, 0.75F},
         {-5, -5, -5, 20, 10, 10}},
        {"a unit that is not known", "a.mha", meta("DistanceUnits = ell\n"),
         fmt::format(messages::kUnknownUnit, "ell") + "; " + messages::kUnknownUnitHelp, kRefused},
        {"intensities",
         "a.mha",
         meta("ElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1\n"),
         "",
         {-0.5F, 0.5F}},
        {"intensities that are no numbers", "a.mha",
         meta("ElementToIntensityFunctionSlope = two\n"), messages::kIntensityMalformed, kRefused},
        {"channels", "a.mha", meta("ElementNumberOfChannels = 2\n", "1 2 3 4\n"), "", {1, 2, 3, 4}},
        {"several data files", "a.mhd",
         "NDims = 3\nDimSize = 2 1 1\nElementType = MET_FLOAT\nElementDataFile = LIST\n",
         fmt::format(texture::messages::kDataFilesMalformed, "LIST"), kRefused},
        // NPY
        {"halves", "a.npy", npy("<f2", std::string("\x00\x34\x00\x3a", 4)), ""},
        {"floats", "a.npy", npy("<f4", std::string("\0\0\x80\x3e\0\0\x40\x3f", 8)), ""},
        {"big-endian", "a.npy", npy(">f4", std::string("\x3e\x80\0\0\x3f\x40\0\0", 8)), ""},
        {"booleans", "a.npy", npy("|b1", std::string("\0\1", 2)), "", {0, 1}},
        {"signed", "a.npy", npy("|i1", "\xff\x02"), "", {-1, 2}},
        {"complex", "a.npy", npy("<c8", std::string(16, '\0')),
         fmt::format(messages::kUnknownNumberKind, "'<c8'"), kRefused},
        {"an archive", "a.npz", "PK\3\4",
         std::string(messages::kArchiveOfArrays) + "; " + messages::kArchiveOfArraysHelp, kRefused},
        // VTK
        {"image data", "a.vti", vti(), ""},
        {"fields of the file", "a.vti",
         vti(R"(<FieldData><DataArray type="Float64" Name="TimeValue" format="ascii">3</DataArray></FieldData>)"),
         ""},
        {"one of two fields", "a.vti", vti("", other), "", {5, 6}, {}, "b"},
        {"two fields", "a.vti", vti("", other),
         fmt::format(messages::kSeveralFields, "`a`, `b`") + "; " + messages::kSeveralFieldsChoose,
         kRefused},
        {"what is hidden", "a.vti", vti("", ghost),
         fmt::format(messages::kGhostsLeftOut, "{}", "vtkGhostType")},
        {"what is hidden, as a field", "a.vti", vti("", ghost), "", {0, 32}, {}, "vtkGhostType"},
        {"lines beside cells", "a.vtu", vtu(3, "0 1", 18),
         fmt::format(messages::kCellsWithoutVolume, 1), kSampled},
        {"faces beside cells", "a.vtu", vtu(9, "0 1 4 3", 20),
         fmt::format(messages::kCellsWithoutVolume, 1), kSampled},
        {"curved cells", "a.vtu", vtu(24, "0 1 2 3 4 5 6 7 8 9", 26),
         fmt::format(messages::kVtkCellTypeNotSampled, "{}", 24.0), kRefused},
        {"parts of a grid", "a.pvtu", "<VTKFile type=\"PUnstructuredGrid\"/>",
         messages::kPartsOfGrid, kRefused},
        {"levels of a grid", "a.vthb", "<VTKFile type=\"vtkOverlappingAMR\"/>",
         std::string(messages::kPartsOfGrid) + "; " + messages::kPartsOfGridHelp, kRefused},
        {"a surface", "a.vtp", "<VTKFile type=\"PolyData\"/>",
         std::string(messages::kIsASurface) + "; " + messages::kIsASurfaceHelp, kRefused},
        {"an older file", "a.vtk", vtk(), ""},
        {"fields of the older file", "a.vtk", vtk("FIELD FieldData 1\nTIME 1 1 double\n3\n"), ""},
        // XDMF
        {"a regular grid", "a.xdmf", xdmf(""), ""},
        {"information", "a.xdmf", xdmf(R"(<Information Name="by" Value="hand"/><Time Value="3"/>)"),
         ""},
        {"one of two fields", "a.xdmf", xdmf(attribute), "", {5, 6}, {}, "b"},
        {"two fields", "a.xdmf", xdmf(attribute),
         fmt::format(messages::kSeveralFields, "`a`, `b`") + "; " + messages::kSeveralFieldsChoose,
         kRefused},
        // Tables of colours
        {"a title and comments", "a.cube", cube("# one\nTITLE \"warm\"\n"), "", kCube},
        {"bounds", "a.cube", cube("DOMAIN_MIN -1 -1 -1\nDOMAIN_MAX 3 3 3\n"), "", kCube},
        {"another table's bounds", "a.cube", cube("LUT_3D_INPUT_RANGE -1.0 3.0\n"), "", kCube},
        {"small letters",
         "a.cube",
         lower_ascii(cube("title \"a\"\ndomain_min -1 -1 -1\nDomain_Max 3 3 3\n")),
         "",
         kCube,
         {-3, -3, -3, 8, 8, 8}},
        {"a shaper in small letters", "a.cube", lower_ascii("LUT_1D_SIZE 2\n" + cube("")),
         messages::kLutHasShaper, kRefused},
        {"a word that is not known", "a.cube", cube("DOMAIN_MAXX 3 3 3\n"), messages::kLutWord,
         kRefused},
        {"numbers of video", "a.cube", cube("LUT_IN_VIDEO_RANGE\n"), messages::kLutWord, kRefused},
        {"a domain that is turned", "a.cube", cube("LUT_3D_INPUT_RANGE 1 0\n"),
         messages::kLutDomain, kRefused},
        {"bounds of two dialects", "a.cube", cube("DOMAIN_MAX 2 2 2\nLUT_3D_INPUT_RANGE 0 1\n"),
         std::string(messages::kLutTwoDomains) + "; " + messages::kLutTwoDomainsHelp, kRefused},
        {"a fourth number", "a.cube", cube("DOMAIN_MAX 3 3 3 3\n"), messages::kLineNotUnderstood,
         kRefused},
        {"a table in front of it", "a.cube",
         "LUT_1D_SIZE 2\n" + cube("LUT_3D_INPUT_RANGE 0 1\n") + "0 0 0\n1 1 1\n",
         messages::kLutHasShaper, kRefused},
        {"a table of one dimension", "a.cube", "LUT_1D_SIZE 2\n0 0 0\n1 1 1\n", messages::kLutIs1d,
         kRefused},
        // Others
        {"numbers alone", "a.raw", "0123", messages::kOnlyNumbers, kRefused},
        {"HDF5", "a.h5", "\x89HDF", "HDF5", kRefused},
        {"another scanner's", "a.mgz", "mgz", fmt::format(messages::kVolumesNotRead, ".mgz"),
         kRefused},
    };
}

using VolumeFeatures = FieldTest;

TEST_F(VolumeFeatures, AreCarriedOverOrTold) {
    for (const Feature& feature : features()) {
        SCOPED_TRACE(fmt::format("{} of {}", feature.name, feature.file));
        const auto file = folder_.write(feature.file, feature.text);
        VolumeOptions options;
        options.field = feature.field;
        if (feature.values == kRefused) {
            EXPECT_THAT(trouble(file, options), testing::Says(feature.told));
            continue;
        }
        ::testing::internal::CaptureStderr();
        const auto p = converted(file, options);
        const std::string told = ::testing::internal::GetCapturedStderr();
        if (feature.told.empty()) {
            EXPECT_EQ(told, "");
        } else {
            EXPECT_THAT(told, testing::Says(feature.told));
        }
        ASSERT_NE(p, nullptr);
        if (feature.values != kSampled) {
            EXPECT_EQ(level0(*p), feature.values);
        }
        if (!feature.domain.empty()) {
            EXPECT_EQ(domain(*p), feature.domain);
        }
    }
}

}  // namespace
}  // namespace openfab::tools
