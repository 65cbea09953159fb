// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/near_miss.h"
#include "runtime/process/kind.h"

namespace openfab::process {

uint8_t material_code(const std::vector<PrintMaterial>& materials, const std::string& name) {
    for (const auto member : {&PrintMaterial::name, &PrintMaterial::channel}) {
        for (size_t m = 0; m < materials.size(); ++m) {
            if (materials[m].*member == name) return static_cast<uint8_t>(m + 1);
        }
    }
    return 0;
}

std::string suggest_material(const std::vector<PrintMaterial>& materials, const std::string& name) {
    std::vector<std::string> names;
    for (const PrintMaterial& material : materials)
        names.push_back(material.name);
    return suggest(name, names);
}

}  // namespace openfab::process
