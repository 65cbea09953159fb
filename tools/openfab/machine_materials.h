// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What commands that make worlds for a printer write of its materials and its profile.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "world/printer.h"

namespace openfab::tools {

/// Names of materials for profiles that list none.
std::vector<std::string> names_by_look();
/// Returns whether a material is called so, as `clear`; makers shorten the words.
bool is_called(const std::string& name, std::string_view word);
/// Puts the first material that is called so, as `white`, to `place`, and keeps the order of the others.
void put_material_first(std::vector<std::string>* names, size_t place, std::string_view word);
/// Returns `materials` of a world, with looks that names suggest and the profile's densities.
std::string materials_text(const std::vector<std::string>& names, const world::Printer& printer);
/// Copies a printer's profile that is a file: a world names files of its own folder alone.
Result<void> copy_profile(const std::string& printer, const std::filesystem::path& folder);

}  // namespace openfab::tools
