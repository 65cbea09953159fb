// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab-texture IMAGE -o FILE`: makes a filtered pyramid of an image, or with --check says whether it
// can; `openfab texture` executes
// this program. It is separate because it links OpenImageIO, which takes a third of a second and
// 130 MB to start: prints should not wait for it. Volumes that need a library which not every machine
// has go on to a converter of their own.

#include "base/clean_exit.h"
#include "base/run_main.h"
#include "base/say.h"
#include "tools/texture/command_line.h"
#include "tools/texture/convert.h"
#include "tools/texture/convert_volume.h"
#include "tools/texture/guarded.h"
#include "tools/texture/optional_converter.h"

namespace {

int texture_main(int argc, char** argv) {
    using namespace openfab::tools;
    openfab::prepare_streams();
    openfab::clean_up_on_signals();
    TextureJob job;
    if (const std::optional<int> code = parse_texture_job(argc, argv, &job)) return *code;
    const OptionalConverter* other =
        job.is_volume ? optional_converter(job.input, job.options) : nullptr;
    if (other != nullptr) return openfab::say_error(execute(*other, argv));
    const auto make = [&] {
        if (job.check) return check_picture_file(job.input, job.options.image, job.limits);
        return job.is_volume
                   ? make_volume_file(job.input, job.output, job.options, job.limits)
                   : make_pyramid_file(job.input, job.output, job.options.image, job.limits);
    };
    const openfab::Result<void> done =
        guarded(job.limits.memory_bytes, job.input, make, job.output);
    return done ? 0 : openfab::say_error(done.error());
}

}  // namespace

int main(int argc, char** argv) {
    return openfab::run_main(texture_main, argc, argv);
}
