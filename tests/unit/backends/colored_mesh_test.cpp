// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// 3MF files whose faces have the colours of mixtures, and those whose touching voxels are moved apart, read back number by number.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <regex>

#include "backends/boundary/color_table.h"
#include "backends/boundary/colored_sink.h"
#include "backends/boundary/mesh_sink.h"
#include "mesh/load/load_mesh.h"
#include "mesh/read/zip_file.h"
#include "tests/support/process/process.h"
#include "tests/unit/backends/sample_print.h"

namespace openfab::testing {
namespace {

using Corners = std::array<Vec3d, 3>;

struct ReadObject {
    std::string name;
    std::vector<Corners> triangles;
    std::vector<std::string> colors;  ///< by triangle; none where the file has none
};

std::vector<std::string> all_of(const std::string& text, const char* pattern) {
    const std::regex expression(pattern);
    std::vector<std::string> found;
    for (std::sregex_iterator i(text.begin(), text.end(), expression), end; i != end; ++i)
        found.push_back((*i)[1]);
    return found;
}

double number(const std::string& text, const std::string& key) {
    const size_t at = text.find(key + "=\"");
    return std::stod(text.substr(at + key.size() + 2));
}

std::vector<ReadObject> read_objects(const std::string& file) {
    const std::string bytes = read_file(file);  // which the archive's reader looks into
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, "part.3mf");
    EXPECT_TRUE(zip);
    const Result<std::string> model = zip->read("3D/3dmodel.model");
    EXPECT_TRUE(model);
    const std::vector<std::string> colors = all_of(*model, "<m:color color=\"(#[0-9A-F]{8})\"/>");
    std::vector<ReadObject> objects;
    for (size_t at = model->find("<object "); at != std::string::npos;
         at = model->find("<object ", at + 1)) {
        const std::string text = model->substr(at, model->find("</object>", at) - at);
        if (text.find("<mesh>") == std::string::npos) continue;
        ReadObject& object = objects.emplace_back();
        object.name = all_of(text, "name=\"([^\"]*)\"").front();
        std::vector<Vec3d> points;
        for (const std::string& v : all_of(text, "<vertex ([^/]*)/>"))
            points.push_back({number(v, "x"), number(v, "y"), number(v, "z")});
        for (const std::string& t : all_of(text, "<triangle ([^/]*)/>")) {
            Corners& corners = object.triangles.emplace_back();
            for (size_t i = 0; i < 3; ++i)
                corners[i] = points.at(static_cast<size_t>(number(t, fmt::format("v{}", i + 1))));
            if (t.find("p1=") != std::string::npos)
                object.colors.push_back(colors.at(static_cast<size_t>(number(t, "p1"))));
        }
    }
    return objects;
}

double volume_of(const std::vector<Corners>& triangles) {
    double six = 0;
    for (const Corners& t : triangles)
        six += dot(t[0], cross(t[1], t[2]));
    return six / 6;
}

/// How many edges do not lie between two triangles, by positions.
int64_t open_edges(const std::vector<Corners>& triangles) {
    std::map<std::array<double, 6>, std::pair<int, int>> edges;
    for (const Corners& t : triangles) {
        for (size_t i = 0; i < 3; ++i) {
            const Vec3d &a = t[i], &b = t[(i + 1) % 3];
            const std::array<double, 3> p{a.x, a.y, a.z}, q{b.x, b.y, b.z};
            const bool rising = p < q;
            const auto& lo = rising ? p : q;
            const auto& hi = rising ? q : p;
            auto& [up, down] = edges[{lo[0], lo[1], lo[2], hi[0], hi[1], hi[2]}];
            ++(rising ? up : down);
        }
    }
    return std::count_if(edges.begin(), edges.end(), [](const auto& edge) {
        return edge.second != std::pair<int, int>{1, 1};
    });
}

/// The light of a mixture by the formula itself: each material's to the power of its share.
std::array<int, 3> expected_color(const std::vector<pipeline::SliceMaterial>& materials,
                                  const std::vector<float>& fractions) {
    double sum = 0;
    for (const float f : fractions)
        sum += f;
    std::array<int, 3> out{};
    for (size_t c = 0; c < 3; ++c) {
        double log_light = 0;
        for (size_t m = 0; m < fractions.size(); ++m) {
            const double s = materials[m].preview[c] / 255.0;
            const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
            log_light += fractions[m] / sum * std::log10(std::max(linear, std::pow(10, -1.2)));
        }
        const double light = std::pow(10, log_light);
        out[c] = static_cast<int>(std::lround(
            255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055)));
    }
    return out;
}

