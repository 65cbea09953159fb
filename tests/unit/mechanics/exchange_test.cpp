// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Meshes for other programs, and one of these as a peer.

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "mechanics/exchange/element_mesh.h"
#include "mechanics/exchange/hdf5.h"
#include "mechanics/part/part_results.h"
#include "tests/support/meshes/temp_folder.h"

namespace openfab::mechanics {
namespace {

/// A block with a hole and two materials, the softer one above.
PartProblem block() {
    Voxels v;
    v.size = {10, 5, 6};
    v.pitch_mm = {1, 0.8, 0.5};
    v.origin_mm = {3, -2, 1};
    v.materials = {"stiff one", "Stiff_one"};
    for (int32_t z = 0; z < 6; ++z)
        for (int32_t y = 0; y < 5; ++y)
            for (int32_t x = 0; x < 10; ++x) {
                const bool solid = std::hypot(x - 4.5, 0.5 * (z - 2.5)) > 1.2;
                Material m;
                m.young_MPa = z < 3 ? 2000 : 300;
                m.poisson = z < 3 ? 0.35 : 0.45;
                v.solid.push_back(solid ? 1 : 0);
                v.lambda.push_back(solid ? static_cast<float>(m.lambda()) : 0.F);
                v.mu.push_back(solid ? static_cast<float>(m.mu()) : 0.F);
                v.density.push_back(solid ? 1.2F : 0.F);
                v.strength.push_back(50);
                v.code.push_back(solid ? (z < 3 ? 1 : 2) : 0);
            }
    const Result<LoadCase> c = parse_load_case(
        R"({"cases": {"pull": {"held": [{"side": "-x"}, {"side": "-y", "box_mm": [[5, -3, 0], [20, 3, 9]], "along": "y", "move_mm": [0, 0.01, 0]}],
            "loads": [{"side": "+x", "force_N": [20, 0, -5], "torque_Nmm": [30, 0, 0]},
                      {"side": "+z", "pressure_MPa": 0.5}],
            "gravity_m_s2": [0, 0, -9.81]}}})",
        "test", "");
    EXPECT_TRUE(c) << c.error().text();
    Result<PartProblem> p = set_up_part(std::move(v), *c, {}, {false, true});
    EXPECT_TRUE(p) << p.error().text();
    return std::move(*p);
}

std::string text_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::stringstream out;
    out << in.rdbuf();
    return out.str();
}

TEST(MechanicsExchange, NodesAreSharedAndElementsTurnTheRightWay) {
    const PartProblem p = block();
    const ElementMesh mesh = mesh_of(p.grid, p.voxels);
    EXPECT_EQ(static_cast<int64_t>(mesh.elements.size()), p.elements.solid);
    std::set<int64_t> used;
    for (size_t e = 0; e < mesh.elements.size(); ++e) {
        const std::array<int64_t, 8> c = mesh.corners(e);
        used.insert(c.begin(), c.end());
        Vec3 at[8];
        for (size_t k = 0; k < 8; ++k)
            at[k] = mesh.place_mm(static_cast<size_t>(c[k]));
        // A positive volume: x along the first edge, y along the last of the base, z up.
        EXPECT_NEAR(at[1][0] - at[0][0], 1, 1e-12);
        EXPECT_NEAR(at[2][1] - at[1][1], 0.8, 1e-12);
        EXPECT_NEAR(at[3][0] - at[2][0], -1, 1e-12);
        EXPECT_NEAR(at[4][2] - at[0][2], 0.5, 1e-12);
        EXPECT_NEAR(at[6][2] - at[2][2], 0.5, 1e-12);
    }
    EXPECT_EQ(used.size(), mesh.nodes.size());
    ASSERT_EQ(mesh.sections.size(), 2U);
    std::set<std::string> names;
    for (const Section& s : mesh.sections) {
        EXPECT_EQ(s.name.find(' '), std::string::npos);
        names.insert(s.name);
        EXPECT_NEAR(s.young_MPa, s.poisson < 0.4 ? 2000 : 300, 1e-3);
    }
    // Programs that do not tell lower from upper case see two names.
    EXPECT_EQ(names, (std::set<std::string>{"Stiff_one_2", "stiff_one"}));
}

