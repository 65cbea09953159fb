// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/readers/geometry_readers.h"

#include <algorithm>

#include "mesh/read/beams_npz.h"
#include "mesh/read/beams_text.h"
#include "mesh/read/threemf_beams.h"
#include "mesh/read/threemf_shapes.h"
#include "runtime/solid/grow/program_answer.h"
#include "tests/fuzz/readers/readers.h"
#include "tools/fields/fablet_text.h"

namespace openfab::testing {

namespace {

/// Of beams nodes exist, and radii make an inside.
bool fine_beams(const Result<mesh::ReadBeams>& read) {
    if (!answered(read)) return false;
    const mesh::Beams& beams = read->beams;
    const auto nodes = static_cast<int32_t>(beams.nodes.size());
    for (const mesh::Beam& beam : beams.beams) {
        if (std::min(beam.nodes[0], beam.nodes[1]) < 0 ||
            std::max(beam.nodes[0], beam.nodes[1]) >= nodes ||
            !(std::max(beam.radii[0], beam.radii[1]) > 0) ||
            !(std::min(beam.radii[0], beam.radii[1]) >= 0))
            std::abort();
    }
    for (const mesh::BeamAttribute& a : beams.attributes) {
        const auto components = static_cast<size_t>(a.components);
        if (a.is_int ? a.ints.size() != beams.beams.size() * components
                     : a.values.size() != beams.nodes.size() * components)
            std::abort();
    }
    return !beams.beams.empty();
}

}  // namespace

bool beams(std::string_view bytes) {
    return fine_beams(mesh::parse_beams(bytes, "a.txt", kReaderBytes));
}
bool beams_npz(std::string_view bytes) {
    return fine_beams(mesh::parse_beams_npz(bytes, "a.npz", kReaderBytes));
}
bool lattices(std::string_view bytes) {
    return fine_beams(mesh::parse_threemf_beams(bytes, "a.3mf", "", kReaderBytes));
}

/// What it gives, it has counted.
bool answer(std::string_view bytes) {
    const Result<solid::ProgramAnswer> read =
        solid::read_program_answer(bytes, {.floats = 1, .ints = 1, .places = {"leaf"}});
    if (!read) {
        if (read.error().code != ErrorCode::kUserInput) std::abort();
        return false;
    }
    if (read->floats.size() != 2 * read->items.size() || read->ints.size() != read->items.size())
        std::abort();
    for (const mesh::Mesh& mesh : read->meshes) {
        for (const auto& triangle : mesh.triangles) {
            for (const int32_t v : triangle) {
                if (v < 0 || static_cast<size_t>(v) >= mesh.positions.size()) std::abort();
            }
        }
    }
    return !read->items.empty();
}

/// Functions are translated, too.
bool fields(std::string_view bytes) {
    const Result<mesh::ReadThreemfShapes> read =
        mesh::parse_threemf_shapes(bytes, "a.3mf", kReaderBytes);
    if (!answered(read)) return false;
    bool any = false;
    for (const mesh::ThreemfPlaced& one : read->level_sets)
        any = answered(tools::level_set_fablet(one, {}, "a.3mf", "A")) || any;
    for (const mesh::ThreemfPlaced& one : read->meshes)
        any = answered(tools::mesh_fablet(one, {}, "a.3mf", "A")) || any;
    return any;
}

}  // namespace openfab::testing
