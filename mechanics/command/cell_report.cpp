// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/cell_report.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <tuple>

#include "mechanics/command/part_report.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

namespace {

template <size_t N>
void write_matrix(const std::array<std::array<double, N>, N>& m, JsonText* out) {
    out->begin_array();
    for (const auto& row : m) {
        out->begin_array();
        for (const double v : row)
            out->value(v);
        out->end_array();
    }
    out->end_array();
}

template <size_t N>
void write_list(const std::array<double, N>& list, JsonText* out) {
    out->begin_array();
    for (const double v : list)
        out->value(v);
    out->end_array();
}

}  // namespace

void write_result(const CellResult& r, JsonText* out) {
    out->key("stiffness_MPa");
    write_matrix(r.stiffness.tensor, out);
    if (r.engineering) {
        const Engineering& e = *r.engineering;
        out->key("young_MPa");
        write_list(e.young, out);
        out->key("shear_yz_xz_xy_MPa");
        write_list(e.shear, out);
        out->key("poisson_xy_yz_zx");
        write_list(e.poisson, out);
        out->member("bulk_voigt_MPa", e.bulk_voigt).member("bulk_reuss_MPa", e.bulk_reuss);
        out->member("shear_voigt_MPa", e.shear_voigt).member("shear_reuss_MPa", e.shear_reuss);
        out->member("young_least_MPa", e.young_least).member("young_most_MPa", e.young_most);
        out->key("softest");
        write_list(e.softest, out);
        out->key("stiffest");
        write_list(e.stiffest, out);
        out->member("universal_anisotropy", e.universal_anisotropy).member("zener", e.zener);
    }
    if (r.heat) {
        out->key("conductivity_W_mK");
        write_matrix(r.heat->tensor, out);
    }
    if (r.current) {
        out->key("conductivity_S_m");
        write_matrix(r.current->tensor, out);
    }
    out->key("share").begin_object();
    for (size_t i = 0; i < r.voxels.materials.size(); ++i)
        out->member(r.voxels.materials[i], r.voxels.share[i]);
    out->end_object();
    out->key("pitch_mm");
    write_list(r.voxels.pitch_mm, out);
    out->key("elements").begin_array();
    for (const int32_t n : r.voxels.size)
        out->value(n);
    out->end_array();
    out->member("residual", r.stiffness.worst_residual())
        .member("iterations", static_cast<int32_t>(r.stiffness.most_iterations()));
}

std::string describe(const CellResult& r, const std::string& law) {
    std::string out = "stiffness, MPa (xx yy zz yz xz xy)\n";
    for (const auto& row : r.stiffness.tensor) {
        for (const double v : row)
            out += fmt::format("{:12.5g}", std::abs(v) < 1e-9 * r.stiffness.tensor[0][0] ? 0.0 : v);
        out += "\n";
    }
    if (r.engineering) {
        const Engineering& e = *r.engineering;
        out += fmt::format("Young's modulus   x {:.5g}  y {:.5g}  z {:.5g} MPa\n", e.young[0],
                           e.young[1], e.young[2]);
        out += fmt::format(
            "                  least {:.5g} along ({:.2f}, {:.2f}, {:.2f}), most {:.5g} along "
            "({:.2f}, {:.2f}, {:.2f})\n",
            e.young_least, e.softest[0], e.softest[1], e.softest[2], e.young_most, e.stiffest[0],
            e.stiffest[1], e.stiffest[2]);
        out += fmt::format("shear modulus     yz {:.5g}  xz {:.5g}  xy {:.5g} MPa\n", e.shear[0],
                           e.shear[1], e.shear[2]);
        out += fmt::format("Poisson's ratio   xy {:.4f}  yz {:.4f}  zx {:.4f}\n", e.poisson[0],
                           e.poisson[1], e.poisson[2]);
        out += fmt::format(
            "anisotropy        universal {:.4g}, Zener {:.4g} (of the isotropic 0 and 1)\n",
            e.universal_anisotropy, e.zener);
    } else {
        out += messages::kNoStiffness;
    }
    for (const auto& [one, unit] :
         {std::pair(&r.heat, "W/(m K)"), std::pair(&r.current, "S/m, of current")})
        if (*one)
            out +=
                fmt::format("conductivity      x {:.5g}  y {:.5g}  z {:.5g} {}\n",
                            (*one)->tensor[0][0], (*one)->tensor[1][1], (*one)->tensor[2][2], unit);
    out += "made of          ";
    for (size_t i = 0; i < r.voxels.materials.size(); ++i)
        out += fmt::format(" {} {:.2f} %", r.voxels.materials[i], 100 * r.voxels.share[i]);
    out += fmt::format(
        "\npitch {:.4g} x {:.4g} x {:.4g} mm, {} x {} x {} elements, {}, residual {:.1e} in {} "
        "iterations\n",
        r.voxels.pitch_mm[0], r.voxels.pitch_mm[1], r.voxels.pitch_mm[2], r.voxels.size[0],
        r.voxels.size[1], r.voxels.size[2], law, r.stiffness.worst_residual(),
        r.stiffness.most_iterations());
    return out;
}