TEST(MechanicsExchange, FilesSayTheirSizes) {
    const testing::TempFolder folder;
    const PartProblem p = block();
    const ElementMesh mesh = mesh_of(p.grid, p.voxels);
    ASSERT_TRUE(write_vtu(folder.path() / "a.vtu", mesh));
    ASSERT_TRUE(write_msh(folder.path() / "a.msh", mesh));
    const std::string vtu = text_of(folder.path() / "a.vtu");
    EXPECT_NE(vtu.find("NumberOfPoints=\"" + std::to_string(mesh.nodes.size()) + "\""),
              std::string::npos);
    EXPECT_NE(vtu.find("share_stiff one"), std::string::npos);
    const std::string msh = text_of(folder.path() / "a.msh");
    for (const char* part : {"$MeshFormat\n4.1 1 8\n", "$EndEntities", "$EndNodes", "$EndElements",
                             "3 2 \"Stiff_one\""})
        EXPECT_NE(msh.find(part), std::string::npos) << part;
}

/// A little-endian number of `bytes` bytes.
uint64_t number_at(const std::string& file, size_t at, size_t bytes) {
    uint64_t out = 0;
    for (size_t i = 0; i < bytes; ++i)
        out |= static_cast<uint64_t>(static_cast<uint8_t>(file[at + i])) << (8 * i);
    return out;
}

// meshio skips the numbers of elements, and takes arrays that say one component for tables.
TEST(MechanicsExchange, ValuesStandInTheOrderOfElements) {
    const testing::TempFolder folder;
    const PartProblem p = block();
    const ElementMesh mesh = mesh_of(p.grid, p.voxels);
    ASSERT_TRUE(write_vtu(folder.path() / "a.vtu", mesh));
    ASSERT_TRUE(write_msh(folder.path() / "a.msh", mesh));
    EXPECT_EQ(text_of(folder.path() / "a.vtu").find("NumberOfComponents=\"1\""), std::string::npos);
    const std::string msh = text_of(folder.path() / "a.msh");
    size_t at = msh.find("$Elements\n") + 10;
    const uint64_t blocks = number_at(msh, at, 8), elements = mesh.elements.size();
    ASSERT_GT(blocks, 1u);
    at += 32;
    std::vector<std::array<uint64_t, 8>> corners;
    for (uint64_t b = 0; b < blocks; ++b) {
        const uint64_t count = number_at(msh, at + 12, 8);
        at += 20;
        for (uint64_t i = 0; i < count; ++i, at += 72) {
            EXPECT_EQ(number_at(msh, at, 8), corners.size() + 1);
            corners.emplace_back();
            for (size_t c = 0; c < 8; ++c)
                corners.back()[c] = number_at(msh, at + 8 + 8 * c, 8);
        }
    }
    ASSERT_EQ(corners.size(), elements);
    std::map<std::array<uint64_t, 8>, float> young;
    for (const auto& [name, values] : element_fields(mesh)) {
        if (name != "young_MPa") continue;
        for (size_t e = 0; e < elements; ++e) {
            std::array<uint64_t, 8> of{};
            for (size_t c = 0; c < 8; ++c)
                of[c] = static_cast<uint64_t>(mesh.corners(e)[c] + 1);
            young[of] = static_cast<float>(values[e]);
        }
    }
    ASSERT_EQ(young.size(), elements);
    const std::string head = "\"young_MPa\"\n1\n0\n3\n0\n1\n" + std::to_string(elements) + "\n";
    at = msh.find(head) + head.size();
    for (uint64_t i = 0; i < elements; ++i, at += 12) {
        EXPECT_EQ(number_at(msh, at, 4), i + 1);
        double value = 0;
        std::memcpy(&value, msh.data() + at + 4, 8);
        EXPECT_EQ(static_cast<float>(value), young.at(corners[i])) << i;
    }
}

