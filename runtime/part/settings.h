// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of uniforms that a command line sets: `OBJECT.UNIFORM=VALUE`; VALUE is JSON, or the bare name of a
// texture or material. They go before what the world has, for every placement of the object.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "world/world.h"

namespace openfab::part {

struct Setting {
    std::string object;
    std::string uniform;
    world::UniformBinding binding;
};

/// By object.
using Settings = std::map<std::string, world::UniformBindings>;

/// The location of errors about a setting, and of its binding.
SourceLocation place_of_setting(const std::string& text);

/// Errors are about the command line.
Result<Setting> parse_setting(const std::string& text);

/// Reads settings of a world's objects, the last of each uniform; another object's is an error.
Result<Settings> read_settings(const world::World& world, const std::vector<std::string>& texts);

/// Writes settings into a world; its fablets are unknown, so a name that they do not have is kept.
Result<void> apply_settings(const std::vector<std::string>& texts, world::World* world);

/// Returns the `OBJECT.UNIFORM=VALUE` that an error is about; empty if it is about no setting.
std::string_view setting_of(const Error& error);

}  // namespace openfab::part
