// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "base/own_folder.h"
#include "base/say.h"
#include "mechanics/command/commands.h"
#include "mechanics/command/part_source.h"
#include "mechanics/exchange/element_mesh.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFormats[] = {".inp", ".vtu", ".msh", ".xdmf"};

/// Voxels, and their mesh with all fields.
int64_t export_bytes(const Grid& grid) {
    constexpr int64_t kMeshOfAnElement = 150, kForcesOfANode = 24;
    return grid.element_count() * (Voxels::bytes_per_voxel() + kMeshOfAnElement) +
           grid.node_count() * kForcesOfANode;
}

}  // namespace

Result<void> run_export(const ExportOptions& o) {
    for (const std::string& file : o.outputs)
        if (std::ranges::find(kFormats, fs::path(file).extension().string()) == std::end(kFormats))
            return usage_error(fmt::format(messages::kMeshKinds, file));
    std::optional<LoadCase> load_case;
    if (!o.load_case.empty()) {
        Result<LoadCase> read = read_load_case(o.common.input, o.load_case);
        if (!read) return read.error();
        if (Result<void> done = check_kind(*read, false); !done) return done;
        load_case = std::move(*read);
    }
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    Result<PartSource> source = PartSource::open(o.common, (*folder)->path());
    if (!source) return source.error();
    source->keep_shares();
    const Result<Vec3> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    Result<PartInput> input = source->read(
        *voxel, load_case ? load_case->objects() : std::vector<std::string>(), export_bytes);
    if (!input) return input.error();
    for (const std::string& one : input->doubts)
        note(one);
    PartProblem problem;
    std::optional<MeshCase> with_case;
    if (load_case) {
        if (Result<void> done = source->check_gravity(*input, *load_case); !done) return done;
        Result<PartProblem> set_up = set_up_part(std::move(input->voxels), *load_case,
                                                 input->objects, {o.loose, o.thin, o.common.codes});
        if (!set_up) return set_up.error();
        problem = std::move(*set_up);
        with_case = MeshCase{load_case->name, &problem};
        for (const std::string& one : problem.notes)
            note(one);
    } else {
        problem.voxels = std::move(input->voxels);
        problem.grid = Grid::make(problem.voxels.size, problem.voxels.pitch_mm, false);
    }
    const ElementMesh mesh = mesh_of(problem.grid, problem.voxels);
    if (mesh.elements.empty()) return user_error(messages::kNothingToMesh);
    for (const std::string& name : o.outputs) {
        const fs::path file = name;
        const std::string type = file.extension().string();
        const Result<void> done = type == ".inp"   ? write_inp(file, mesh, with_case)
                                  : type == ".vtu" ? write_vtu(file, mesh)
                                  : type == ".msh" ? write_msh(file, mesh)
                                                   : write_xdmf(file, mesh);
        if (!done) return done;
        if (type != ".inp" && load_case)
            note(fmt::format(messages::kCaseLeftOut, name, load_case->name));
    }
    show(fmt::format("{} elements, {} nodes, {} sections, {}\n", mesh.elements.size(),
                     mesh.nodes.size(), mesh.sections.size(), source->law()));
    return {};
}

}  // namespace openfab::mechanics
