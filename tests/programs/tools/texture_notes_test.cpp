// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What converters tell of the files of textures reaches the user through every door: `texture`, `print`, `estimate`, `info`,
// `import` and the page, also when the texture comes from the cache. A row for each converter that tells anything.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "base/json_text.h"
#include "runtime/part/messages.h"
#include "tests/programs/viewer/viewer_client.h"
#include "tests/support/places/places.h"
#include "tools/openfab/messages.h"
#include "tools/texture/messages.h"
#ifdef OPENFAB_READS_DICOM
#include "tests/programs/tools/noted_dicom.h"
#include "tools/dicom/messages.h"
#endif
#ifdef OPENFAB_READS_HDF5
#include "tests/programs/tools/noted_hdf5.h"
#include "tools/hdf5/messages.h"
#endif

namespace openfab::testing {
namespace {

namespace notes = tools::messages;
using ::testing::HasSubstr;

std::string little(uint64_t value, size_t bytes) {
    std::string out;
    for (size_t i = 0; i < bytes; ++i)
        out += static_cast<char>(value >> (8 * i) & 0xff);
    return out;
}

/// A page of a TIFF: 2 x 2 pixels of a byte, or of four.
struct Page {
    int photometric = 1, bits = 8, kind = 0;
    std::string pixels = std::string("\1\2\3\4", 4);
    int pixels_a_cm = 0;
    int orientation = 1;
};

std::string tiff(const std::vector<Page>& pages) {
    std::string out = "II*" + std::string(1, '\0') + little(8, 4);
    for (size_t i = 0; i < pages.size(); ++i) {
        const Page& page = pages[i];
        const size_t entries = page.photometric == 3 ? 14 : 13;
        const size_t behind = out.size() + 2 + 12 * entries + 4;
        const size_t colours = behind + page.pixels.size(), ratio = colours + 6 * 256;
        std::string list;
        const auto entry = [&](int tag, int type, size_t count, uint64_t value) {
            list += little(static_cast<uint64_t>(tag), 2) + little(static_cast<uint64_t>(type), 2) +
                    little(count, 4) + little(value, 4);
        };
        entry(254, 4, 1, static_cast<uint64_t>(page.kind));
        entry(256, 3, 1, 2);
        entry(257, 3, 1, 2);
        entry(258, 3, 1, static_cast<uint64_t>(page.bits));
        entry(259, 3, 1, 1);
        entry(262, 3, 1, static_cast<uint64_t>(page.photometric));
        entry(273, 4, 1, behind);
        entry(274, 3, 1, static_cast<uint64_t>(page.orientation));
        entry(278, 3, 1, 2);
        entry(279, 4, 1, page.pixels.size());
        entry(282, 5, 1, ratio);
        entry(283, 5, 1, ratio);
        entry(296, 3, 1, page.pixels_a_cm > 0 ? 3 : 1);
        if (page.photometric == 3) entry(320, 3, 3 * size_t{256}, colours);
        const size_t end = ratio + 8;
        out += little(entries, 2) + list + little(i + 1 < pages.size() ? end : 0, 4) + page.pixels +
               std::string(6 * 256, '\0') +
               little(static_cast<uint64_t>(std::max(page.pixels_a_cm, 1)), 4) + little(1, 4);
    }
    return out;
}

const std::string kBig = little((1 << 24) + 1, 4) + little(0, 4);

std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
    std::string head =
        "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
    head.resize(117, ' ');
    return "\x93NUMPY" + std::string("\1\0", 2) + little(118, 2) + head + "\n" + data;
}

std::string nifti(const std::string& data) {
    std::string out(352, '\0');
    const auto put = [&](size_t at, const std::string& bytes) {
        out.replace(at, bytes.size(), bytes);
    };
    put(0, little(348, 4));
    for (size_t i = 0; i < 8; ++i)
        put(40 + 2 * i, little(i == 0 ? 3 : i == 1 ? 2 : 1, 2));
    put(70, little(8, 2) + little(32, 2));
    for (size_t i = 0; i < 4; ++i)
        put(76 + 4 * i, little(0x3f800000, 4));
    put(108, little(0x43b00000, 4));  // 352
    put(344, std::string("n+1\0", 4));
    return out + data;
}

constexpr const char* kTetrahedronAndLine =
    R"(<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="2">
<PointData><DataArray type="Float32" Name="f" format="ascii">0 1 1 1</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3 0 1</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">4 6</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10 3</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>
)";

