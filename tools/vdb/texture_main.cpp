// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture-vdb`: `openfab-texture` executes it for OpenVDB files, with its own arguments.

#include "base/run_main.h"
#include "tools/texture/command_line.h"
#include "tools/vdb/vdb_volume.h"

namespace {

int vdb_main(int argc, char** argv) {
    return openfab::tools::convert_guarded(argc, argv, openfab::tools::make_vdb_volume_file);
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(vdb_main, argc, argv);
}
