// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Mesh files, read back by a widely used library and by our own readers.

#include "backends/boundary/mesh_sink.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <assimp/scene.h>
#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "backends/boundary/formats.h"
#include "backends/boundary/messages.h"
#include "mesh/load/load_mesh.h"
#include "mesh/read/stl.h"
#include "mesh/read/threemf.h"
#include "mesh/read/zip_file.h"
#include "tests/support/boundary/mesh_files.h"
#include "tests/support/boundary/voxel_meshes.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
namespace fs = std::filesystem;

/// Coordinates of such a print are exact in single precision.
SamplePrint exact_sample(Vec3i size, int32_t bits = 4) {
    SamplePrint print = make_sample(size, bits);
    print.info.pitch_mm = {0.125, 0.25, 0.5};
    print.info.origin_mm = {-3.5, 2.25, 0};
    return print;
}

VoxelBlock block_of(const SamplePrint& print) {
    VoxelBlock block(print.info.size);
    block.codes = print.codes;
    return block;
}

class MeshFiles : public ::testing::Test {
  protected:
    Result<void> write(const SamplePrint& print, const std::string& name, bool complete = true) {
        const fs::path path = scratch_ / name;
        boundary::MeshSink sink(path.extension() == ".stl" ? boundary::make_stl_writer(path)
                                                           : boundary::make_threemf_writer(path));
        return print.send(&sink, complete);
    }

    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
            names.push_back(entry.path().filename().string());
        return names;
    }

    CollectedMeshes read_threemf(const SamplePrint& print, const std::string& name) {
        return read_threemf_meshes(read_file(scratch_ / name), print.info);
    }

    ScratchFolder scratch_;
};

TEST_F(MeshFiles, A3mfHoldsTheMeshes) {
    for (int32_t bits : {4, 8}) {
        const SamplePrint print = exact_sample({13, 7, 9}, bits);
        ASSERT_TRUE(write(print, "part.3mf"));
        EXPECT_THAT(files(), UnorderedElementsAre("part.3mf"));
        EXPECT_EQ(check_meshes(block_of(print), read_threemf(print, "part.3mf")), "");
    }
}