std::vector<pipeline::SliceMaterial> inks() {
    const auto ink = [](const char* name, std::array<uint8_t, 4> preview) {
        pipeline::SliceMaterial m;
        m.name = name;
        m.key = m.preview = preview;
        return m;
    };
    return {ink("cyan", {0x00, 0x95, 0xe7, 0xff}), ink("yellow", {0xff, 0xe7, 0x00, 0xff}),
            ink("white", {0xf4, 0xf2, 0xec, 0xff}), ink("clear", {0xff, 0xff, 0xff, 0x20})};
}

TEST(ColorsOfMixtures, AreProductsOfLight) {
    const boundary::MixtureColors colors(inks());
    EXPECT_EQ(colors.of(std::vector<float>{0, 1, 0, 0}), 0xffe700ffu);
    EXPECT_EQ(colors.of(std::vector<float>{0, 0.25f, 0, 0}), 0xffe700ffu) << "void does not count";
    EXPECT_EQ(colors.of(std::vector<float>{0, 0, 0, 0}), 0u);
    EXPECT_EQ(colors.of(std::vector<float>{0, 0, 0.5f, 0.5f}) & 255, 0x90u);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> amount(0, 1);
    for (int i = 0; i < 2000; ++i) {
        std::vector<float> mixture{amount(random), amount(random), amount(random)};
        const boundary::Rgba color = colors.of(mixture);
        const std::array<int, 3> expected = expected_color(inks(), mixture);
        for (size_t c = 0; c < 3; ++c)  // shares are rounded to 16 bits
            EXPECT_NEAR(static_cast<int>(color >> (24 - 8 * c) & 255), expected[c], 1);
    }
}

TEST(ColorsOfMixtures, OfAFileAreSoManyAtMost) {
    boundary::ColorTable table;
    std::mt19937 random(7);
    for (int i = 0; i < 400000; ++i) {
        const auto color = static_cast<boundary::Rgba>(random());
        const boundary::Rgba given = table.colors()[table.number(color)];
        for (int shift : {24, 16, 8})
            ASSERT_LE(std::abs(static_cast<int>(given >> shift & 255) -
                               static_cast<int>(color >> shift & 255)),
                      5);
    }
    EXPECT_LE(table.colors().size(), boundary::ColorTable::kMostExact + (1u << 17));
}

/// A print of which each voxel has a mixture of its own, or one of a few.
struct MixedPrint {
    SamplePrint print;
    std::vector<std::vector<float>> mixtures;  ///< by voxel

    explicit MixedPrint(int32_t kinds) : print(make_sample({11, 6, 9})) {
        print.info.pitch_mm = {0.125, 0.25, 0.5};
        print.info.origin_mm = {-3.5, 2.25, 0};
        print.info.materials = inks();
        print.info.support_code = 0;
        std::mt19937 random(3);
        std::uniform_real_distribution<float> amount(0, 1);
        std::vector<std::vector<float>> kind(static_cast<size_t>(kinds));
        for (auto& k : kind) {
            k = {amount(random), amount(random), amount(random), 0};
            if (random() % 4 == 0) k = {0.1f, 0, 0, 0.9f};
        }
        for (uint8_t& code : print.codes) {
            code = random() % 3 == 0 ? 0 : 1;
            mixtures.push_back(kind[random() % kind.size()]);
        }
    }
    Result<void> write(const std::string& path) {
        backends::MixtureInlet inlet(nullptr);
        boundary::ColoredSink sink(path, &inlet);
        Result<void> done = sink.begin(print.info);
        if (done) done = inlet.begin(print.info, 4);
        const Vec3i& size = print.info.size;
        for (int32_t z = print.info.slice_begin; z < print.info.slice_end && done; ++z) {
            for (int32_t y = 0; y < size.y; ++y) {
                std::vector<float> row;
                for (int32_t x = 0; x < size.x; ++x) {
                    const size_t at = index(x, y, z);
                    for (const float f : mixtures[at])
                        row.push_back(print.codes[at] == 0 ? 0 : f);
                }
                inlet.write(z, y, 0, row);
            }
            const std::vector<uint8_t> rows = print.rows(z);
            done = sink.commit(z, sink.encode(print.view(z, rows)));
        }
        const Result<void> finished = sink.finish(print.totals());
        return done ? finished : done;
    }
    size_t index(int32_t x, int32_t y, int32_t z) const {
        return (static_cast<size_t>(z) * static_cast<size_t>(print.info.size.y) +
                static_cast<size_t>(y)) *
                   static_cast<size_t>(print.info.size.x) +
               static_cast<size_t>(x);
    }
};

