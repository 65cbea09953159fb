// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A bush that grows by a rule in C++, and the same as a list of beams, for tests of what grows.

#include <HalideRuntime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include "abi/grow_table.h"
#include "mesh/model/primitives.h"
#include "runtime/part/bind_beams.h"
#include "runtime/part/part_mesh.h"
#include "runtime/part/shape_stage.h"
#include "runtime/solid/beams/beam_solid.h"
#include "runtime/solid/grow/grow_solid.h"
#include "runtime/solid/grow/grown.h"
#include "runtime/solid/kinds/kinds.h"
#include "tests/unit/solid/covered.h"

namespace openfab::solid {

inline const openfab_varying kInputs[] = {{"heat", "float", OPENFAB_FLOAT, 1, -1, nullptr},
                                          {"kind", "int", OPENFAB_INT, 1, -1, nullptr}};
inline const openfab_varying kMembers[] = {{"end", "float3[2]", OPENFAB_FLOAT, 6, -1, nullptr},
                                           {"radius", "float[2]", OPENFAB_FLOAT, 2, -1, nullptr},
                                           {"children", "int", OPENFAB_INT, 1, -1, nullptr},
                                           {"reach", "float", OPENFAB_FLOAT, 1, -1, nullptr},
                                           {"heat", "float[2]", OPENFAB_FLOAT, 2, -1, nullptr},
                                           {"kind", "int", OPENFAB_INT, 1, -1, nullptr}};
constexpr int32_t kComponents = 13;

struct Node {
    float end[6] = {}, radius[2] = {};
    int32_t children = 0;
    float reach = 0, heat[2] = {};
    int32_t kind = 0;
};
static_assert(sizeof(Node) == 4 * kComponents);

inline float chance(uint32_t path, uint32_t salt) {
    uint32_t x = (path ^ salt * 0x9e3779b9u) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    return static_cast<float>(x >> 8) * 0x1p-24f;
}

using Rule = Node (*)(const Node& parent, int32_t child, int32_t level, uint32_t path);

/// A bush of two to four children to a node, about 5,000 beams.
inline Node bush(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n;
    const float size = 6 * std::pow(0.62f, static_cast<float>(level));
    for (int a = 0; a < 3; ++a) {
        n.end[a] = level == 0 ? 0 : parent.end[3 + a];
        n.end[3 + a] =
            n.end[a] + size * (chance(path, static_cast<uint32_t>(a)) - (a < 2 ? 0.5f : 0));
    }
    n.radius[0] = level == 0 ? 0.9f : parent.radius[1];
    n.radius[1] = n.radius[0] * 0.7f;
    n.children = level == 7 ? 0 : 2 + static_cast<int32_t>(3 * chance(path, 9));
    n.reach = 1.3f * size * 0.62f / 0.38f + 0.1f;
    n.heat[0] = static_cast<float>(level);
    n.heat[1] = static_cast<float>(level + 1);
    n.kind = 100 * level + child;
    return n;
}

/// Counts calls of rules.
inline std::atomic<int64_t> nodes_made = 0;

/// Runs a rule as a kernel: 13 components of the parent, child, level, path; 13 of the node.
template <Rule kRule>
int kernel(void** args) {
    const auto bits = [&](int32_t arg) {
        return reinterpret_cast<uint32_t*>(static_cast<halide_buffer_t*>(args[arg])->host);
    };
    const int32_t n = static_cast<halide_buffer_t*>(args[0])->dim[0].extent;
    nodes_made += n;
    for (int32_t i = 0; i < n; ++i) {
        std::array<uint32_t, kComponents> parent;
        for (int32_t c = 0; c < kComponents; ++c)
            parent[static_cast<size_t>(c)] = bits(c)[i];
        const auto node = std::bit_cast<std::array<uint32_t, kComponents>>(
            kRule(std::bit_cast<Node>(parent), static_cast<int32_t>(bits(kComponents)[i]),
                  static_cast<int32_t>(bits(kComponents + 1)[i]), bits(kComponents + 2)[i]));
        for (int32_t c = 0; c < kComponents; ++c)
            bits(kComponents + 3 + c)[i] = node[static_cast<size_t>(c)];
    }
    return 0;
}

inline std::vector<openfab_arg> arguments() {
    std::vector<openfab_arg> out;
    const auto add_members = [&](int32_t kind) {
        for (int32_t m = 0; m < 6; ++m) {
            for (int32_t k = 0; k < kMembers[m].components; ++k)
                out.push_back({static_cast<openfab_arg_kind>(kind), kMembers[m].scalar, m, k});
        }
    };
    add_members(OPENFAB_ARG_GROW_PARENT);
    for (const int32_t place : {OPENFAB_GROW_CHILD, OPENFAB_GROW_LEVEL, OPENFAB_GROW_PATH})
        out.push_back({static_cast<openfab_arg_kind>(OPENFAB_ARG_GROW_PLACE),
                       place == OPENFAB_GROW_PATH ? OPENFAB_UINT : OPENFAB_INT, place, 0});
    add_members(OPENFAB_ARG_SHAPE_OUT);
    return out;
}

/// Appends what grows of a node, and its ends' heats and kinds.
struct Grove {
    struct Beam {
        GrownBeam beam;
        Node node;
    };
    std::vector<Beam> all;