constexpr const char* kLegacyTetrahedronAndLine = R"(# vtk DataFile Version 3.0
two cells
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 4 float
0 0 0 1 0 0 0 1 0 0 0 1
CELLS 2 8
4 0 1 2 3
2 0 1
CELL_TYPES 2
10 3
POINT_DATA 4
SCALARS f float 1
LOOKUP_TABLE default
0 1 1 1
)";

constexpr const char* kImageWithGhosts =
    R"(<VTKFile type="ImageData" version="1.0"><ImageData WholeExtent="0 1 0 1 0 1" Origin="0 0 0" Spacing="1 1 1">
<Piece Extent="0 1 0 1 0 1"><PointData>
<DataArray type="Float32" Name="f" format="ascii">0 1 0 1 0 1 0 1</DataArray>
<DataArray type="UInt8" Name="vtkGhostType" format="ascii">0 0 0 0 0 0 0 1</DataArray>
</PointData></Piece></ImageData></VTKFile>
)";

constexpr const char* kXdmf =
    R"(<Xdmf Version="3.0"><Domain><Grid GridType="Uniform"><Topology TopologyType="3DCoRectMesh" Dimensions="1 1 2"/>
<Geometry GeometryType="ORIGIN_DXDYDZ"><DataItem Dimensions="3" Format="XML">0 0 0</DataItem>
<DataItem Dimensions="3" Format="XML">1 1 1</DataItem></Geometry>
<Attribute Name="f" Center="Node"><DataItem Dimensions="1 1 2" Format="XML" NumberType="Int" Precision="8">
16777217 0</DataItem></Attribute></Grid></Domain></Xdmf>
)";

constexpr const char* kXdmfSteps =
    R"(<Xdmf Version="3.0"><Domain><Grid GridType="Collection" CollectionType="Temporal">
<Grid><Time Value="0"/><Topology TopologyType="3DCoRectMesh" Dimensions="1 1 2"/>
<Geometry GeometryType="ORIGIN_DXDYDZ"><DataItem Dimensions="3">0 0 0</DataItem><DataItem Dimensions="3">1 1 1</DataItem></Geometry>
<Attribute Name="f"><DataItem Dimensions="1 1 2">0 1</DataItem></Attribute></Grid>
<Grid><Time Value="1"/><Topology TopologyType="3DCoRectMesh" Dimensions="1 1 2"/>
<Geometry GeometryType="ORIGIN_DXDYDZ"><DataItem Dimensions="3">0 0 0</DataItem><DataItem Dimensions="3">1 1 1</DataItem></Geometry>
<Attribute Name="f"><DataItem Dimensions="1 1 2">1 1</DataItem></Attribute></Grid></Grid></Domain></Xdmf>
)";

constexpr const char* kLegacyImage = R"(# vtk DataFile Version 3.0
an image
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 2 1 1
ORIGIN 0 0 0
SPACING 1 1 1
POINT_DATA 2
SCALARS f long 1
LOOKUP_TABLE default
16777217 0
)";

struct Row {
    std::string name;  ///< of the texture, and the stem of its file
    std::string file;
    std::string content;
    std::string told;
    bool is_picture = false;
};

