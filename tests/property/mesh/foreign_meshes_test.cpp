// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Third-party meshes: each loads, or is refused with a reason. Those of the shared data, and of two
// Debian packages where they are installed (assimp-testmodels, many of them malformed on purpose,
// and libcgal-demo).

#include <gtest/gtest.h>

#include <cstdlib>

#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "tests/support/meshes/meshes.h"
#include "tests/support/places/places.h"

namespace openfab::mesh {
namespace {

namespace fs = std::filesystem;

struct Tally {
    int printable = 0;
    int refused = 0;  ///< read, but not printable
    int unread = 0;
};

/// Loads one file and checks that the answer is one of the three, and makes sense.
void look_at(const fs::path& file, Tally* tally) {
    SCOPED_TRACE(file.string());
    MeshOptions options;
    options.name = "part";
    const Result<LoadedMesh> told = read_mesh(file, options);
    // The largest would take most of the time without testing more.
    if (told && told->mesh.triangles.size() > 50'000) return;
    const Result<LoadedMesh> loaded = load_mesh(file, options);
    EXPECT_EQ(loaded.has_value(), told.has_value() && told->refusal.empty());
    if (!told) {
        ++tally->unread;
        EXPECT_EQ(told.error().code, ErrorCode::kUserInput);
        EXPECT_NE(told.error().text().find(file.filename().string()), std::string::npos)
            << told.error().text();
        return;
    }
    if (!loaded) {
        ++tally->refused;
        EXPECT_NE(loaded.error().text().find("mesh `part`"), std::string::npos);
        EXPECT_EQ(told->refusal, loaded.error().text());
        return;
    }
    ++tally->printable;
    EXPECT_TRUE(count_edges(loaded->mesh).fine());
    EXPECT_GT(testing::signed_volume(loaded->mesh), 0);
}

std::vector<fs::path> meshes_below(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (fs::recursive_directory_iterator entry(folder, ignored), end; !ignored && entry != end;
         entry.increment(ignored)) {
        if (entry->is_regular_file(ignored) && is_mesh_file(entry->path()))
            files.push_back(entry->path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

TEST(ForeignMeshes, OfTheRepository) {
    const fs::path data = testing::source_dir() / "tests/data";
    Tally whole;
    for (const fs::path& file : meshes_below(data / "meshes"))
        look_at(file, &whole);
    EXPECT_EQ(whole.printable, 4);
    EXPECT_EQ(whole.refused + whole.unread, 0);
    Tally broken;
    for (const fs::path& file : meshes_below(data / "broken_meshes"))
        look_at(file, &broken);
    EXPECT_EQ(broken.refused, 5);
    EXPECT_EQ(broken.printable + broken.unread, 0);
}

// A manual test: checks every mesh below the folder OPENFAB_MESHES.
TEST(ForeignMeshes, OfAFolderThatIsNamed) {
    const char* named = std::getenv("OPENFAB_MESHES");
    if (named == nullptr) return;
    Tally tally;
    for (const fs::path& file : meshes_below(named))
        look_at(file, &tally);
    printf("%d printable, %d refused, %d unread\n", tally.printable, tally.refused, tally.unread);
    EXPECT_GT(tally.printable + tally.refused + tally.unread, 0);
}

}  // namespace
}  // namespace openfab::mesh