TEST(ColoredMeshes, HaveTheColourOfTheVoxelBehindEachTriangle) {
    for (const int32_t kinds : {1, 3, 400}) {
        SCOPED_TRACE(kinds);
        MixedPrint mixed(kinds);
        ScratchFolder scratch;
        ASSERT_TRUE(mixed.write((scratch / "part.3mf").string()));
        std::map<std::string, double> volumes;
        double area = 0;
        for (const ReadObject& object : read_objects((scratch / "part.3mf").string())) {
            volumes[object.name] = volume_of(object.triangles);
            ASSERT_EQ(object.colors.size(), object.triangles.size());
            for (size_t t = 0; t < object.triangles.size(); ++t) {
                const Corners& c = object.triangles[t];
                const Vec3d normal = cross(c[1] - c[0], c[2] - c[0]);
                area += length(normal) / 2;
                const Vec3d inside =
                    (c[0] + c[1] + c[2]) * (1.0 / 3) - normal * (0.01 / length(normal));
                const pipeline::PrintInfo& info = mixed.print.info;
                const Vec3d v = inside - info.origin_mm;
                const size_t at = mixed.index(static_cast<int32_t>(v.x / info.pitch_mm.x),
                                              static_cast<int32_t>(v.y / info.pitch_mm.y),
                                              static_cast<int32_t>(v.z / info.pitch_mm.z));
                ASSERT_NE(mixed.print.codes[at], 0);
                const std::array<int, 3> expected =
                    expected_color(info.materials, mixed.mixtures[at]);
                for (size_t k = 0; k < 3; ++k)
                    ASSERT_NEAR(std::stoi(object.colors[t].substr(1 + 2 * k, 2), nullptr, 16),
                                expected[k], 1);
                ASSERT_EQ(object.name == "clear", mixed.mixtures[at][3] > 0.5f);
            }
        }
        std::map<std::string, double> expected;
        for (size_t i = 0; i < mixed.print.codes.size(); ++i) {
            if (mixed.print.codes[i] == 0) continue;
            expected[mixed.mixtures[i][3] > 0.5f ? "clear" : "opaque"] += 0.125 * 0.25 * 0.5;
        }
        for (const auto& [name, volume] : expected)
            EXPECT_NEAR(volumes[name], volume, 1e-9) << name;
        EXPECT_EQ(volumes.size(), expected.size());
        const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(scratch / "part.3mf", {});
        ASSERT_TRUE(loaded) << loaded.error().text();
        EXPECT_TRUE(loaded->checks.edges.fine());
    }
}

TEST(MeshesApart, AreClosedByTheirPositions) {
    SamplePrint print = make_sample({24, 17, 15});
    print.info.pitch_mm = {0.125, 0.25, 0.5};
    print.info.origin_mm = {-3.5, 2.25, 0};
    ScratchFolder scratch;
    std::mt19937 random(11);
    for (uint8_t& code : print.codes)
        code = static_cast<uint8_t>(random() % 4);
    boundary::MeshSink together(boundary::make_threemf_writer(scratch / "together.3mf"));
    ASSERT_TRUE(print.send(&together));
    boundary::MeshSink apart(boundary::make_apart_writer(scratch / "apart.3mf"));
    ASSERT_TRUE(print.send(&apart));
    const auto exact = read_objects((scratch / "together.3mf").string());
    const auto moved = read_objects((scratch / "apart.3mf").string());
    ASSERT_EQ(exact.size(), 3u);
    ASSERT_EQ(moved.size(), 3u);
    for (size_t m = 0; m < 3; ++m) {
        EXPECT_GT(open_edges(exact[m].triangles), 100);
        EXPECT_EQ(open_edges(moved[m].triangles), 0);
        // At most a step of 1/512 at each of a voxel's sides.
        const double volume = volume_of(exact[m].triangles);
        EXPECT_LT(volume_of(moved[m].triangles), volume);
        EXPECT_GT(volume_of(moved[m].triangles), volume * (1 - 6.0 / 512));
    }
    const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(scratch / "apart.3mf", {});
    ASSERT_TRUE(loaded) << loaded.error().text();
    EXPECT_TRUE(loaded->checks.edges.fine());
}

}  // namespace
}  // namespace openfab::testing
