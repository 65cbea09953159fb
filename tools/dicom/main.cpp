// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture-dicom`: `openfab-texture` executes it for DICOM series, with its own arguments. It
// is separate because it links GDCM, which not every machine has.

#include "base/run_main.h"
#include "tools/dicom/dicom_series.h"
#include "tools/texture/command_line.h"

namespace {

int dicom_main(int argc, char** argv) {
    return openfab::tools::convert_guarded(argc, argv, openfab::tools::make_dicom_volume_file);
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(dicom_main, argc, argv);
}