/// Our own loader accepts it without warnings, although voxels touch in all ways.
TEST_F(MeshFiles, A3mfCanBePrinted) {
    SamplePrint print = exact_sample({40, 30, 20});
    ASSERT_TRUE(write(print, "part.3mf"));
    Result<mesh::LoadedMesh> mesh = mesh::load_mesh(scratch_ / "part.3mf", {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    EXPECT_TRUE(mesh->checks.edges.fine());
    EXPECT_EQ(mesh->checks.turned, 0);
    EXPECT_EQ(mesh->unit_note, "as the file says");
    ASSERT_EQ(mesh->groups.size(), 3u);
    EXPECT_EQ(mesh->groups[0].first, "white");
}

TEST_F(MeshFiles, A3mfForFilamentsHoldsAllMeshesInOneObject) {
    SamplePrint print = exact_sample({13, 7, 9}, 8);
    // More filaments than a digit of the painting holds without its longer form.
    while (print.info.materials.size() < boundary::kMostFilaments) {
        pipeline::SliceMaterial more = print.info.materials[0];
        more.name = fmt::format("m{}", print.info.materials.size() + 1);
        print.info.materials.push_back(more);
    }
    for (size_t i = 0; i < print.codes.size(); ++i) {
        if (print.codes[i] == 3) print.codes[i] = static_cast<uint8_t>(3 + i % 13);
    }
    boundary::MeshSink sink(boundary::make_filament_writer(scratch_ / "part.3mf"));
    ASSERT_TRUE(print.send(&sink));
    const std::string bytes = read_file(scratch_ / "part.3mf");
    const PaintedMesh painted = read_painted_threemf(bytes, print.info);
    EXPECT_EQ(check_painted(block_of(print), painted), "");

    // What slicers read: the values that they write themselves, by filament from 1.
    const char* const kWritten[] = {"4",  "8",  "0C", "1C", "2C", "3C", "4C", "5C",
                                    "6C", "7C", "8C", "9C", "AC", "BC", "CC"};
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "part.3mf");
    ASSERT_TRUE(zip) << zip.error().text();
    const Result<std::string> model = zip->read("3D/3dmodel.model");
    ASSERT_TRUE(model) << model.error().text();
    size_t at = 0;
    for (const uint8_t code : painted.codes) {
        at = model->find(" p1=", at);
        ASSERT_NE(at, std::string::npos);
        const std::string expected =
            fmt::format(" p1=\"{}\" slic3rpe:mmu_segmentation=\"0\" paint_color=\"{}\"/>", code - 1,
                        kWritten[code - 1]);
        ASSERT_EQ(model->substr(at, expected.size()), expected);
        at += expected.size();
    }
    EXPECT_EQ(model->find(" p1=", at), std::string::npos);

    // The volumes are all triangles, each those of its filament.
    const Result<std::string> config = zip->read("Metadata/Slic3r_PE_model.config");
    ASSERT_TRUE(config) << config.error().text();
    const std::regex volume(
        R"re(firstid="([0-9]+)" lastid="([0-9]+)">[\s\S]*?key="extruder" value="([0-9]+)")re");
    size_t next = 0;
    for (std::sregex_iterator each(config->begin(), config->end(), volume), end; each != end;
         ++each) {
        const size_t first = std::stoul((*each)[1]), last = std::stoul((*each)[2]);
        ASSERT_EQ(first, next);
        for (size_t t = first; t <= last; ++t)
            ASSERT_EQ(painted.codes.at(t), std::stoul((*each)[3]));
        next = last + 1;
    }
    EXPECT_EQ(next, painted.codes.size());
}

/// The build of a 3MF stands on the bed, which exact_sample's x and these heights do not.
TEST_F(MeshFiles, WhatIsBelowTheBedIsPlacedOrTold) {
    SamplePrint print = exact_sample({5, 4, 6});
    EXPECT_EQ(boundary::kStlFormat.note(print.info), "");
    print.info.origin_mm.z = -4;
    print.info.slice_begin = 2;
    EXPECT_THAT(boundary::kStlFormat.note(print.info),
                testing::Says(boundary::messages::kBelowBed, "-3"));
    ASSERT_TRUE(write(print, "part.3mf"));
    Result<mesh::LoadedMesh> mesh = mesh::load_mesh(scratch_ / "part.3mf", {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    Vec3d lowest{1e9, 1e9, 1e9};
    for (const Vec3d& p : mesh->mesh.positions) {
        for (int a = 0; a < 3; ++a)
            lowest[a] = std::min(lowest[a], p[a]);
    }
    EXPECT_EQ(lowest, (Vec3d{0, 2.25, 0}));
}

TEST_F(MeshFiles, SlicersNumberFewFilaments) {
    SamplePrint print = exact_sample({4, 4, 4});
    print.info.materials.resize(boundary::kMostFilaments + 1, print.info.materials[0]);
    boundary::MeshSink sink(boundary::make_filament_writer(scratch_ / "part.3mf"));
    const Result<void> done = print.send(&sink);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
    EXPECT_THAT(done.error().text(),
                testing::Says(boundary::messages::kTooManyFilaments, "*", "15"));
    EXPECT_THAT(files(), UnorderedElementsAre());
}

TEST_F(MeshFiles, AnStlHasTheTrianglesOfItsMaterial) {
    const SamplePrint print = exact_sample({13, 7, 9});
    ASSERT_TRUE(write(print, "part.stl"));
    EXPECT_THAT(files(),
                UnorderedElementsAre("part_white.stl", "part_black.stl", "part_clear__x_.stl"));
    const CollectedMeshes expected = mesh_block(block_of(print));
    for (uint8_t code = 1; code < 4; ++code) {
        const fs::path file = boundary::stl_path(scratch_ / "part.stl", print.info, code - 1u);
        const std::string bytes = read_file(file);
        Result<mesh::MeshSource> source = mesh::parse_stl(bytes, "part.stl");
        ASSERT_TRUE(source);
        const CollectedMesh& mesh = expected.at(code);
        ASSERT_EQ(bytes.size(), 84 + 50 * mesh.triangles.size());
        for (size_t t = 0; t < mesh.triangles.size(); ++t) {
            for (size_t c = 0; c < 3; ++c) {
                ASSERT_EQ(half_voxels(source->mesh.positions[3 * t + c], print.info),
                          mesh.points[mesh.triangles[t][c]]);
            }
            float normal[3];
            std::memcpy(normal, bytes.data() + 84 + 50 * t, sizeof normal);
            const Vec3d a = source->mesh.positions[3 * t], b = source->mesh.positions[3 * t + 1],
                        c = source->mesh.positions[3 * t + 2];
            const Vec3d area = cross(b - a, c - a);
            ASSERT_GT(area.x * normal[0] + area.y * normal[1] + area.z * normal[2], 0);
        }
    }
}

/// Welds like any STL reader: equal coordinates are one vertex. Positions are in 1/4096 voxel.
CollectedMesh merged(const std::string& bytes, const pipeline::PrintInfo& info) {
    CollectedMesh mesh;
    std::map<std::array<float, 3>, uint32_t> numbers;
    for (size_t at = 84; at + 50 <= bytes.size(); at += 50) {
        std::array<uint32_t, 3>& triangle = mesh.triangles.emplace_back();
        for (size_t c = 0; c < 3; ++c) {
            std::array<float, 3> p{};
            std::memcpy(p.data(), bytes.data() + at + 12 * (c + 1), 12);
            const auto number = static_cast<uint32_t>(mesh.points.size());
            const auto [found, fresh] = numbers.try_emplace(p, number);
            if (fresh) {
                Vec3i& vertex = mesh.points.emplace_back();
                for (int a = 0; a < 3; ++a) {
                    const double voxels = (p[a] - info.origin_mm[a]) / info.pitch_mm[a];
                    vertex[a] = static_cast<int32_t>(std::lround(voxels * 4096));
                }
            }
            triangle[c] = found->second;
        }
    }
    return mesh;
}

/// Two triangles to an edge and one fan to a vertex, though voxels touch in all ways; also where a
/// step is below single precision.
TEST_F(MeshFiles, AnStlIsManifoldByItsCoordinates) {
    for (const double pitch : {0.125, 0.1, 1.7e-4}) {
        SamplePrint print = exact_sample({40, 30, 20});
        print.info.pitch_mm = {pitch, 1.5 * pitch, pitch};
        print.info.origin_mm = {300, -250.3, 1};
        ASSERT_TRUE(write(print, "part.stl"));
        for (size_t m = 0; m < 3; ++m) {
            const fs::path file = boundary::stl_path(scratch_ / "part.stl", print.info, m);
            const CollectedMesh mesh = merged(read_file(file), print.info);
            EXPECT_EQ(check_manifold(mesh), "") << pitch << " material " << m;
            // In parts of 4096 of a voxel; steps of single precision are up to a quarter of one.
            const double exact =
                6 * std::pow(4096.0, 3) *
                static_cast<double>(block_of(print).count(static_cast<uint8_t>(m + 1)));
            EXPECT_NEAR(static_cast<double>(six_volumes(mesh)), exact,
                        exact * (pitch < 1e-3 ? 0.5 : 0.012));
        }
    }
}

/// By position, twice as many triangles pass an edge where sheets touch, as many in each direction.
bool closed(const aiMesh& mesh) {
    using Point = std::array<float, 3>;
    std::map<std::pair<Point, Point>, int> edges;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        for (unsigned c = 0; c < 3; ++c) {
            const auto at = [&](unsigned corner) {
                const aiVector3D& v = mesh.mVertices[mesh.mFaces[f].mIndices[corner % 3]];
                return Point{v.x, v.y, v.z};
            };
            ++edges[{at(c), at(c + 1)}];
            --edges[{at(c + 1), at(c)}];
        }
    }
    return std::all_of(edges.begin(), edges.end(), [](const auto& e) { return e.second == 0; });
}

double six_volumes(const aiMesh& mesh) {
    double sum = 0;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
        Vec3d p[3];
        for (unsigned c = 0; c < 3; ++c) {
            const aiVector3D& v = mesh.mVertices[mesh.mFaces[f].mIndices[c]];
            p[c] = {v.x, v.y, v.z};
        }
        sum += dot(p[0], cross(p[1], p[2]));
    }
    return sum;
}

TEST_F(MeshFiles, AssimpReadsA3mf) {
    const SamplePrint print = exact_sample({20, 11, 9});
    ASSERT_TRUE(write(print, "part.3mf"));
    Assimp::Importer importer;
    const aiScene* read = importer.ReadFile((scratch_ / "part.3mf").string(), 0);
    ASSERT_NE(read, nullptr) << importer.GetErrorString();
    ASSERT_EQ(read->mNumMeshes, 3u);
    const double six_voxels = 6 * 0.125 * 0.25 * 0.5;
    for (unsigned m = 0; m < 3; ++m) {
        const aiMesh& mesh = *read->mMeshes[m];
        EXPECT_TRUE(closed(mesh));
        EXPECT_EQ(
            six_volumes(mesh),
            six_voxels * static_cast<double>(block_of(print).count(static_cast<uint8_t>(m + 1))));
        const aiMaterial& material = *read->mMaterials[mesh.mMaterialIndex];
        aiColor4D color;
        ASSERT_EQ(material.Get(AI_MATKEY_COLOR_DIFFUSE, color), aiReturn_SUCCESS);
        EXPECT_NEAR(color.r * 255, print.info.materials[m].preview[0], 0.01);
        EXPECT_NEAR(color.b * 255, print.info.materials[m].preview[2], 0.01);
    }
}

TEST_F(MeshFiles, AssimpReadsAnStl) {
    const SamplePrint print = exact_sample({20, 11, 9});
    ASSERT_TRUE(write(print, "part.stl"));
    const double six_voxels = 6 * 0.125 * 0.25 * 0.5;
    for (size_t m = 0; m < 3; ++m) {
        Assimp::Importer importer;
        const aiScene* read =
            importer.ReadFile(boundary::stl_path(scratch_ / "part.stl", print.info, m).string(), 0);
        ASSERT_NE(read, nullptr) << importer.GetErrorString();
        ASSERT_EQ(read->mNumMeshes, 1u);
        EXPECT_TRUE(closed(*read->mMeshes[0]));
        const double exact =
            six_voxels * static_cast<double>(block_of(print).count(static_cast<uint8_t>(m + 1)));
        // Vertices of sheets that touch are 1/512 voxel off.
        EXPECT_NEAR(six_volumes(*read->mMeshes[0]), exact, exact * 6 / 512);
    }
}

/// The bars of the F point to +x, at the highest y.
TEST_F(MeshFiles, TheLetterFIsNotMirrored) {
    SamplePrint print = make_letter_f(2, 3);
    print.info.origin_mm = {1, 2, 3};
    ASSERT_TRUE(write(print, "f.3mf"));
    EXPECT_EQ(check_meshes(block_of(print), read_threemf(print, "f.3mf")), "");
    Result<mesh::LoadedMesh> mesh = mesh::load_mesh(scratch_ / "f.3mf", {});
    ASSERT_TRUE(mesh) << mesh.error().text();
    double top = 0, right_at_top = 0, right_at_bottom = 0;
    for (const Vec3d& p : mesh->mesh.positions)
        top = std::max(top, p.y);
    for (const Vec3d& p : mesh->mesh.positions) {
        if (p.y == top) right_at_top = std::max(right_at_top, p.x);
        if (p.y < 2.1) right_at_bottom = std::max(right_at_bottom, p.x);
    }
    EXPECT_NEAR(top, 2 + 1.4, 1e-6);
    EXPECT_NEAR(right_at_top, 1 + 1.0, 1e-6);
    EXPECT_NEAR(right_at_bottom, 1 + 0.2, 1e-6);
}

TEST_F(MeshFiles, SomeSlicesStayAtTheirHeight) {
    SamplePrint print = exact_sample({6, 5, 12});
    print.info.slice_begin = 3;
    print.info.slice_end = 8;
    ASSERT_TRUE(write(print, "part.3mf"));
    VoxelBlock block = block_of(print);
    for (int32_t z = 0; z < 12; ++z) {
        for (int32_t i = 0; (z < 3 || z >= 8) && i < 30; ++i)
            block.at({i % 6, i / 6, z}) = 0;
    }
    EXPECT_EQ(check_meshes(block, read_threemf(print, "part.3mf")), "");
}

TEST_F(MeshFiles, TheSameBytesEachTime) {
    const SamplePrint print = exact_sample({23, 14, 11});
    ASSERT_TRUE(write(print, "a.3mf"));
    ASSERT_TRUE(write(print, "b.3mf"));
    EXPECT_TRUE(read_file(scratch_ / "a.3mf") == read_file(scratch_ / "b.3mf"));
}

TEST_F(MeshFiles, APrintThatEndsEarlyLeavesWhatWasThere) {
    scratch_.write("part.3mf", "earlier");
    scratch_.write("part_white.stl", "earlier");
    for (const char* name : {"part.3mf", "part.stl"}) {
        Result<void> done = write(exact_sample({20, 20, 20}), name, false);
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, ErrorCode::kInterrupted);
        EXPECT_THAT(done.error().text(), testing::Says(boundary::messages::kEndedEarly));
    }
    EXPECT_THAT(files(), UnorderedElementsAre("part.3mf", "part_white.stl"));
    EXPECT_EQ(read_file(scratch_ / "part.3mf"), "earlier");
}

