// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Writes a closed mesh of many triangles: a ring 50 mm across with waves, as binary PLY or STL.
//   bench_large_mesh TRIANGLES FILE

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/support/mesh_surface.h"

namespace openfab::bench {
namespace {

static_assert(std::endian::native == std::endian::little);

testing::TriangleMesh make_ring(int64_t triangles) {
    const int nv = static_cast<int>(std::sqrt(static_cast<double>(triangles) / 5));
    const int nu = static_cast<int>(triangles / (2 * nv));
    return testing::make_periodic(nu, nv, [](double u, double v) {
        const double a = u * 2 * M_PI, b = v * 2 * M_PI;
        const double around = std::sin(3 * a + 2 * b) + 0.3 * std::sin(40 * a) * std::sin(17 * b);
        const double small = 8.5 + 0.6 * around;
        const double r = 15.5 + small * std::cos(b);
        return vec_cast<float>(Vec3d{r * std::cos(a), r * std::sin(a), small * std::sin(b)});
    });
}

template <typename T>
void put(std::string* out, const T& value) {
    out->append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::string to_ply(const testing::TriangleMesh& mesh) {
    std::string out = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.positions.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3f& p : mesh.positions) {
        for (int a = 0; a < 3; ++a)
            put(&out, p[a]);
    }
    for (const auto& t : mesh.triangles) {
        put(&out, uint8_t{3});
        put(&out, t);
    }
    return out;
}

std::string to_stl(const testing::TriangleMesh& mesh) {
    std::string out(80, ' ');
    put(&out, static_cast<uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int a = 0; a < 3; ++a)
            put(&out, 0.0f);  // a zero normal: readers compute it
        for (const int32_t v : t) {
            for (int a = 0; a < 3; ++a)
                put(&out, mesh.positions[v][a]);
        }
        put(&out, uint16_t{0});
    }
    return out;
}

}  // namespace
}  // namespace openfab::bench

int main(int argc, char** argv) {
    using namespace openfab::bench;
    const std::string file = argc == 3 ? argv[2] : "";
    if (!file.ends_with(".ply") && !file.ends_with(".stl")) {
        std::fprintf(stderr, "usage: bench_large_mesh TRIANGLES FILE.ply|FILE.stl\n");
        return 2;
    }
    const auto mesh = make_ring(std::atoll(argv[1]));
    const std::string bytes = file.ends_with(".ply") ? to_ply(mesh) : to_stl(mesh);
    std::ofstream out(file, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    out.close();
    if (!out) {
        std::fprintf(stderr, "%s could not be written\n", file.c_str());
        return 1;
    }
    std::fprintf(stderr, "%s: %zu triangles\n", file.c_str(), mesh.triangles.size());
}