std::string describe_convergence(const CellResult& fine, const CellResult& coarse) {
    std::string unsettled;
    const auto line = [&](const std::string& what, double a, double b, const char* unit) {
        const double change = a != 0 ? 100 * (a - b) / a : 0;
        const bool settles = settling(a, b, std::nullopt);
        if (!settles) unsettled += fmt::format("{}{}", unsettled.empty() ? "" : ", ", what);
        return fmt::format("  {:<16}{:>12.5g} {:>12.5g} {:>12} {:<8}{:+8.2f} %\n", what, b, a,
                           settles ? fmt::format("{:.5g}", a + (a - b) / 3) : "-", unit, change);
    };
    std::string out = fmt::format("{:<18}{:>12} {:>12} {:>12}\n", "at a pitch of",
                                  fmt::format("{:.4g} mm", coarse.voxels.pitch_mm[0]),
                                  fmt::format("{:.4g} mm", fine.voxels.pitch_mm[0]), "0");
    if (fine.engineering && coarse.engineering) {
        for (size_t i = 0; i < 3; ++i)
            out += line(fmt::format("Young's {}", "xyz"[i]), fine.engineering->young[i],
                        coarse.engineering->young[i], "MPa");
        for (size_t i = 0; i < 3; ++i)
            out += line(fmt::format("shear {}", std::array{"yz", "xz", "xy"}[i]),
                        fine.engineering->shear[i], coarse.engineering->shear[i], "MPa");
    } else {
        for (size_t i = 0; i < 6; ++i)
            out += line(std::array{"xx", "yy", "zz", "yz", "xz", "xy"}[i],
                        fine.stiffness.tensor[i][i], coarse.stiffness.tensor[i][i], "MPa");
    }
    for (const auto& [one, two, unit] : {std::tuple(&fine.heat, &coarse.heat, "W/(m K)"),
                                         std::tuple(&fine.current, &coarse.current, "S/m")})
        if (*one && *two)
            for (size_t i = 0; i < 3; ++i)
                out += line(fmt::format("conductivity {}", "xyz"[i]), (*one)->tensor[i][i],
                            (*two)->tensor[i][i], unit);
    if (!unsettled.empty()) out += fmt::format(messages::kCellNotSettled, unsettled);
    out += fmt::format(
        "at 0 where errors fall with the square of the pitch; {} x {} x {} elements at half the "
        "pitch, residual {:.1e} in {} iterations\n",
        fine.voxels.size[0], fine.voxels.size[1], fine.voxels.size[2],
        fine.stiffness.worst_residual(), fine.stiffness.most_iterations());
    return out;
}

}  // namespace openfab::mechanics
