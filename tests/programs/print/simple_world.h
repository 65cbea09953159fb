// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

namespace openfab::testing {

/// A world of one object of two materials, for tests that do not care what is printed.
struct SimpleWorld {
    std::string fablet;  ///< in f.fl
    std::string mesh;    ///< JSON, such as `{"sphere": 16}`
    std::string printer = "generic";
    std::string object = "thing";  ///< its name

    std::string text() const {
        return fmt::format(R"({{
  "openfab": 1, "printer": "{0}",
  "fablets": {{"f": {{"source": "f.fl", "fablet": "{1}"}}}},
  "materials": {{"white": {{"key": "#ffffff"}}, "black": {{"key": "#000000"}}}},
  "meshes": {{"mesh": {2}}},
  "objects": {{"{3}": {{"mesh": "mesh", "fablet": "f", "uniforms": {{"a": "white", "b": "black"}}}}}},
  "build": [{{"object": "{3}"}}]
}}
)",
                           printer, fablet, mesh, object);
    }
};

}  // namespace openfab::testing
