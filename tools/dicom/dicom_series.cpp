// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/dicom/dicom_slice.h"
#include "tools/texture/check_memory.h"
#include "tools/texture/guarded.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/write_volume.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Of a length in mm: what the decimals of a file leave open.
constexpr double kRounding_mm = 0.01;

Error named(const DicomSlice& slice, const Error& error) {
    return with_context(error, slice.file.filename().string() + ": ");
}
Error wrong(const DicomSlice& slice, const std::string& what) {
    return named(slice, user_error(what));
}
std::string name_of(const DicomSlice& slice) {
    return slice.file.filename().string();
}

/// The slices of one series; fails with the numbers of all where none is named.
Result<std::vector<DicomSlice>> one_series(std::vector<DicomSlice> slices,
                                           const std::string& number) {
    if (!number.empty()) {
        std::erase_if(slices, [&](const DicomSlice& slice) {
            return std::to_string(slice.series_number) != number;
        });
        if (slices.empty()) return user_error(fmt::format("it has no series {}", number));
    }
    std::set<std::string> series;
    std::set<int64_t> numbers;
    for (const DicomSlice& slice : slices) {
        series.insert(slice.series);
        numbers.insert(slice.series_number);
    }
    if (series.size() == 1) return slices;
    if (numbers.size() == 1)
        return user_error("its slices belong to several series; put each into a folder of its own");
    return user_error(fmt::format("its slices belong to series {}", fmt::join(numbers, ", ")),
                      "name one by `field`");
}

/// Fails where a slice's grid differs from the first one's.
Result<void> check_alike(const DicomSlice& first, const DicomSlice& slice) {
    if (slice.width != first.width || slice.height != first.height) {
        return wrong(slice, fmt::format("it has {} x {} pixels, {} has {} x {}", slice.width,
                                        slice.height, name_of(first), first.width, first.height));
    }
    // Far corners of both, in the same place of the plane.
    const double far = length((slice.across - first.across) * static_cast<double>(first.width)) +
                       length((slice.down - first.down) * static_cast<double>(first.height));
    if (far > kRounding_mm)
        return wrong(slice,
                     fmt::format("it is turned or spaced otherwise than {}", name_of(first)));
    return {};
}

/// Puts slices in order along their normal and finds the step between them.
Result<Vec3d> find_step(std::vector<DicomSlice>* slices) {
    const DicomSlice& any = slices->front();
    const Vec3d plane = cross(any.across, any.down);
    const Vec3d normal = plane * (1 / length(plane));
    std::stable_sort(slices->begin(), slices->end(), [&](const DicomSlice& a, const DicomSlice& b) {
        return dot(a.position, normal) < dot(b.position, normal);
    });
    const DicomSlice& first = slices->front();
    if (slices->size() == 1) return normal * (first.thickness_mm > 0 ? first.thickness_mm : 1.0);
    std::vector<double> steps;
    for (size_t i = 1; i < slices->size(); ++i) {
        const DicomSlice &below = (*slices)[i - 1], &slice = (*slices)[i];
        steps.push_back(dot(slice.position - below.position, normal));
        if (steps.back() < kRounding_mm)
            return wrong(slice, fmt::format("it lies where {} does", name_of(below)));
    }
    std::vector<double> sorted = steps;
    std::nth_element(sorted.begin(),
                     sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    const double usual = sorted[sorted.size() / 2];
    for (size_t i = 0; i < steps.size(); ++i) {
        // Scanners round positions; what is above a hundredth of a step is no rounding.
        if (std::abs(steps[i] - usual) <= std::max(kRounding_mm, usual / 100)) continue;
        return wrong((*slices)[i + 1],
                     fmt::format("it lies {:.3f} mm from {}, where slices are {:.3f} mm apart",
                                 steps[i], name_of((*slices)[i]), usual));
    }
    const Vec3d step =
        (slices->back().position - first.position) * (1 / static_cast<double>(slices->size() - 1));
    for (size_t i = 1; i < slices->size(); ++i) {
        const Vec3d off = (*slices)[i].position - first.position - step * static_cast<double>(i);
        if (length(off) > std::max(kRounding_mm, usual / 20))
            return wrong((*slices)[i], "it lies beside the line of the others");
    }
    return step;
}

class SeriesReader final : public VolumeReader {
  public:
    std::vector<DicomSlice> slices;

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const DicomSlice& slice = slices[static_cast<size_t>(z)];
        now_reading(slice.file);
        if (Result<void> read = read_dicom_pixels(slice, out); !read)
            return named(slice, read.error());
        wrote(4 * slice_floats());
        return {};
    }
};

/// Reads the slices' heads.
Result<std::vector<DicomSlice>> read_slices(const std::vector<fs::path>& files,
                                            const texture::ReadLimits& limits) {
    std::vector<DicomSlice> slices;
    for (const fs::path& file : files) {
        if (file.filename() == "DICOMDIR") continue;
        now_reading(file);
        Result<DicomSlice> slice = read_dicom_slice(file, limits.memory_bytes);
        if (!slice) return with_context(slice.error(), file.filename().string() + ": ");
        slices.push_back(std::move(*slice));
    }
    if (slices.empty()) return user_error("it has no slices");
    return slices;
}

}  // namespace

MadeReader open_dicom_series(const std::vector<fs::path>& files,
                             const texture::VolumeOptions& options,
                             const texture::ReadLimits& limits) {
    silence_dicom();
    Result<std::vector<DicomSlice>> all = read_slices(files, limits);
    if (!all) return all.error();
    Result<std::vector<DicomSlice>> slices = one_series(std::move(*all), options.field);
    if (!slices) return slices.error();
    for (const DicomSlice& slice : *slices) {
        if (Result<void> alike = check_alike(slices->front(), slice); !alike) return alike.error();
    }
    const Result<Vec3d> step = find_step(&*slices);
    if (!step) return step.error();
    const DicomSlice& first = slices->front();
    const GridFrame frame{first.position, {first.across, first.down, *step}};
    if (!is_along_axes(frame) && !options.outside) {
        return user_error("its slices are not along x, y and z, so that it is resampled",
                          "say by `outside` which value lies around it: -1000 is air");
    }
    auto reader = std::make_unique<SeriesReader>();
    reader->size = {first.width, first.height, static_cast<int32_t>(slices->size())};
    reader->slices = std::move(*slices);
    return place_reader(std::move(reader), frame, options, limits);
}

Result<void> make_dicom_volume_file(const fs::path& source, const fs::path& out,
                                    const texture::VolumeOptions& options,
                                    const texture::ReadLimits& limits) {
    const Result<std::vector<fs::path>> files = texture::volume_files(source);
    if (!files) return files.error();
    return write_volume(source, out, options, limits,
                        [&] { return open_dicom_series(*files, options, limits); });
}

}  // namespace openfab::tools
