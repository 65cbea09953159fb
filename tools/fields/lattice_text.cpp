// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/lattice_text.h"

#include <fmt/format.h>

#include <array>
#include <iterator>

namespace openfab::tools {

std::string lattice_text(const mesh::Beams& beams) {
    using mesh::BeamEnd;
    constexpr const char* kEnds[] = {"ball", "flat", "dome"};  // by BeamEnd
    std::string nodes, struts;
    for (const Vec3d& p : beams.nodes)
        fmt::format_to(std::back_inserter(nodes), "node {:.9g} {:.9g} {:.9g} 0\n", p.x, p.y, p.z);
    size_t count = beams.nodes.size();
    std::array<BeamEnd, 2> ends{BeamEnd::kBall, BeamEnd::kBall};
    for (const mesh::Beam& beam : beams.beams) {
        if (beam.nodes[0] == beam.nodes[1]) {
            // A ball has the radius of its node, and nodes several.
            const Vec3d& p = beams.nodes[static_cast<size_t>(beam.nodes[0])];
            fmt::format_to(std::back_inserter(nodes), "node {:.9g} {:.9g} {:.9g} {:.9g}\n", p.x,
                           p.y, p.z, beam.radii[0]);
            fmt::format_to(std::back_inserter(struts), "ball {}\n", count++);
            continue;
        }
        if (beam.ends != ends) {
            ends = beam.ends;
            fmt::format_to(std::back_inserter(struts), "ends {}{}\n",
                           kEnds[static_cast<size_t>(ends[0])],
                           ends[0] == BeamEnd::kBall
                               ? std::string()
                               : fmt::format(" {}", kEnds[static_cast<size_t>(ends[1])]));
        }
        fmt::format_to(std::back_inserter(struts), "strut {} {} {:.9g} {:.9g}\n", beam.nodes[0],
                       beam.nodes[1], beam.radii[0], beam.radii[1]);
    }
    return nodes + struts;
}

}  // namespace openfab::tools