/// Where the header of an object ends, whose checksum is right.
size_t checked_header(const std::string& file, size_t at) {
    EXPECT_EQ(file.substr(at, 6), std::string("OHDR\x02\x02"));
    const size_t bytes = 10 + number_at(file, at + 6, 4);
    const auto* head = reinterpret_cast<const uint8_t*>(file.data()) + at;
    EXPECT_EQ(number_at(file, at + bytes, 4), lookup3({head, bytes}));
    return at + bytes;
}

// Programs that read input files make labels upper-case, and join sets of one label without a word.
TEST(MechanicsExchange, NoLabelOfOursIsAMaterials) {
    PartProblem p = block();
    for (const std::vector<std::string>& materials : std::vector<std::vector<std::string>>{
             {"b", "most_1"},
             {"Most_2", "MOST_1"},
             {"most", "Most"},
             {"nall", "loaded"},
             {"held_1", "held 2"},
             {"m_most_1", "most_1"},
             {"mix_most", "most_x"},
             {"1", "m_1"},
             {"__x", "x\n*STEP"},
             {std::string(200, 'a') + "1", std::string(200, 'a') + "2"},
             {"a\"b", "ab"}}) {
        p.voxels.materials = materials;
        const ElementMesh mesh = mesh_of(p.grid, p.voxels);
        const testing::TempFolder folder;
        const std::filesystem::path inp = folder.path() / "a.inp", msh = folder.path() / "a.msh";
        ASSERT_TRUE(write_inp(inp, mesh, MeshCase{"one\n*BOUNDARY", &p}));
        ASSERT_TRUE(write_msh(msh, mesh));
        std::set<std::string> labels;
        std::istringstream lines(text_of(inp));
        size_t materials_there = 0, sets = 0, boundaries = 0, steps = 0;
        for (std::string line; std::getline(lines, line);) {
            for (char& c : line)
                c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
            boundaries += line == "*BOUNDARY" ? 1 : 0;
            steps += line == "*STEP" ? 1 : 0;
            if (line.starts_with("*MATERIAL")) ++materials_there;
            if (line.starts_with("*SOLID") || !line.starts_with("*")) continue;
            const size_t at = line.find("SET=");
            if (at == std::string::npos) continue;
            const std::string label = line.substr(at + 4);
            ++sets;
            EXPECT_TRUE(labels.insert(label).second) << label << " of " << materials[1];
            EXPECT_TRUE(std::isalpha(static_cast<unsigned char>(label[0]))) << label;
            EXPECT_LE(label.size(), 80U);
            EXPECT_EQ(label.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"),
                      std::string::npos)
                << label;
        }
        // Nodes, two sections, two sets of what is mostly of one, two holds, loaded nodes.
        EXPECT_EQ(sets, 8U);
        EXPECT_EQ(materials_there, 2U);
        EXPECT_EQ(boundaries, 1U);
        EXPECT_EQ(steps, 1U);
        // In gmsh's file names are between quotes, each in its line.
        std::istringstream head(text_of(msh));
        std::set<std::string> names;
        for (std::string line; std::getline(head, line) && line != "$EndPhysicalNames";)
            if (const size_t quote = line.find('"'); quote != std::string::npos) {
                EXPECT_EQ(line.find('"', quote + 1), line.size() - 1) << line;
                EXPECT_TRUE(names.insert(line.substr(quote)).second) << line;
            }
        EXPECT_EQ(names.size(), 2U);
        std::set<std::string> fields;
        for (const auto& [name, values] : element_fields(mesh))
            EXPECT_TRUE(fields.insert(name).second) << name;
    }
}