    void add(Rule rule, const Node& parent, int32_t child, int32_t level, uint64_t parent_id) {
        const uint64_t id = child_id(parent_id, child);
        const Node n = rule(parent, child, level, static_cast<uint32_t>(id));
        if (n.radius[0] > 0 || n.radius[1] > 0) {
            Beam b;
            b.node = n;
            b.beam.end = {Vec3f{n.end[0], n.end[1], n.end[2]}, Vec3f{n.end[3], n.end[4], n.end[5]}};
            b.beam.radius = {n.radius[0], n.radius[1]};
            b.beam.id = id;
            b.beam.level = level;
            all.push_back(b);
        }
        for (int32_t c = 0; c < n.children; ++c)
            add(rule, n, c, level + 1, id);
    }
    mesh::Beams beams() {
        std::ranges::sort(
            all, [](const Beam& a, const Beam& b) { return grows_before(a.beam, b.beam); });
        mesh::Beams out;
        out.attributes = {{"heat", false, 1, {}, {}}, {"kind", true, 1, {}, {}}};
        for (const Beam& b : all) {
            const auto node = static_cast<int32_t>(out.nodes.size());
            out.beams.push_back({{node, node + 1}, b.beam.radius});
            for (size_t e = 0; e < 2; ++e) {
                out.nodes.push_back(vec_cast<double>(b.beam.end[e]));
                out.attributes[0].values.push_back(b.node.heat[e]);
            }
            out.attributes[1].ints.push_back(b.node.kind);
        }
        return out;
    }
};

/// A part, turned unless said, that grows, or of beams, in a grid; to be asked for distances unless said.
struct Made {
    std::vector<openfab_arg> args = arguments();
    openfab_shape shape{};
    openfab_fablet fablet{};
    part::Part part;
    std::shared_ptr<Solid> solid;
    part::Grid grid;
    std::array<float, OPENFAB_FRAME_COUNT> frame{};
    std::unique_ptr<Placed> placed;
    std::unique_ptr<Scratch> scratch;
    Result<void> status;

    Made(Rule rule, openfab_kernel_fn fn, size_t cache,
         const std::shared_ptr<const mesh::Beams>& beams,
         const Box3d& box = {{-12, -12, -3}, {12, 12, 20}}, bool turned = true, bool asked = true) {
        shape.output_count = 6;
        shape.outputs = kMembers;
        shape.attributes = {{fn, fn, fn}, static_cast<int32_t>(args.size()), args.data(), 0};
        fablet.abi_version = OPENFAB_ABI_VERSION;
        fablet.name = "Bush";
        fablet.nearest_count = 2;
        fablet.nearest = kInputs;
        fablet.shape = &shape;
        (void)rule;
        mesh::Mesh mesh = mesh::make_box(box.size());
        for (Vec3d& p : mesh.positions)
            p = p + box.lo + Vec3d{box.size().x / 2, box.size().y / 2, 0};
        mesh.attributes = mesh::box_mesh("box", with_attributes()).attributes;
        const std::array<double, 9> s{1, 0, 0, 0, 1, 0, 0, 0, 1};
        part.name = "bush";
        part.fablet = &fablet;
        part.mesh = *part::make_part_mesh(mesh, fablet, s);
        if (beams != nullptr) {
            part.geometry = part::BeamGeometry{part::make_part_beams(beams, fablet, s, *part.mesh)};
        } else {
            auto stage = std::make_shared<part::ShapeStage>();
            stage->name = part.name;
            stage->fablet = part.fablet;
            stage->mesh = part.mesh;
            stage->location = {"world.fab.json", 7, 3};
            part.geometry = part::GrownGeometry{stage, nullptr};
        }
        if (turned)
            part.local_to_build.m = {0.40923325984932796, -0.9119847905251406, 0.02849352354321616,
                                     0.708653140405184,   0.2980114870440326,  -0.6395309845376336,
                                     0.5747511336456527,  0.28190937451709513, 0.76823709812298};
        EXPECT_EQ(&kind_of(part), beams != nullptr ? &kBeamKind : &kGrowKind);
        surface::SurfaceOptions options;
        options.cache_bytes = cache;
        Result<std::shared_ptr<Solid>> made = kind_of(part).make(part, options, {});
        if (!made) {
            status = made.error();
            return;
        }
        solid = *made;
        grid.pitch_mm = {0.2, 0.26, 0.16};
        grid.origin_mm = {-8, -8, -8};
        grid.size = {96, 71, 120};
        frame = part::make_frame(part, grid);
        if (asked) solid->prepare({.nearest = true, .attributes = true, .sign = true}, {});
        placed = solid->place({part, grid, frame});
        if (!asked) return;
        placed->begin_queries();
        scratch = placed->make_scratch();
    }
    Made(const Made&) = delete;
    Made& operator=(const Made&) = delete;

    static mesh::Beams with_attributes() {
        mesh::Beams out;
        out.attributes = {{"heat", false, 1, {0, 0}, {}}, {"kind", true, 1, {}, {0}}};
        out.nodes = {{0, 0, 0}, {1, 1, 1}};
        out.beams = {{{0, 1}, {1, 1}}};
        return out;
    }
    std::vector<uint8_t> covered() const { return solid::covered(*placed, grid); }
};

inline std::shared_ptr<const mesh::Beams> all_of(Rule rule) {
    Grove grove;
    grove.add(rule, {}, 0, 0, 0);
    return std::make_shared<const mesh::Beams>(grove.beams());
}

constexpr size_t kLittle = 1, kMuch = 64 << 20;

}  // namespace openfab::solid
