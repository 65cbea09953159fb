// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/beams_reader.h"

namespace openfab::world {

int64_t add_beams(const std::filesystem::path& file, const mesh::BeamOptions& options,
                  const std::string& name, JsonReader* json, World* world) {
    Result<mesh::LoadedBeams> loaded = mesh::load_beams(file, options);
    if (!loaded) {
        json->fail_with(loaded.error());
        return 0;
    }
    for (std::string& warning : loaded->warnings)
        world->warnings.push_back(std::move(warning));
    const auto index = static_cast<int32_t>(world->meshes.size());
    const auto beams = std::make_shared<const mesh::Beams>(std::move(loaded->beams));
    world->boxed[index] = beams;
    world->meshes.push_back(mesh::box_mesh(name, *beams));
    return mesh::beam_bytes(*beams);
}

}  // namespace openfab::world