std::vector<Row> rows() {
    const auto rounded = [](const std::string& file) {
        return fmt::format(notes::kIntegersRounded, file);
    };
    const std::string nrrd = "NRRD0004\ndimension: 3\nencoding: raw\nendian: little\n";
    Page palette, white, sized, small, big, turned;
    palette.photometric = 3;
    white.photometric = 0;
    sized.pixels_a_cm = 10;
    small.kind = 1;
    turned.orientation = 3;
    big.bits = 32;
    big.pixels = kBig + kBig;
    return {
        {"mins", "mins.nrrd",
         nrrd + "type: uint8\nsizes: 2 1 1\naxis mins: 5 6 7\n\n" + std::string(2, '\1'),
         fmt::format(notes::kAxisMinsLeftOut, "mins.nrrd")},
        {"maxs", "maxs.nrrd",
         nrrd + "type: uint8\nsizes: 2 1 1\naxis maxs: 5 6 7\n\n" + std::string(2, '\1'),
         fmt::format(notes::kAxisMaxsLeftOut, "maxs.nrrd")},
        {"range", "range.nrrd",
         nrrd + "type: uint8\nsizes: 2 1 1\nold min: 0\nold max: 7\n\n" + std::string(2, '\1'),
         fmt::format(notes::kOldRangeLeftOut, "range.nrrd")},
        {"nrrd", "nrrd.nrrd", nrrd + "type: int32\nsizes: 2 1 1\n\n" + kBig, rounded("nrrd.nrrd")},
        {"meta", "meta.mha",
         "ObjectType = Image\nNDims = 3\nDimSize = 2 1 1\nElementType = MET_INT\nElementDataFile = "
         "LOCAL\n" +
             kBig,
         rounded("meta.mha")},
        {"nifti", "nifti.nii", nifti(kBig), rounded("nifti.nii")},
        {"npy", "npy.npy", npy("<i4", "1, 1, 2", kBig), rounded("npy.npy")},
        {"palette", "palette.tif", tiff({palette}),
         fmt::format(notes::kPaletteAsNumbers, "palette.tif", 255)},
        {"white", "white.tif", tiff({white}), fmt::format(notes::kWhiteIsLeast, "white.tif")},
        {"sized", "sized.tif", tiff({sized}),
         "sized.tif: " + fmt::format(notes::kResolutionLeftOut, 1.0, 1.0)},
        {"reduced", "reduced.tif", tiff({Page{}, small}), fmt::format(notes::kReducedLeftOut, 1)},
        {"turned", "turned.tif", tiff({turned}),
         "turned.tif: " + fmt::format(notes::kOrientationLeftOut, 3)},
        {"wide", "wide.tif", tiff({big}), rounded("wide.tif")},
        {"unstructured", "unstructured.vtu", kTetrahedronAndLine,
         fmt::format(notes::kCellsWithoutVolume, 1)},
        {"legacy", "legacy.vtk", kLegacyTetrahedronAndLine,
         fmt::format(notes::kCellsWithoutVolume, 1)},
        {"image", "image.vti", kImageWithGhosts,
         fmt::format(notes::kGhostsLeftOut, "image.vti", "vtkGhostType")},
        {"points", "points.vtk", kLegacyImage, rounded(notes::kItsFieldAlone)},
        {"steps", "steps.xdmf", kXdmf, rounded(notes::kItsFieldAlone)},
        {"series_of_time", "series.xdmf", kXdmfSteps,
         fmt::format(notes::kFirstOfSteps, "series.xdmf", 2)},
#ifdef OPENFAB_READS_DICOM
        {"inverted", "inverted.dcm", inverted_dicom(),
         fmt::format(notes::kStoredMonochrome1, "inverted.dcm")},
        {"unplaced", "unplaced.dcm", unplaced_dicom(),
         fmt::format(notes::kPlaceUnknown, "unplaced.dcm")},
        {"ultrasound", "ultrasound.dcm", ultrasound_dicom(),
         fmt::format(notes::kPlaceOfVolume, "ultrasound.dcm")},
        {"nuclear", "nuclear.dcm", nuclear_dicom(), fmt::format(notes::kContiguous, "nuclear.dcm")},
        {"mapped", "mapped.dcm", mapped_dicom(), fmt::format(notes::kOtherValues, "mapped.dcm")},
        {"digits", "digits.dcm", long_dicom(), fmt::format(notes::kRounded, "digits.dcm")},
#endif
        {"pages", "pages.tif", tiff({Page{}, Page{}}),
         fmt::format(notes::kSeveralPictures, "pages.tif"), true},
    };
}

constexpr const char* kFablets = R"(fablet Volumes {
    @uniform { ImageTexture3D t; Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float v = clamp(t.Sample1(attr.voxelCenter, 0, 0), 0, 1);
        mc.Set(a, v);
        mc.Set(b, 1 - v);
        return mc;
    }
}
fablet Pictures {
    @uniform { ImageTexture2D t; Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float v = clamp(t.Sample1(attr.voxelCenter.xy, 0), 0, 1);
        mc.Set(a, v);
        mc.Set(b, 1 - v);
        return mc;
    }
}
)";

/// Of each line of `wanted` whether a text has it; the failure says which are missing.
void expect_all(const std::string& text, const std::vector<std::string>& wanted) {
    for (const std::string& line : wanted)
        EXPECT_THAT(text, HasSubstr(line));
}

