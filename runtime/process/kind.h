// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A kind of effects: its key in the `process` of a printer's profile, its option, and how they become one of a print.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "runtime/process/effect.h"
#include "world/json_reader.h"
#include "world/printer.h"

namespace openfab::process {

struct PrintMaterial {
    std::string name, channel;
};

/// Returns the code of a material by its name, or its channel; 0 where there is none.
uint8_t material_code(const std::vector<PrintMaterial>& materials, const std::string& name);
/// Returns the end of a message about a name that none of the materials has.
std::string suggest_material(const std::vector<PrintMaterial>& materials, const std::string& name);

/// What an effect may know of the print that it is made for.
struct Print {
    const world::Printer& printer;
    std::vector<PrintMaterial> materials;  ///< code 1 is [0]
    int32_t mixed_materials = 0;           ///< codes up to this may be in mixtures
    Vec3d pitch_mm;
    bool solid = false;     ///< it has no mixtures
    bool as_built = false;  ///< see Options::as_built
};

/// What is told of an effect.
struct Told {
    std::vector<std::string>* warnings;
    std::vector<std::pair<std::string, std::string>>* provenance;  ///< names and short texts
};

/// An effect as a profile describes it.
class Described {
  public:
    virtual ~Described() = default;
    /// Returns that of a print, null where it changes nothing. `asked`: by its option.
    virtual Result<std::unique_ptr<Effect>> open(const Print& print, const std::string& asked,
                                                 const Told& told) const = 0;
};

/// An option of prints.
struct Option {
    std::string_view name;  ///< with its dashes; empty: none
    std::string_view value, help;
    std::span<const std::string_view> choices;  ///< empty: it names a file
    std::string_view usual;                     ///< what is asked where it is not given
    std::string_view usual_as_built;            ///< with `--as-built`
};

struct Kind {
    std::string_view key;
    Option option;
    /// Reads the entry of a profile, null where there is none; an error goes to `json`.
    std::unique_ptr<const Described> (*read)(const JsonValue* entry, world::JsonReader* json);
};

}  // namespace openfab::process