TEST(MechanicsExchange, ChecksumsAreJenkins) {
    const auto of = [](const std::string& text) {
        return lookup3({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
    };
    // The two that his own test prints.
    EXPECT_EQ(of(""), 0xdeadbeefU);
    EXPECT_EQ(of("Four score and seven years ago"), 0x17770551U);
}

TEST(MechanicsExchange, XdmfHasItsNumbersInHdf5) {
    const testing::TempFolder folder;
    const PartProblem p = block();
    const ElementMesh mesh = mesh_of(p.grid, p.voxels);
    ASSERT_TRUE(write_xdmf(folder.path() / "a.xdmf", mesh));
    const std::string xdmf = text_of(folder.path() / "a.xdmf"),
                      file = text_of(folder.path() / "a.h5");
    EXPECT_NE(xdmf.find("Format=\"HDF\">a.h5:/points<"), std::string::npos);
    EXPECT_NE(xdmf.find("Name=\"share_stiff one\""), std::string::npos);
    ASSERT_EQ(file.substr(0, 9), std::string("\x89HDF\r\n\x1a\n\x02"));
    EXPECT_EQ(number_at(file, 28, 8), file.size());
    EXPECT_EQ(number_at(file, 44, 4), lookup3({reinterpret_cast<const uint8_t*>(file.data()), 44}));
    checked_header(file, number_at(file, 36, 8));
    // The link to an array ends with where its header is; that, with where its values are and how many.
    const auto values_of = [&](const std::string& name, size_t bytes) {
        const std::string link = static_cast<char>(name.size()) + std::string(1, '\0') + name;
        const size_t at = file.find(link);
        EXPECT_NE(at, std::string::npos) << name;
        const size_t end = checked_header(file, number_at(file, at + link.size(), 8));
        EXPECT_EQ(number_at(file, end - 8, 8), bytes) << name;
        return number_at(file, end - 16, 8);
    };
    const size_t elements = mesh.elements.size();
    const size_t points = values_of("points", mesh.nodes.size() * 24),
                 corners = values_of("corners", elements * 64),
                 material = values_of("material", elements);
    for (size_t n = 0; n < mesh.nodes.size(); ++n)
        for (size_t c = 0; c < 3; ++c) {
            double v = 0;
            std::memcpy(&v, file.data() + points + 24 * n + 8 * c, 8);
            EXPECT_EQ(v, mesh.place_mm(n)[c]);
        }
    for (size_t e = 0; e < elements; ++e) {
        EXPECT_EQ(static_cast<uint8_t>(file[material + e]), mesh.material[e]);
        for (size_t k = 0; k < 8; ++k)
            EXPECT_EQ(number_at(file, corners + 64 * e + 8 * k, 8),
                      static_cast<uint64_t>(mesh.corners(e)[k]));
    }
}

TEST(MechanicsExchange, CalculixMovesItAsWeDo) {
    if (std::system("command -v ccx > /dev/null 2>&1") != 0)
        GTEST_SKIP() << "there is no ccx; the package calculix-ccx has it";
    const testing::TempFolder folder;
    PartProblem p = block();
    const ElementMesh mesh = mesh_of(p.grid, p.voxels);
    ASSERT_TRUE(write_inp(folder.path() / "block.inp", mesh, MeshCase{"pull", &p}));
    const std::string command =
        "cd '" + folder.path().string() + "' && OMP_NUM_THREADS=1 ccx block > log";
    ASSERT_EQ(std::system(command.c_str()), 0);
    SolveOptions options;
    options.tolerance = 1e-9;
    const PartSolution ours = solve_part(&p, 2, options, true);
    ASSERT_TRUE(ours.report.converged);
    std::ifstream frd(folder.path() / "block.frd");
    bool displacements = false;
    size_t seen = 0;
    double worst = 0, largest = 0;
    for (std::string line; std::getline(frd, line);) {
        if (line.rfind(" -4", 0) == 0) displacements = line.find("DISP") != std::string::npos;
        if (!displacements || line.rfind(" -1", 0) != 0) continue;
        const auto node = static_cast<size_t>(std::stoll(line.substr(3, 10))) - 1;
        const Vec3 u = moved_at(ours.moved_mm, mesh.nodes[node]);
        for (size_t c = 0; c < 3; ++c) {
            worst = std::max(worst, std::abs(u[c] - std::stod(line.substr(13 + 12 * c, 12))));
            largest = std::max(largest, std::abs(u[c]));
        }
        ++seen;
    }
    EXPECT_EQ(seen, mesh.nodes.size());
    EXPECT_GT(largest, 0.01);
    EXPECT_LT(worst, 1e-4 * largest);
}

}  // namespace
}  // namespace openfab::mechanics
