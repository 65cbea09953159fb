// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/readers/readers.h"

#include <cstdlib>

#include "backends/ofr/ofr_reader.h"
#include "base/json.h"
#include "base/result.h"
#include "mesh/check/mesh_check.h"
#include "mesh/load/load_mesh.h"
#include "tests/support/meshes/temp_folder.h"
#include "tools/viewer/print_file.h"
#include "world/printer.h"
#include "world/transforms_file.h"
#include "world/world.h"

namespace openfab::testing {
namespace {

/// Results are values or user errors.
template <typename T>
bool answered(const Result<T>& result) {
    if (result) return true;
    if (result.error().code == ErrorCode::kInternal || result.error().text().empty()) std::abort();
    return false;
}

bool read_mesh(std::string_view bytes, const char* file) {
    mesh::MeshOptions options;
    options.name = "part";
    options.repair = bytes.size() % 2 == 0;
    options.memory_bytes = kReaderBytes;
    const Result<mesh::LoadedMesh> loaded = mesh::parse_mesh(bytes, file, options);
    if (!answered(loaded)) return false;
    if (!mesh::count_edges(loaded->mesh).fine()) std::abort();
    for (const mesh::MeshAttribute& a : loaded->mesh.attributes) {
        const auto values = static_cast<int32_t>(a.values.size()) / a.components;
        for (const auto& corners : a.corners) {
            for (const int32_t corner : corners) {
                if (corner < 0 || corner >= values) std::abort();
            }
        }
    }
    return true;
}

template <const char* file>
bool mesh(std::string_view bytes) {
    return read_mesh(bytes, file);
}

/// A file with these bytes, for readers that open files by name.
std::string written(const char* name, std::string_view bytes) {
    static const testing::TempFolder folder;
    return folder.write(name, bytes).string();
}

bool json(std::string_view bytes) {
    return answered(parse_json(bytes, "a.json", kReaderBytes));
}

bool world(std::string_view bytes) {
    return answered(world::load_world(written("a.fab.json", bytes), {{}, kReaderBytes}));
}

bool printer(std::string_view bytes) {
    return answered(world::load_printer(written("a.printer.json", bytes)));
}

bool transforms(std::string_view bytes) {
    return answered(world::parse_transforms(bytes, "a.txt", 100'000));
}

/// The viewer's reader, in any order. Returns how many slices it read.
int32_t slices_seen(const std::string& file) {
    auto print = viewer::PrintFile::open(file, kReaderBytes);
    if (!answered(print)) return 0;
    viewer::SliceBuffers buffers;
    int32_t good = 0;
    const int32_t begin = (*print)->info().slice_begin;
    for (int32_t z = begin + (*print)->whole_slices() - 1; z >= begin; --z)
        good += answered((*print)->read_slice(z, &buffers)) ? 1 : 0;
    return good;
}

bool ofr(std::string_view bytes) {
    const std::string file = written("a.ofr", bytes);
    const int32_t seen = slices_seen(file);
    (void)answered(ofr::OfrReader::read_totals(file));
    auto reader = ofr::OfrReader::open(file);
    if (!answered(reader)) return false;
    for (;;) {
        const Result<bool> more = (*reader)->next();
        if (!answered(more)) return false;
        if (*more) continue;
        if (seen != (*reader)->whole_slices()) std::abort();
        return true;
    }
}

constexpr char kObj[] = "a.obj", kStl[] = "a.stl", kPly[] = "a.ply", kGltf[] = "a.gltf",
               kGlb[] = "a.glb", kThreemf[] = "a.3mf";

constexpr Reader kReaders[] = {{"obj", true, mesh<kObj>},  {"stl", false, mesh<kStl>},
                               {"ply", true, mesh<kPly>},  {"gltf", true, mesh<kGltf>},
                               {"glb", false, mesh<kGlb>}, {"3mf", false, mesh<kThreemf>},
                               {"json", true, json},       {"world", true, world},
                               {"printer", true, printer}, {"transforms", true, transforms},
                               {"ofr", false, ofr}};

}  // namespace

std::span<const Reader> readers() {
    return kReaders;
}

const Reader* find_reader(std::string_view name) {
    for (const Reader& reader : kReaders) {
        if (reader.name == name) return &reader;
    }
    return nullptr;
}

}  // namespace openfab::testing
