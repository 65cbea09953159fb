// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Functions of the standard library at single points, by the interpreter.

#include <array>
#include <bit>
#include <optional>
#include <string>

#include "abi/fablet_table.h"
#include "compiler/interp/evaluate.h"
#include "compiler/ir/ir.h"

namespace openfab::testing {

using Vec = std::array<double, 3>;

/// What a function sees: uniforms p (3 floats) and t.
class PointEnvironment : public interp::Environment {
  public:
    std::array<float, 4> values{};
    uint32_t input(int32_t kind, int32_t a, int32_t) const override {
        return kind == OPENFAB_ARG_UNIFORM ? std::bit_cast<uint32_t>(values.at(size_t(a))) : 0;
    }
    interp::TextureView texture(int32_t) const override { return {}; }
};

class LibraryFunction {
  public:
    /// Takes the body of a function that returns a float, with float3 p and float t in scope, and the names of the
    /// modules that it imports, with spaces between them, and functions of its own. Where it does not compile the test
    /// fails.
    LibraryFunction(const std::string& modules, const std::string& body,
                    const std::string& functions = "");
    /// Takes an expression in place of a body.
    static LibraryFunction of(const std::string& modules, const std::string& expression) {
        return {modules, "return " + expression + ";"};
    }

    /// NaN where it did not compile.
    double operator()(const Vec& p, double t = 0) const;

  private:
    std::optional<ir::Stage> stage_;
};

}  // namespace openfab::testing
