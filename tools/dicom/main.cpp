// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture-dicom`: `openfab-texture` executes it for DICOM series, with its own arguments, and
// `openfab import` as `--segments FILE OUT`. It is separate because it links GDCM, which not every machine has.

#include <string_view>

#include "base/run_main.h"
#include "base/say.h"
#include "tools/dicom/dicom_series.h"
#include "tools/dicom/segment_list.h"
#include "tools/texture/command_line.h"
#include "tools/texture/guarded.h"

namespace {

int dicom_main(int argc, char** argv) {
    using namespace openfab;
    if (argc == 4 && std::string_view(argv[1]) == "--segments") {
        const texture::ReadLimits limits;
        const Result<void> done = tools::guarded(
            limits.memory_bytes, argv[2],
            [&] { return tools::write_segment_list(argv[2], argv[3], limits); }, argv[3]);
        return done ? 0 : say_error(done.error());
    }
    return openfab::tools::convert_guarded(argc, argv, openfab::tools::make_dicom_volume_file);
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(dicom_main, argc, argv);
}
