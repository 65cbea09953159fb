// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "backends/common/part_file.h"
#include "base/text.h"
#include "mechanics/exchange/element_mesh.h"
#include "mechanics/exchange/text_file.h"

namespace openfab::mechanics {

namespace {

/// Sixteen numbers a line at most.
void write_set(TextFile* out, const std::string& head, const std::vector<int64_t>& numbers) {
    out->put(head + "\n");
    for (size_t i = 0; i < numbers.size(); ++i)
        out->put(
            fmt::format("{}{}", numbers[i], i + 1 == numbers.size() || i % 12 == 11 ? "\n" : ", "));
}

/// A name in a comment, which ends with its line.
std::string comment_of(const std::string& name) {
    constexpr size_t kLongest = 60;
    const std::string text = printable(name);
    return text.size() > kLongest ? text.substr(0, kLongest) + " ..." : text;
}

void write_case(TextFile* out, const ElementMesh& mesh, const MeshCase& one) {
    const PartProblem& p = *one.problem;
    const Grid& g = mesh.grid;
    std::vector<std::vector<int64_t>> holds;
    for (size_t i = 0; i < p.held.size(); ++i) {
        const auto h = static_cast<size_t>(p.hold[i]);
        if (holds.size() <= h) holds.resize(h + 1);
        const int64_t number = mesh.index_of(p.held[i].dof / 3) + 1;
        if (holds[h].empty() || holds[h].back() != number) holds[h].push_back(number);
    }
    for (size_t h = 0; h < holds.size(); ++h)
        if (!holds[h].empty())
            write_set(out, fmt::format("*NSET, NSET={}{}", kHeldPrefix, h + 1), holds[h]);
    std::vector<int64_t> loaded;
    for (const int64_t node : p.load_nodes)
        loaded.push_back(mesh.index_of(node) + 1);
    if (!loaded.empty()) write_set(out, fmt::format("*NSET, NSET={}", kLoaded), loaded);
    out->put(fmt::format("*STEP\n** case {}\n*STATIC\n*BOUNDARY\n", comment_of(one.name)));
    for (const Held& h : p.held)
        out->put(fmt::format("{}, {}, {}, {:.12g}\n", mesh.index_of(h.dof / 3) + 1, h.dof % 3 + 1,
                             h.dof % 3 + 1, h.move_mm));
    bool first = true;
    for (size_t n = 0; n < mesh.nodes.size(); ++n) {
        const int64_t row = mesh.nodes[n] / g.nodes[0];
        for (int c = 0; c < 3; ++c) {
            const double f =
                p.forces_N.row(c, static_cast<int32_t>(row % g.nodes[1]),
                               static_cast<int32_t>(row / g.nodes[1]))[mesh.nodes[n] % g.nodes[0]];
            if (f == 0) continue;
            if (first) out->put("*CLOAD\n");
            first = false;
            out->put(fmt::format("{}, {}, {:.12g}\n", n + 1, c + 1, f));
        }
    }
    out->put("*NODE FILE\nU, RF\n*EL FILE\nS, E\n*END STEP\n");
}

}  // namespace

Result<void> write_inp(const std::filesystem::path& path, const ElementMesh& mesh,
                       const std::optional<MeshCase>& load_case) {
    Result<std::unique_ptr<TextFile>> opened = TextFile::create(path);
    if (!opened) return opened.error();
    TextFile* out = opened->get();
    out->put(
        fmt::format("*HEADING\nvoxels of OpenFab: mm, N, MPa, t/mm3\n*NODE, NSET={}\n", kAllNodes));
    for (size_t n = 0; n < mesh.nodes.size(); ++n) {
        const Vec3 p = mesh.place_mm(n);
        out->put(fmt::format("{}, {:.9g}, {:.9g}, {:.9g}\n", n + 1, p[0], p[1], p[2]));
    }
    std::vector<std::vector<int64_t>> of_section(mesh.sections.size());
    std::vector<std::vector<int64_t>> of_material(mesh.materials.size());
    for (size_t e = 0; e < mesh.elements.size(); ++e) {
        of_section[static_cast<size_t>(mesh.section[e])].push_back(static_cast<int64_t>(e));
        if (mesh.material[e] > 0)
            of_material[mesh.material[e] - 1U].push_back(static_cast<int64_t>(e) + 1);
    }
    for (size_t s = 0; s < mesh.sections.size(); ++s) {
        out->put(fmt::format("*ELEMENT, TYPE=C3D8, ELSET={}\n", mesh.sections[s].name));
        for (const int64_t e : of_section[s]) {
            const std::array<int64_t, 8> c = mesh.corners(static_cast<size_t>(e));
            out->put(fmt::format("{}, {}, {}, {}, {}, {}, {}, {}, {}\n", e + 1, c[0] + 1, c[1] + 1,
                                 c[2] + 1, c[3] + 1, c[4] + 1, c[5] + 1, c[6] + 1, c[7] + 1));
        }
    }
    for (size_t k = 0; k < of_material.size(); ++k)
        if (!of_material[k].empty())
            write_set(out,
                      fmt::format("** most of {}\n*ELSET, ELSET={}{}",
                                  comment_of(mesh.materials[k]), kMostPrefix, k + 1),
                      of_material[k]);
    for (const Section& s : mesh.sections) {
        out->put(fmt::format("*MATERIAL, NAME={}\n*ELASTIC\n{:.9g}, {:.9g}\n", s.name, s.young_MPa,
                             s.poisson));
        if (s.density_g_cm3 > 0)
            out->put(fmt::format("*DENSITY\n{:.9g}\n", s.density_g_cm3 * 1e-9));
    }
    for (const Section& s : mesh.sections)
        out->put(fmt::format("*SOLID SECTION, ELSET={0}, MATERIAL={0}\n", s.name));
    if (load_case) write_case(out, mesh, *load_case);
    return out->keep();
}

}  // namespace openfab::mechanics