TEST_F(MeshFiles, MaterialsWithoutVoxelsHaveNoMesh) {
    SamplePrint print = exact_sample({6, 6, 6});
    ASSERT_TRUE(write(print, "part.stl"));
    for (uint8_t& code : print.codes)
        code = code == 2 ? 1 : code;
    ASSERT_TRUE(write(print, "part.stl"));
    ASSERT_TRUE(write(print, "part.3mf"));
    EXPECT_THAT(files(), UnorderedElementsAre("part.3mf", "part_white.stl", "part_clear__x_.stl"));
    EXPECT_EQ(read_threemf(print, "part.3mf").size(), 2u);
    print.codes.assign(print.codes.size(), 0);
    for (const char* name : {"none.stl", "none.3mf"}) {
        Result<void> done = write(print, name);
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
        EXPECT_THAT(done.error().text(), testing::Says(boundary::messages::kNothingPrinted));
    }
    EXPECT_THAT(files(), UnorderedElementsAre("part.3mf", "part_white.stl", "part_clear__x_.stl"));
}

TEST_F(MeshFiles, NamesOfMaterialsAreMadeFitForFiles) {
    pipeline::PrintInfo info = exact_sample({1, 1, 1}).info;
    info.materials[0].name = "Red";
    info.materials[1].name = "red";
    info.materials[2].name = "../up";
    const auto name = [&](size_t m) { return boundary::stl_path("out/p.stl", info, m).string(); };
    EXPECT_EQ(name(0), "out/p_Red_1.stl");
    EXPECT_EQ(name(1), "out/p_red_2.stl");
    EXPECT_EQ(name(2), "out/p_.._up.stl");
}

