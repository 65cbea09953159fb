// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture-hdf5`: `openfab-texture` executes it for XDMF files whose numbers are in HDF5 files, and VTKHDF,
// with its own arguments. It is separate because it links HDF5, which not every machine has.

#include "base/run_main.h"
#include "tools/hdf5/hdf5_volume.h"
#include "tools/texture/command_line.h"

namespace {

int hdf5_main(int argc, char** argv) {
    return openfab::tools::convert_guarded(argc, argv, openfab::tools::make_hdf5_volume_file);
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(hdf5_main, argc, argv);
}
