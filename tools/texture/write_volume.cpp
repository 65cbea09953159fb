// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/write_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <new>

#include "base/units.h"
#include "texture/pyramid_file.h"
#include "texture/reading_progress.h"
#include "texture/xdmf_grid.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Checks that all slices are read and finite. NaN is no value, and becomes `outside`, where that is given.
Result<void> fill(const std::string& name, std::optional<double> outside, VolumeReader* volume,
                  texture::PyramidWriter* writer) {
    texture::ReadingProgress progress(name);
    const auto wrote = [&](int64_t bytes) { writer->wrote(bytes); };
    constexpr int64_t kAtOnce = 1 << 16;
    for (int32_t z = 0; z < volume->size.z; ++z) {
        const int64_t count = volume->slice_floats();
        float* slice = writer->level0() + z * count;
        if (Result<void> read = volume->read_slice(z, slice, wrote); !read) return read;
        for (int64_t begin = 0; begin < count; begin += kAtOnce) {
            const int64_t end = std::min(begin + kAtOnce, count);
            if (outside) {
                std::replace_if(
                    slice + begin, slice + end, [](float x) { return std::isnan(x); },
                    static_cast<float>(*outside));
            }
            if (!std::all_of(slice + begin, slice + end, [](float x) { return std::isfinite(x); }))
                return user_error(messages::kValueNotFinite);
            wrote(4 * (end - begin));
        }
        progress.at(static_cast<double>(z + 1) / volume->size.z);
    }
    return {};
}

/// The option that is given of those that choose frames of DICOM; empty where there is none.
std::string frame_key(const texture::VolumeOptions& options) {
    if (!options.segment.empty()) return "segment";
    if (options.echo) return "echo";
    if (options.detector) return "detector";
    if (options.energy_window) return "energy_window";
    return options.phase ? "phase" : "";
}

Result<void> convert(const fs::path& source, const fs::path& out,
                     const texture::VolumeOptions& options, const texture::ReadLimits& limits,
                     const std::function<MadeReader()>& open, bool has_frames) {
    const auto bad = [&](const Error& error) {
        return with_context(error, fmt::format(messages::kCannotReadBefore, source.string()));
    };
    if (options.time && !has_frames && !texture::is_xdmf(source))
        return bad(user_error(messages::kNoStepsOfTime, messages::kNoStepsOfTimeHelp));
    if (const std::string key = frame_key(options); !key.empty() && !has_frames) {
        return bad(user_error(fmt::format(messages::kNoFramesToChoose, key),
                              fmt::format(messages::kNoFramesToChooseHelp, key)));
    }
    MadeReader reader = open();
    if (!reader) return bad(reader.error());
    VolumeReader& volume = **reader;
    const std::tuple<bool, const char*, const char*> idle[] = {
        {!options.field.empty() && volume.one_field, "field", messages::kNamedFields},
        {!options.unit.empty() && volume.no_lengths, "unit", messages::kUnitOfLengths},
        {!options.unit.empty() && volume.in_mm, "unit", messages::kLengthsInAnyUnit},
        {options.outside && volume.no_nan, "outside", messages::kPlacesWithoutValue},
    };
    for (const auto& [is_idle, name, what] : idle) {
        if (!is_idle) continue;
        return bad(user_error(fmt::format(messages::kKeyWithoutEffect, what, name),
                              fmt::format(messages::kKeyWithoutEffectHelp, name)));
    }
    if (options.pitch_mm > 0 && !volume.resampled)
        return bad(user_error(messages::kPitchWithoutEffect, messages::kPitchWithoutEffectHelp));
    const std::array<double, 3> one{1, 1, 1}, zero{};
    const std::array<double, 3> spacing = options.spacing_mm.value_or(volume.spacing.value_or(one));
    const std::array<double, 3> origin = options.origin_mm.value_or(volume.origin.value_or(zero));
    texture::VolumeDomain domain;
    domain.table = volume.table;
    for (size_t a = 0; a < 3; ++a) {
        domain.origin[a] = static_cast<float>(origin[a]);
        domain.extent[a] = static_cast<float>(spacing[a] * volume.size[static_cast<int>(a)]);
    }
    const Result<texture::PyramidLayout> layout =
        texture::volume_layout(volume.size, volume.channels, domain);
    if (!layout) return bad(layout.error());
    if (Result<void> fits = check_memory(texture::pyramid_file_bytes(*layout), limits.memory_bytes);
        !fits)
        return bad(fits.error());
    const Result<uint64_t> key = texture::volume_key(source, options, limits);
    if (!key) return key.error();
    Result<std::unique_ptr<texture::PyramidWriter>> writer =
        texture::PyramidWriter::create(out, *layout, *key);
    if (!writer) return writer.error();
    if (Result<void> read =
            fill(source.filename().string(), options.outside, &volume, writer->get());
        !read)
        return bad(read.error());
    if (volume.rounded) tell(fmt::format(messages::kIntegersRounded, source.filename().string()));
    return (*writer)->finish();
}

}  // namespace

Result<void> write_volume(const fs::path& source, const fs::path& out,
                          const texture::VolumeOptions& options, const texture::ReadLimits& limits,
                          const std::function<MadeReader()>& open, bool has_frames) {
    try {
        return convert(source, out, options, limits, open, has_frames);
    } catch (const std::bad_alloc&) {
        return user_error(fmt::format(messages::kCannotReadMemory, source.string(),
                                      format_bytes(limits.memory_bytes)),
                          messages::kCannotReadMemoryHelp);
    } catch (const std::exception& e) {
        return user_error(fmt::format(messages::kCannotRead, source.string(), e.what()));
    }
}

}  // namespace openfab::tools
