// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/solid_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/input_file.h"
#include "base/own_folder.h"
#include "base/start_program.h"
#include "base/talking_program.h"
#include "client/child.h"
#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

// Voxels of the box, about: finer than those of the search for cuts, which are of the same solid.
constexpr double kVoxels = 4e6, kMostVoxels = 6e7;
constexpr double kFinest_mm = 0.02;

double pitch_for(const Vec3d& size) {
    const double volume =
        std::max(size.x, kFinest_mm) * std::max(size.y, kFinest_mm) * std::max(size.z, kFinest_mm);
    // Of a plate a tenth of its least side, as long as that does not take too many.
    const double plate =
        std::max(std::min({size.x, size.y, size.z}) / 10, std::cbrt(volume / kMostVoxels));
    return std::max(std::min(std::cbrt(volume / kVoxels), plate), kFinest_mm);
}

}  // namespace

Result<SolidMesh> solid_mesh(const std::string& world, const WorldOptions& options,
                             const std::string& object, const Box3d& within, int64_t memory_bytes) {
    const Result<fs::path> programs = program_folder();
    if (!programs) return programs.error();
    const auto folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const fs::path& scratch = (*folder)->path();
    const fs::path made = scratch / "made";
    std::error_code status;
    fs::create_directory(made, status);
    SolidMesh out;
    out.pitch_mm = pitch_for(within.size());
    std::vector<std::string> argv{(*programs / "openfab").string(),
                                  "print",
                                  as_argument(world),
                                  "--only-object=" + object,
                                  "--solid",
                                  "-o",
                                  (made / "solid.stl").string(),
                                  fmt::format("--mesh-pitch={:.6g}mm", out.pitch_mm),
                                  "--support=off",
                                  "--progress=plain"};
    if (!options.memory.empty()) argv.insert(argv.end(), {"--memory", options.memory});
    for (const std::string& one : options.allow)
        argv.push_back(allow_argument(one));
    for (const std::string& one : options.settings)
        argv.push_back("--set=" + one);
    if (const Result<void> done = client::run(argv, scratch / "print.out", scratch / "print.err");
        !done)
        return done.error();
    // A file for each material, of which a solid has one.
    for (fs::directory_iterator file(made, status), end; !status && file != end;
         file.increment(status)) {
        if (file->path().extension() != ".stl") continue;
        mesh::MeshOptions read;
        read.name = object;
        read.unit_mm = 1;
        read.memory_bytes = memory_bytes;
        const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(file->path(), read);
        if (!loaded) return loaded.error();
        const auto first = static_cast<int32_t>(out.positions.size());
        // Other placements of the object lie elsewhere.
        const auto is_within = [&](const Vec3d& p) {
            for (int a = 0; a < 3; ++a)
                if (p[a] < within.lo[a] - 2 * out.pitch_mm ||
                    p[a] > within.hi[a] + 2 * out.pitch_mm)
                    return false;
            return true;
        };
        const std::vector<Vec3d>& positions = loaded->mesh.positions;
        out.positions.insert(out.positions.end(), positions.begin(), positions.end());
        for (const auto& t : loaded->mesh.triangles) {
            const bool all = std::ranges::all_of(
                t, [&](int32_t v) { return is_within(positions[static_cast<size_t>(v)]); });
            if (all) out.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        }
    }
    if (out.triangles.empty())
        return user_error(fmt::format(messages::kNothingToSplit, object, out.pitch_mm));
    // Each placement is closed by itself, unless it touches or holds another one.
    mesh::Mesh all;
    all.positions = out.positions;
    all.triangles = out.triangles;
    if (mesh::count_edges(all).open > 0)
        return user_error(fmt::format(messages::kPlacementsTouch, object),
                          messages::kPlacementsTouchHelp);
    return out;
}

}  // namespace openfab::tools