TEST_F(MeshFiles, WhatCannotBeWrittenIsTold) {
    fs::create_directory(scratch_ / "folder.stl");
    fs::create_directory(scratch_ / "folder.3mf");
    for (const char* name : {"folder.stl", "folder.3mf"}) {
        Result<void> done = write(exact_sample({4, 4, 4}), name);
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, ErrorCode::kUserInput);
        EXPECT_THAT(done.error().text(), HasSubstr("folder"));
    }
    for (const char* name : {"none/part.stl", "none/part.3mf"}) {
        Result<void> done = write(exact_sample({4, 4, 4}), name);
        ASSERT_FALSE(done);
        EXPECT_EQ(done.error().code, ErrorCode::kOutside);
    }
}

TEST_F(MeshFiles, TooFineForItsPlace) {
    SamplePrint print = exact_sample({4, 4, 4});
    print.info.pitch_mm = {1e-4, 1e-4, 1e-4};
    print.info.origin_mm = {500, 0, 0};
    Result<void> done = write(print, "part.3mf");
    ASSERT_FALSE(done);
    EXPECT_THAT(done.error().text(), HasSubstr("--mesh-pitch"));
    EXPECT_THAT(files(), UnorderedElementsAre());
}

/// A disk that is full after a while, as the system's limit on the size of files makes one.
TEST_F(MeshFiles, AFullDiskLeavesNothing) {
    const SamplePrint print = exact_sample({60, 60, 30});
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
    for (rlim_t limit : {1u << 10, 100u << 10, 1500u << 10}) {
        for (const char* name : {"part.stl", "part.3mf"}) {
            const rlimit small{limit, before.rlim_max};
            ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
            Result<void> done = write(print, name);
            ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
            ASSERT_FALSE(done) << limit << name;
            EXPECT_EQ(done.error().code, ErrorCode::kOutside);
            EXPECT_THAT(done.error().text(), HasSubstr("File too large"));
            EXPECT_THAT(files(), UnorderedElementsAre()) << limit << name;
        }
    }
    std::signal(SIGXFSZ, ignored);
    EXPECT_TRUE(write(print, "part.3mf"));
}

}  // namespace
}  // namespace openfab::testing
