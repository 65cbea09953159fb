// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// What grows by a rule against the same rule run to its end into a list of beams: the same bits everywhere, however
// little is kept; and what a rule may not do.

#include "runtime/solid/grow/grow_solid.h"

#include <HalideRuntime.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>

#include "abi/grow_table.h"
#include "mesh/model/primitives.h"
#include "runtime/part/bind_beams.h"
#include "runtime/part/part_mesh.h"
#include "runtime/solid/beams/beam_solid.h"
#include "runtime/solid/grow/grown.h"
#include "runtime/solid/grow/rule_source.h"
#include "runtime/solid/kinds/kinds.h"

namespace openfab::solid {
namespace {

const openfab_varying kInputs[] = {{"heat", "float", OPENFAB_FLOAT, 1, -1, nullptr},
                                   {"kind", "int", OPENFAB_INT, 1, -1, nullptr}};
const openfab_varying kMembers[] = {{"end", "float3[2]", OPENFAB_FLOAT, 6, -1, nullptr},
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

float chance(uint32_t path, uint32_t salt) {
    uint32_t x = (path ^ salt * 0x9e3779b9u) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    return static_cast<float>(x >> 8) * 0x1p-24f;
}

using Rule = Node (*)(const Node& parent, int32_t child, int32_t level, uint32_t path);

/// A bush of two to four children to a node, about 5,000 beams.
Node bush(const Node& parent, int32_t child, int32_t level, uint32_t path) {
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

/// Runs a rule as a kernel: 13 components of the parent, child, level, path; 13 of the node.
template <Rule kRule>
int kernel(void** args) {
    const auto bits = [&](int32_t arg) {
        return reinterpret_cast<uint32_t*>(static_cast<halide_buffer_t*>(args[arg])->host);
    };
    const int32_t n = static_cast<halide_buffer_t*>(args[0])->dim[0].extent;
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

std::vector<openfab_arg> arguments() {
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

/// A turned part that grows, or of beams, in a grid.
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
         const Box3d& box = {{-12, -12, -3}, {12, 12, 20}}) {
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
            part.beams = part::make_part_beams(beams, fablet, s, *part.mesh);
        } else {
            auto stage = std::make_shared<part::Part>(part);
            stage->location = {"world.fab.json", 7, 3};
            part.shape = stage;
        }
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
        solid->prepare({.nearest = true, .attributes = true, .sign = true}, {});
        placed = solid->place({part, grid, frame});
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
    std::vector<uint8_t> covered() const {
        std::vector<uint8_t> all(static_cast<size_t>(grid.size.x) * grid.size.y * grid.size.z, 0);
        voxel::SlabMask mask;
        for (int32_t slab = 0; 8 * slab < grid.size.z; ++slab) {
            placed->coverage(slab, &mask, nullptr, nullptr);
            for (int32_t y = 0; y < mask.height; ++y) {
                for (int32_t x = 0; x < mask.width; ++x) {
                    const uint8_t bits = mask.mask[static_cast<size_t>(y) * mask.width + x];
                    const Vec3i at{mask.x0 + x, mask.y0 + y, 8 * slab};
                    if (bits == 0) continue;
                    for (int32_t z = 0; z < 8; ++z) {
                        if ((bits >> z & 1) != 0)
                            all[(static_cast<size_t>(at.z + z) * grid.size.y + at.y) * grid.size.x +
                                at.x] = 1;
                    }
                }
            }
        }
        return all;
    }
};

std::shared_ptr<const mesh::Beams> all_of(Rule rule) {
    Grove grove;
    grove.add(rule, {}, 0, 0, 0);
    return std::make_shared<const mesh::Beams>(grove.beams());
}

constexpr size_t kLittle = 1, kMuch = 64 << 20;

TEST(GrowSolid, CoversWhatItsBeamsCover) {
    const auto beams = all_of(bush);
    ASSERT_GT(beams->beams.size(), 2000u);
    const std::vector<uint8_t> expected = Made(bush, kernel<bush>, 0, beams).covered();
    ASSERT_GT(std::ranges::count(expected, 1), 2000);
    for (const size_t cache : {kLittle, kMuch}) {
        const Made made(bush, kernel<bush>, cache, nullptr);
        EXPECT_TRUE(made.covered() == expected);
        EXPECT_TRUE(made.solid->status());
    }
}

/// Distances and attributes of blocks have the bits of those of all beams.
TEST(GrowSolid, BlocksHaveTheAnswersOfAllBeams) {
    const auto beams = all_of(bush);
    const Made all(bush, kernel<bush>, 0, beams);
    const std::vector<uint8_t> covered = all.covered();
    const Vec3i base = part::part_base_voxel(all.part, all.grid);
    for (const size_t cache : {kLittle, kMuch}) {
        const Made made(bush, kernel<bush>, cache, nullptr);
        int64_t compared = 0;
        for (int32_t z = 0; z + 8 <= all.grid.size.z; z += 8) {
            for (int32_t y = 0; y + 8 <= all.grid.size.y; y += 40) {
                for (int32_t x = 0; x + 8 <= all.grid.size.x; x += 16) {
                    nearest::BlockQuery query;
                    query.block = Vec3i{x, y, z} - base;
                    nearest::BlockAnswer expected, found;
                    all.placed->engine()->query(query, all.scratch->engine.get(), &expected);
                    made.placed->engine()->query(query, made.scratch->engine.get(), &found);
                    std::vector<float> heat(1024), steps(6 * 512);
                    std::vector<uint32_t> kind(1024);
                    for (const bool grown : {false, true}) {
                        float* values[] = {heat.data() + (grown ? 512 : 0)};
                        uint32_t* flat[] = {kind.data() + (grown ? 512 : 0)};
                        float* gradients[3];
                        for (size_t a = 0; a < 3; ++a)
                            gradients[a] = steps.data() + ((grown ? 3 : 0) + a) * 512;
                        const Made& of = grown ? made : all;
                        of.placed->read(grown ? found : expected, nullptr,
                                        {values, gradients, flat}, of.scratch.get());
                    }
                    for (size_t v = 0; v < 512; ++v) {
                        ASSERT_EQ(std::bit_cast<uint32_t>(found.distance2[v]),
                                  std::bit_cast<uint32_t>(expected.distance2[v]));
                        ASSERT_EQ(heat[512 + v], heat[v]);
                        ASSERT_EQ(kind[512 + v], kind[v]);
                        for (size_t a = 0; a < 3; ++a)
                            ASSERT_EQ(steps[(3 + a) * 512 + v], steps[a * 512 + v]);
                        ++compared;
                    }
                }
            }
        }
        EXPECT_GT(compared, 80000);
    }
}

TEST(GrowSolid, PointsHaveTheAnswersOfAllBeams) {
    const auto beams = all_of(bush);
    const Made all(bush, kernel<bush>, 0, beams), made(bush, kernel<bush>, kLittle, nullptr);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> at(-14, 14);
    std::vector<nearest::PointPacket> packets(60);
    for (nearest::PointPacket& packet : packets) {
        for (auto& axis : packet.p)
            for (float& x : axis)
                x = at(random);
    }
    std::vector<nearest::PointAnswer> expected(packets.size()), found(packets.size());
    all.placed->engine()->query_points(packets, kInfinity, all.scratch->engine.get(),
                                       expected.data());
    made.placed->engine()->query_points(packets, kInfinity, made.scratch->engine.get(),
                                        found.data());
    for (size_t g = 0; g < packets.size(); ++g) {
        EXPECT_EQ(all.placed->inside(packets[g], expected[g], {}, all.scratch.get()),
                  made.placed->inside(packets[g], found[g], {}, made.scratch.get()));
        std::array<std::array<float, 8>, 2> heat{};
        std::array<std::array<uint32_t, 8>, 2> kind{};
        for (const bool grown : {false, true}) {
            float* values[] = {heat[grown ? 1 : 0].data()};
            uint32_t* flat[] = {kind[grown ? 1 : 0].data()};
            nearest::PointTargets targets;
            targets.values = values;
            targets.flat = flat;
            const Made& of = grown ? made : all;
            of.placed->read_points(grown ? found[g] : expected[g], targets, of.scratch.get());
        }
        EXPECT_EQ(heat[0], heat[1]);
        EXPECT_EQ(kind[0], kind[1]);
        for (size_t l = 0; l < 8; ++l) {
            EXPECT_EQ(found[g].distance2[l], expected[g].distance2[l]);
            EXPECT_EQ(found[g].bary2[l], expected[g].bary2[l]);
        }
    }
}

/// Bounds hold the distances of all voxels, and tops are those of coverage.
TEST(GrowSolid, BoundsHoldAndTopsAreCovered) {
    const Made all(bush, kernel<bush>, 0, all_of(bush)), made(bush, kernel<bush>, kMuch, nullptr);
    const Vec3i base = part::part_base_voxel(made.part, made.grid);
    for (const int32_t size : {8, 16, 64}) {
        const Vec3i lowest = Vec3i{24, 16, 40} - base;
        nearest::BoxBounds bounds;
        made.placed->engine()->bounds(lowest, size, made.scratch->engine.get(), &bounds);
        float least = kInfinity;
        for (int32_t i = 0; i < bounds.count; ++i)
            least = std::min(least, bounds.cases[static_cast<size_t>(i)].distance_lo);
        for (int32_t z = 0; z < size; z += 8) {
            nearest::BlockAnswer answer;
            all.placed->engine()->query({lowest + Vec3i{0, 0, z}}, all.scratch->engine.get(),
                                        &answer);
            for (const float d2 : answer.distance2) {
                EXPECT_LE(std::sqrt(d2), bounds.distance_hi);
                EXPECT_GE(std::sqrt(d2), least);
            }
        }
    }
    const Columns columns{8, 8, 80, 60};
    TopRows expected{made.grid.size.x, 8, std::vector<int32_t>(96 * 52, -1)}, found = expected;
    all.placed->raise_tops(columns, &expected);
    made.placed->raise_tops(columns, &found);
    EXPECT_EQ(found.top, expected.top);
    EXPECT_GT(*std::ranges::max_element(found.top), 0);
}

Node endless(const Node& parent, int32_t /*child*/, int32_t level, uint32_t path) {
    Node n = bush(parent, 0, std::min(level, 3), path);
    n.end[3] = n.end[0];
    n.end[4] = n.end[1];
    n.end[5] = n.end[2] + 0.01f * std::pow(0.9f, static_cast<float>(level));
    n.radius[0] = n.radius[1] = 0.1f;
    n.children = 1;
    n.reach = 1;
    return n;
}
Node leaves(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    n.reach *= 0.2f;
    return n;
}
Node lost(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    if (level == 3) n.end[4] = std::nanf("");
    return n;
}
Node crowd(const Node& parent, int32_t child, int32_t level, uint32_t path) {
    Node n = bush(parent, child, level, path);
    n.children = level == 2 ? 1 << 20 : n.children;
    return n;
}

/// A dense rule: all its nodes lie in one voxel, of which there are 4^20.
Node dust(const Node& /*parent*/, int32_t /*child*/, int32_t level, uint32_t path) {
    Node n;
    for (int e = 0; e < 2; ++e) {
        for (int a = 0; a < 3; ++a)
            n.end[3 * e + a] = 0.01f * chance(path, static_cast<uint32_t>(3 * e + a));
    }
    n.radius[0] = n.radius[1] = 1e-4f;
    n.children = level == 20 ? 0 : 4;
    n.reach = 0.1f;
    return n;
}

TEST(GrowSolid, SaysWhatIsWrongAndWhere) {
    const std::pair<openfab_kernel_fn, const char*> kWrong[] = {
        {kernel<endless>, "has children, 1000 levels deep"},
        {kernel<leaves>, "outside of"},
        {kernel<lost>, "that is no finite number"},
        {kernel<crowd>, "has 1048576 children; the most are 65536"},
        {kernel<dust>, "more than 524288 beams lie within a few voxels"},
    };
    for (const auto& [fn, what] : kWrong) {
        const Made made(nullptr, fn, 8 << 20, nullptr);
        Result<void> status = made.status;
        if (made.placed != nullptr) {
            made.covered();
            status = made.solid->status();
        }
        ASSERT_FALSE(status) << what;
        EXPECT_NE(status.error().message.find(what), std::string::npos) << status.error().text();
        EXPECT_EQ(exit_code(status.error().code), 1) << what;
    }
    const Made small(bush, kernel<bush>, kMuch, nullptr, {{-1, -1, -1}, {1, 1, 1}});
    ASSERT_FALSE(small.status);
    EXPECT_EQ(small.status.error().location.line, 7);
    EXPECT_NE(small.status.error().help.find("box_mm"), std::string::npos);
}

}  // namespace
}  // namespace openfab::solid
