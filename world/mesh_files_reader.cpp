// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/mesh_files_reader.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "base/affine.h"
#include "mesh/model/mesh_memory.h"
#include "world/messages.h"
#include "world/unit_reader.h"

namespace openfab::world {

namespace fs = std::filesystem;

void MeshFilesReader::read(const JsonMember& m, const JsonValue& value, const std::string& what,
                           bool repair) {
    const bool of_whole = m.value.find("body") == nullptr;
    const fs::path file = files_.existing(value, "the file of " + what, of_whole);
    if (const std::string other = mesh::other_mesh_format(file); json_.ok() && !other.empty())
        json_.fail(value, fmt::format("{} is `{}`", what, file.filename().string()), other);
    if (json_.ok() && !mesh::is_mesh_file(file)) {
        json_.fail(value, fmt::format(messages::kNoMeshExtension, what, file.filename().string()),
                   fmt::format("supported: {}", mesh::mesh_formats()));
    }
    mesh::MeshOptions options;
    options.name = m.key;
    options.repair = repair;
    if (const JsonMember* p = m.value.find("body")) {
        options.body = json_.string(p->value, "`body` of " + what);
        if (json_.ok() && options.body.empty())
            json_.fail(p->value, fmt::format(messages::kBodyEmpty, what), messages::kBodyEmptyHelp);
    }
    if (const JsonMember* p = m.value.find("origin_mm")) {
        const std::vector<double> at = json_.numbers(p->value, "`origin_mm` of " + what, 3, 1e9);
        options.origin_mm = {at[0], at[1], at[2]};
    }
    if (const JsonMember* p = m.value.find("unit"))
        options.unit_mm = read_unit_mm(p->value, what, &json_);
    if (const JsonMember* p = m.value.find("up")) {
        options.y_up = json_.choice(p->value, "`up` of " + what, {"z", "y"}) == 1;
        if (json_.ok() && mesh::format_says_up(file)) {
            json_.fail(p->value, fmt::format(messages::kGltfIsYUp, what), messages::kLeaveItOut);
        }
    }
    if (const JsonMember* p = m.value.find("groups_attribute")) {
        options.groups_attribute = json_.string(p->value, "`groups_attribute` of " + what);
        const std::string& name = *options.groups_attribute;
        if (json_.ok() && (name.empty() || name == "uv" || name == "n" || name == "color")) {
            json_.fail(p->value, fmt::format(messages::kGroupsAttributeTaken, what, name),
                       messages::kGroupsAttributeTakenHelp);
        }
    }
    if (const JsonMember* p = m.value.find("groups")) {
        options.groups.emplace();
        if (!json_.named_things(p->value, "groups")) return;
        for (const JsonMember& group : p->value.members) {
            (*options.groups)[group.key] =
                json_.integer(group.value, fmt::format("group `{}` of {}", group.key, what),
                              INT32_MIN, INT32_MAX);
        }
    }
    if (!json_.ok()) return;
    mesh_files_.push_back({world_.meshes.size(), file, std::move(options), &value});
    world_.meshes.emplace_back();
}

std::vector<MeshFilesReader::MeshLoad> MeshFilesReader::loads() const {
    std::vector<MeshLoad> out;
    std::map<std::pair<std::string, double>, size_t> known;
    for (size_t i = 0; i < mesh_files_.size(); ++i) {
        const MeshFile& mesh = mesh_files_[i];
        const bool of_bodies = !mesh.options.body.empty();
        const auto [it, fresh] =
            known.try_emplace({mesh.file.string(), mesh.options.unit_mm.value_or(0)}, out.size());
        if (fresh || !of_bodies) {
            std::error_code unknown;
            out.push_back({{}, fs::file_size(mesh.file, unknown)});
            out.back().meshes.push_back(i);
            // The whole of a file stands alone.
            if (fresh && !of_bodies) known.erase(it);
        } else {
            out[it->second].meshes.push_back(i);
        }
    }
    return out;
}

int64_t MeshFilesReader::load(int64_t memory_bytes) {
    if (!json_.ok() || mesh_files_.empty()) return 0;
    std::vector<std::optional<Result<mesh::LoadedMesh>>> loaded(mesh_files_.size());
    const std::vector<MeshLoad> loads = this->loads();
    // The largest first, for load balance.
    std::vector<std::pair<uintmax_t, size_t>> order;
    for (size_t i = 0; i < loads.size(); ++i)
        order.emplace_back(loads[i].file_bytes, i);
    std::sort(order.rbegin(), order.rend());
    std::atomic<size_t> next{0};
    std::atomic<int64_t> kept{0};
    const auto load = [&](const MeshLoad& one, int64_t share_bytes) {
        std::vector<mesh::MeshOptions> options;
        for (const size_t i : one.meshes) {
            options.push_back(mesh_files_[i].options);
            options.back().memory_bytes = share_bytes;
        }
        std::vector<Result<mesh::LoadedMesh>> meshes =
            mesh::load_meshes(mesh_files_[one.meshes[0]].file, options);
        for (size_t k = 0; k < meshes.size(); ++k) {
            if (meshes[k]) kept += mesh::mesh_bytes(mesh::counts_of(meshes[k]->mesh));
            loaded[one.meshes[k]].emplace(std::move(meshes[k]));
        }
    };
    // Each gets its share of half of the remaining memory. Files that do not fit are read
    // alone.
    constexpr int kMostAtOnce = 16;
    const auto shares = static_cast<int64_t>(std::min<size_t>(loads.size(), kMostAtOnce));
    const int64_t half = memory_bytes / 2;
    if (shares > 1) {
        tbb::task_arena arena(std::min(tbb::this_task_arena::max_concurrency(), kMostAtOnce));
        arena.execute([&] {
            tbb::parallel_for(size_t{0}, loads.size(), [&](size_t) {
                const size_t i = order[next++].second;
                if (kept < half) load(loads[i], half / shares);
            });
        });
    }
    for (const MeshLoad& one : loads) {
        const bool whole = std::all_of(one.meshes.begin(), one.meshes.end(), [&](size_t i) {
            return loaded[i].has_value() && *loaded[i];
        });
        if (whole) continue;
        for (const size_t i : one.meshes) {
            if (loaded[i] && *loaded[i])
                kept -= mesh::mesh_bytes(mesh::counts_of((*loaded[i])->mesh));
        }
        load(one, memory_bytes - kept);
    }
    for (size_t i = 0; i < loaded.size(); ++i) {
        Result<mesh::LoadedMesh>& mesh = *loaded[i];
        if (!mesh) {
            json_.fail_with(mesh.error());
            return 0;
        }
        for (const fs::path& other : mesh->files)
            files_.also(*mesh_files_[i].value, other);
        for (std::string& warning : mesh->warnings)
            if (std::ranges::count(mesh->of_size, warning) == 0)
                world_.warnings.push_back(std::move(warning));
        if (!mesh->of_size.empty())
            of_size_.emplace_back(mesh_files_[i].index, std::move(mesh->of_size));
        world_.meshes[mesh_files_[i].index] = std::move(mesh->mesh);
    }
    return kept;
}

void MeshFilesReader::warn_of_sizes() {
    constexpr double kLeast_mm = 1, kMost_mm = 1000, kScaled = 1e-6;
    for (auto& [mesh, warnings] : of_size_) {
        Box3d box;
        for (const Vec3d& p : world_.meshes[mesh].positions)
            box.add(p);
        const Vec3d size = box.size();
        const double largest = std::max({size.x, size.y, size.z});
        bool built = false, settled = true;
        for (const Placement& placed : world_.build) {
            if (world_.objects[static_cast<size_t>(placed.object)].mesh !=
                static_cast<int32_t>(mesh))
                continue;
            built = true;
            const double scale = std::cbrt(std::abs(determinant(placed.transform)));
            settled = settled && std::abs(scale - 1) > kScaled && scale * largest >= kLeast_mm &&
                      scale * largest <= kMost_mm;
        }
        if (built && settled) continue;
        for (std::string& warning : warnings)
            world_.warnings.push_back(std::move(warning));
    }
}

}  // namespace openfab::world
