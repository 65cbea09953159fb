// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A mesh of as many triangles as a test needs.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/vec.h"
#include "tests/unit/mesh/mesh_files.h"

namespace openfab::mesh {

/// A ball of about `triangles`, as STL, with unshared corners, or as OBJ.
inline std::string ball(int rings, bool stl, bool open, bool shells) {
    const int around = 2 * rings;
    std::vector<Vec3d> p;
    std::vector<std::array<int, 3>> t;
    if (shells) {
        for (int i = 0; i < rings * rings; ++i) {
            const Vec3d at{(i % rings) * 2.0, (i / rings) * 2.0, 0};
            const auto first = static_cast<int>(p.size());
            for (const Vec3d& c : {Vec3d{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
                p.push_back(at + c);
            for (const auto& f : {std::array{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
                t.push_back({first + f[0], first + f[1], first + f[2]});
        }
    } else {
        // A torus: a perfectly regular mesh.
        for (int i = 0; i < rings; ++i) {
            for (int k = 0; k < around; ++k) {
                const double a = 6.283185307179586 * i / rings, b = 6.283185307179586 * k / around;
                p.push_back({(20 + 5 * std::cos(a)) * std::cos(b),
                             (20 + 5 * std::cos(a)) * std::sin(b), 5 * std::sin(a)});
            }
        }
        for (int i = 0; i < rings; ++i) {
            for (int k = 0; k < around; ++k) {
                if (open && i == 3 && k % 9 == 0) continue;
                const int a = i * around + k, b = i * around + (k + 1) % around,
                          c = (i + 1) % rings * around + k,
                          d = (i + 1) % rings * around + (k + 1) % around;
                t.push_back({a, b, d});
                t.push_back({a, d, c});
            }
        }
    }
    std::string out;
    if (stl) {
        out = std::string(80, ' ');
        append(&out, static_cast<uint32_t>(t.size()));
        for (const auto& f : t) {
            out.append(12, '\0');
            for (const int v : f) {
                for (int a = 0; a < 3; ++a)
                    append(&out, static_cast<float>(p[v][a]));
            }
            out.append(2, '\0');
        }
        return out;
    }
    for (const Vec3d& v : p)
        out += fmt::format("v {} {} {}\n", v.x, v.y, v.z);
    for (const auto& f : t)
        out += fmt::format("f {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1);
    return out;
}

}  // namespace openfab::mesh