class TextureNotes : public ::testing::Test {
  protected:
    TextureNotes() {
        JsonText json;
        std::string textures, objects, build;
        for (const Row& row : rows()) {
            scratch_.write(row.file, row.content);
            add(row.name, row.file, row.told, row.is_picture, &textures, &objects, &build);
        }
#ifdef OPENFAB_READS_HDF5
        const std::string unwritten =
            fmt::format(notes::kChunksAreFill, 1, 1, "/VTKHDF/PointData/f");
        write_vtk_hdf(path("unwritten.vtkhdf"), HdfField::kUnwritten);
        write_vtk_hdf(path("ghosts.vtkhdf"), HdfField::kWithGhosts);
        write_vtk_hdf(path("long.vtkhdf"), HdfField::kLong);
        scratch_.write("unwritten.xdmf", xdmf_of("unwritten.vtkhdf:/VTKHDF/PointData/f"));
        scratch_.write("long.xdmf", xdmf_of("long.vtkhdf:/VTKHDF/PointData/f"));
        const std::string rounded = fmt::format(notes::kIntegersRounded, notes::kItsFieldAlone);
        const std::string ghosts =
            fmt::format(notes::kGhostsLeftOut, "ghosts.vtkhdf", "vtkGhostType");
        add("unwritten", "unwritten.vtkhdf", unwritten, false, &textures, &objects, &build);
        add("ghosts", "ghosts.vtkhdf", ghosts, false, &textures, &objects, &build);
        add("long", "long.vtkhdf", rounded, false, &textures, &objects, &build);
        add("unwritten_set", "unwritten.xdmf", unwritten, false, &textures, &objects, &build);
        add("long_set", "long.xdmf", rounded, false, &textures, &objects, &build);
#endif
#ifdef OPENFAB_READS_DICOM
        std::filesystem::create_directory(scratch_ / "hospital");
        scratch_.write("hospital/im", plain_dicom());
        scratch_.write("hospital/README", "how to see it");
        add("hospital", "hospital", fmt::format(notes::kPassedOverNoSlices, "hospital", "README"),
            false, &textures, &objects, &build);
        std::filesystem::create_directory(scratch_ / "medium");
        scratch_.write("medium/im", plain_dicom());
        scratch_.write("medium/report", report_dicom());
        add("medium", "medium",
            fmt::format(
                notes::kPassedOverOtherSeries, "medium",
                fmt::format("report ({})", fmt::format(notes::kPixelsAreColours, "PALETTE COLOR"))),
            false, &textures, &objects, &build);
#endif
        const auto add_series = [&](const std::string& name, const std::vector<std::string>& files,
                                    const std::string& told) {
            std::filesystem::create_directory(scratch_ / name);
            for (const std::string& file : files)
                scratch_.write(name + "/" + file + ".pgm", "P2\n1 1\n255\n128\n");
            add(name, name, told, false, &textures, &objects, &build);
        };
        add_series("times", {"t0", "t1"},
                   fmt::format(notes::kTakenAsSlices, "t0.pgm", "t1.pgm", "time"));
        add_series("numbers", {"a1_1", "a1_2", "a2_1"},
                   fmt::format(notes::kSeriesOfSeveralNumbers, "a1_1.pgm", "a1_2.pgm", "a2_1.pgm"));
        add_series("series", {"s0", "s1", "s3"},
                   fmt::format(notes::kSeriesHasGap, "s1.pgm", "s3.pgm"));
        scratch_.write("all.fl", kFablets);
        scratch_.write("all.fab.json", fmt::format(R"({{"openfab": 1, "printer": "generic",
"fablets": {{"volumes": {{"source": "all.fl", "fablet": "Volumes"}}, "pictures": {{"source": "all.fl", "fablet": "Pictures"}}}},
"materials": {{"a": {{"key": "#ffffff"}}, "b": {{"key": "#000000"}}}},
"textures": {{{}}}, "meshes": {{"box": {{"box": [1, 1, 1]}}}}, "objects": {{{}}}, "build": [{}]}})",
                                                   textures, objects, build));
    }

    void add(const std::string& name, const std::string& file, const std::string& told,
             bool is_picture, std::string* textures, std::string* objects, std::string* build) {
        const char* comma = textures->empty() ? "" : ", ";
        *textures += fmt::format(R"({}"{}": {{"file": "{}"}})", comma, name, file);
        *objects += fmt::format(
            R"({}"{}": {{"mesh": "box", "fablet": "{}", "uniforms": {{"t": "{}", "a": "a", "b": "b"}}}})",
            comma, name, is_picture ? "pictures" : "volumes", name);
        *build += fmt::format(R"({}{{"object": "{}", "translate_mm": [{}, 0, 0]}})", comma, name,
                              2 * told_.size());
        told_.push_back(told);
        warned_.push_back(fmt::format(part::messages::kTextureBefore, name) + told);
    }
    std::string path(const std::string& name) const {
        return (scratch_ / name).string();
    }
    Outcome openfab(std::vector<std::string> words) const {
        words.insert(words.begin(), program("openfab"));
        Outcome outcome = run(words, {{{"OPENFAB_CACHE", path("cache")}}, scratch_.path(), {}});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return outcome;
    }
    /// As JSON has it within a text.
    static std::vector<std::string> as_json(std::vector<std::string> lines) {
        for (std::string& line : lines) {
            JsonText json;
            json.value(line);
            line = json.take();
            line = line.substr(1, line.size() - 2);
        }
        return lines;
    }

    ScratchFolder scratch_;
    std::vector<std::string> told_,
        warned_;  ///< by row; as the converter tells it, and as a print does
};

