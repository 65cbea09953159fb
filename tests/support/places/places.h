// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the sources and programs of this build are. One source is told (places.cpp), so that all others compile to the same
// in every clone, and ccache has them.

#include <filesystem>
#include <string>

namespace openfab::testing {

std::filesystem::path source_dir();
/// Of the build, with `bin/` and `tests/` in it.
std::filesystem::path build_dir();

/// One that users run, such as `openfab`.
inline std::filesystem::path program(const std::string& name) {
    return build_dir() / "bin" / name;
}
/// One that only tests run.
inline std::filesystem::path test_program(const std::string& name) {
    return build_dir() / "tests" / name;
}

}  // namespace openfab::testing
