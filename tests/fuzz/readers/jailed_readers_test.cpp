// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Damaged files through the jails (base/jail.h): what comes out is what the reader in this process makes of the same bytes.
// OPENFAB_LONG: 10,000 of them.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "mesh/load/load_beams.h"
#include "mesh/load/load_mesh.h"
#include "mesh/read/beams_npz.h"
#include "mesh/read/beams_text.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/fuzz/readers/readers.h"
#include "tests/support/long_run.h"
#include "tests/support/meshes/temp_folder.h"

namespace openfab::testing {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> corpus_of(const std::string& name) {
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator("tests/fuzz/corpus/" + name))
        files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<std::string> out;
    for (const fs::path& file : files) {
        std::ifstream in(file, std::ios::binary);
        out.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    return out;
}

void expect_same(const mesh::LoadedMesh& a, const mesh::LoadedMesh& b, const std::string& what) {
    EXPECT_TRUE(a.mesh.positions == b.mesh.positions) << what;
    EXPECT_TRUE(a.mesh.triangles == b.mesh.triangles) << what;
    ASSERT_EQ(a.mesh.attributes.size(), b.mesh.attributes.size()) << what;
    for (size_t i = 0; i < a.mesh.attributes.size(); ++i) {
        const mesh::MeshAttribute &x = a.mesh.attributes[i], &y = b.mesh.attributes[i];
        EXPECT_TRUE(x.name == y.name && x.is_int == y.is_int && x.components == y.components &&
                    x.values == y.values && x.corners == y.corners && x.faces == y.faces)
            << what << ": " << x.name;
    }
    EXPECT_EQ(a.warnings, b.warnings) << what;
    EXPECT_EQ(a.groups, b.groups) << what;
    EXPECT_EQ(a.look_of, b.look_of) << what;
    EXPECT_EQ(a.body, b.body) << what;
    EXPECT_EQ(a.left_out.size(), b.left_out.size()) << what;
    EXPECT_EQ(a.files, b.files) << what;
}

int64_t children_started() {
    rusage used{};
    ::getrusage(RUSAGE_CHILDREN, &used);
    return used.ru_minflt;
}

class JailedReaders : public ::testing::TestWithParam<const char*> {
  protected:
    /// Reads the same bytes both ways; returns whether they were whole.
    bool compare(const std::string& bytes, const std::string& what) {
        const fs::path file = folder_.path() / (std::string("a.") + GetParam());
        std::ofstream(file, std::ios::binary) << bytes;
        const std::string name = GetParam();
        if (name == "txt" || name == "npz") return compare_beams(bytes, file, what);
        mesh::MeshOptions options;
        options.name = "part";
        const Result<mesh::LoadedMesh> here = mesh::parse_mesh(bytes, file, options);
        const Result<mesh::LoadedMesh> jailed = mesh::load_mesh(file, options);
        EXPECT_EQ(here.has_value(), jailed.has_value())
            << what << (jailed ? "" : jailed.error().text());
        if (here && jailed) expect_same(*here, *jailed, what);
        if (!here && !jailed) {
            EXPECT_EQ(here.error().text(), jailed.error().text()) << what;
        }
        return here && jailed;
    }

    bool compare_beams(const std::string& bytes, const fs::path& file, const std::string& what) {
        const mesh::BeamOptions options;
        const bool archive = std::string(GetParam()) == "npz" || bytes.starts_with("PK");
        const Result<mesh::ReadBeams> here =
            archive ? mesh::parse_beams_npz(bytes, file.string(), options.memory_bytes)
                    : mesh::parse_beams(bytes, file, options.memory_bytes);
        const Result<mesh::LoadedBeams> jailed = mesh::load_beams(file, options);
        EXPECT_EQ(here.has_value(), jailed.has_value())
            << what << (jailed ? "" : jailed.error().text());
        if (!here && !jailed) {
            EXPECT_EQ(here.error().text(), jailed.error().text()) << what;
        }
        if (!here || !jailed) return false;
        EXPECT_EQ(here->beams.beams.size(), jailed->beams.beams.size()) << what;
        EXPECT_EQ(here->beams.nodes.size(), jailed->beams.nodes.size()) << what;
        return true;
    }

    const testing::TempFolder folder_;
};

TEST_P(JailedReaders, ReadAsThoseInThisProcess) {
    const std::string name = GetParam();
    const std::vector<std::string> samples = corpus_of(name == "txt" ? "beams" : name);
    ASSERT_FALSE(samples.empty());
    [[maybe_unused]] const int64_t before = children_started();
    size_t whole = 0;
    for (const std::string& sample : samples)
        whole += compare(sample, name) ? 1 : 0;
    EXPECT_GT(whole, 0U);
#ifndef OPENFAB_SANITIZED
    EXPECT_GT(children_started(), before) << "another process had to read";
#endif
    const uint64_t count = long_run() ? 1250 : 20;
    for (uint64_t seed = 1; seed <= count && !HasFailure(); ++seed) {
        std::mt19937_64 random(seed);
        const std::string& sample = samples[random() % samples.size()];
        const bool text = name == "obj" || name == "ply" || name == "gltf" || name == "txt";
        compare(mutate(sample, text, &random), name + ", seed " + std::to_string(seed));
    }
}

INSTANTIATE_TEST_SUITE_P(All, JailedReaders,
                         ::testing::Values("obj", "stl", "ply", "gltf", "glb", "3mf", "txt", "npz"),
                         [](const auto& tested) {
                             const std::string name = tested.param;
                             return name == "3mf" ? "threemf" : name;
                         });

}  // namespace
}  // namespace openfab::testing