TEST_F(TextureNotes, ReachEachDoorOfTheCommandLine) {
    for (const Row& row : rows()) {
        std::vector<std::string> words{"texture", row.file, "-o", "out.oftx"};
        if (!row.is_picture) words.emplace_back("--volume");
        EXPECT_EQ(openfab(words).err, "note: " + row.told + "\n");
        if (row.is_picture) continue;
        EXPECT_EQ(openfab({"info", row.file}).err, "note: " + row.told + "\n");
    }
    EXPECT_EQ(openfab({"info", "series"}).err, "note: " + told_.back() + "\n");
    // The first of these makes the textures, others have them from the cache.
    for (int time = 0; time < 2; ++time) {
        const std::string err = openfab({"print", "all.fab.json", "-o", "out.ofr", "--voxel",
                                         "0.5mm", "--stats", "stats.json"})
                                    .err;
        expect_all(err, warned_);
        expect_all(read_file(scratch_ / "stats.json"), as_json(warned_));
    }
    expect_all(
        openfab({"print", "all.fab.json", "--voxel", "0.5mm", "--probe", "0.25,0.25,0.25"}).err,
        warned_);
    expect_all(openfab({"print", "all.fab.json", "--voxel", "0.5mm", "--estimate"}).err, warned_);
    expect_all(openfab({"print", "all.fab.json", "-o", "out.ofr", "--voxel", "0.5mm", "--progress",
                        "json"})
                   .err,
               as_json(warned_));
    expect_all(openfab({"info", "all.fab.json"}).err, warned_);
    std::filesystem::remove_all(scratch_ / "cache");
    expect_all(openfab({"info", "all.fab.json"}).err, warned_);
}

TEST_F(TextureNotes, ReachThePage) {
    const Viewer viewer({path("all.fab.json"), "--watch", "--draft", "1"}, path("cache"));
    for (int time = 0; time < 2; ++time) {
        const JsonValue state = viewer.wait_for([&](const JsonValue& s) {
            return member(member(s, "live"), "phase").text == "done" &&
                   member(s, "generation").number > time;
        });
        expect_all(member(member(state, "live"), "message").text, warned_);
        if (time == 0) {
            EXPECT_EQ(viewer.post("/api/draft", R"({"draft": 2})").status, 200);
        }
    }
}

TEST_F(TextureNotes, ReachAnImport) {
    scratch_.write("quad.mtl", "newmtl skin\nKd 1 1 1\nmap_Kd pages.tif\n");
    scratch_.write(
        "quad.obj",
        "mtllib quad.mtl\nv 0 0 0\nv 4 0 0\nv 0 4 0\nv 0 0 4\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl skin\n"
        "f 1/1 3/3 2/2\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n");
    EXPECT_THAT(openfab({"import", "quad.obj", "-o", "made"}).err,
                HasSubstr("note: " + fmt::format(notes::kSeveralPictures, "pages.tif") + "\n"));
#ifdef OPENFAB_READS_DICOM
    scratch_.write("leg.dcm", segments_dicom());
    const std::string segments = openfab({"import", "leg.dcm", "-o", "leg"}).err;
    EXPECT_THAT(segments,
                HasSubstr("note: " + fmt::format(notes::kSegmentNowhere, 2, "bone") + "\n"));
    EXPECT_THAT(segments,
                HasSubstr("note: " + fmt::format(notes::kPlaceUnknown, "leg.dcm") + "\n"));
    EXPECT_THAT(openfab({"print", "leg/leg.fab.json", "-o", "leg.ofr", "--voxel", "0.5mm"}).err,
                HasSubstr(fmt::format(notes::kPlaceUnknown, "leg.dcm")));
#endif
}

}  // namespace
}  // namespace openfab::testing
