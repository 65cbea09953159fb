// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The commands of `openfab mechanics`.

#include <string>
#include <vector>

#include "mechanics/command/options.h"

namespace openfab::mechanics {

struct CellOptions {
    CommonOptions common;
    std::string object;  ///< of a world; empty: the first
    std::string cell;    ///< `5mm`, or `5mmx5mmx3mm`
    std::string sweep;   ///< `thickness=0.4:1.6:5`
    std::string output, polar;
    bool conductivity = false, converge = false;
};
Result<void> run_cell(const CellOptions& options);

struct PartCommandOptions {
    CommonOptions common;
    std::string load_case;             ///< empty: the only one
    std::vector<std::string> outputs;  ///< .vti, .npy, .json, .ofr
    std::string preview, show = "von-mises", view;
    std::string buckling = "auto";  ///< or always, never
    double require = 0;             ///< a safety factor; less is an error
    bool loose = false, thin = false, converge = false, full = false;
};
Result<void> run_part(const PartCommandOptions& options);

struct ConductOptions {
    CommonOptions common;
    std::string load_case;             ///< empty: the only one
    std::vector<std::string> outputs;  ///< .vti, .npy, .json, .ofr
    bool converge = false;
};
Result<void> run_conduct(const ConductOptions& options);

struct StandOptions {
    CommonOptions common;
    std::vector<std::string> outputs;  ///< .json, .vti, .ofr
    std::string preview;
    int modes = 4, while_printing = 0;
    bool loose = false, thin = false;
};
Result<void> run_stand(const StandOptions& options);

struct StrengthenOptions {
    CommonOptions common;
    std::string load_case;  ///< empty: the only one
    std::string field;      ///< a texture of the world
    std::string output;     ///< NAME.fab.json
    double safety = 1.5, limit = 1, reach_mm = 0;
    int rounds = 20;
    bool loose = false, thin = false;
};
Result<void> run_strengthen(const StrengthenOptions& options);

struct ExportOptions {
    CommonOptions common;
    std::string load_case;             ///< empty: none
    std::vector<std::string> outputs;  ///< .inp, .vtu, .msh, .xdmf
    bool loose = false, thin = false;
};
Result<void> run_export(const ExportOptions& options);

}  // namespace openfab::mechanics
