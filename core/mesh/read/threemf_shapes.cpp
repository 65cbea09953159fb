// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_shapes.h"

#include <fmt/format.h>

#include <utility>

#include "mesh/read/messages.h"

namespace openfab::mesh {

Result<ReadThreemfShapes> parse_threemf_shapes(std::string_view bytes, const std::string& file,
                                               int64_t memory_bytes) {
    Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    ThreemfTold told;
    ThreemfBuild build(std::move(*zip), file, &memory_bytes, &told);
    const Result<const ThreemfModel*> root = build.root();
    if (!root) return root.error();
    ReadThreemfShapes out;
    out.root = *root;
    const auto take = [&](const ThreemfPlaced& one) -> Result<void> {
        const ThreemfObject& object = *one.object;
        if (object.level_set != nullptr && object.type != "model") {
            told.add(fmt::format(messages::kLevelSetsOfType, object.type.substr(0, 40)),
                     one.place(), messages::kObjectTypeHelp);
            return {};
        }
        if (object.level_set != nullptr || object.volume >= 0 || object.displaced != nullptr) {
            memory_bytes -= static_cast<int64_t>(3 * (sizeof one + one.name.size()));
            if (memory_bytes < 0)
                return user_error(fmt::format(messages::kLevelSetsTakeTooMuch, file),
                                  messages::kAllowMoreMemory);
        }
        if (object.level_set != nullptr) out.level_sets.push_back(one);
        const bool has_mesh = !object.triangles.empty() && object.type == "model";
        out.has_meshes |= has_mesh;
        if (has_mesh && (object.volume >= 0 || object.displaced != nullptr))
            out.meshes.push_back(one);
        return {};
    };
    if (Result<void> placed = build.each(take); !placed) return placed.error();
    out.parts = build.take_parts();
    out.left_out = std::move(told.list());
    return out;
}

}  // namespace openfab::mesh
