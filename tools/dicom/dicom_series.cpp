// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/dicom/dicom_pixels.h"
#include "tools/dicom/dicom_slice.h"
#include "tools/dicom/messages.h"
#include "tools/dicom/series_list.h"
#include "tools/texture/guarded.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/write_volume.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// Of a length in mm: what the decimals of a file leave open.
constexpr double kRounding_mm = 0.01;

Error named(const DicomSlice& slice, const Error& error) {
    return with_context(error, slice.name() + ": ");
}

/// What is wrong with a slice that lies `step_mm` above another one, where `usual_mm` is usual.
Error gap(const DicomSlice& below, const DicomSlice& slice, double step_mm, double usual_mm,
          double tolerance_mm) {
    const double missing = std::round(step_mm / usual_mm) - 1;
    if (missing >= 1 && std::abs(step_mm - (missing + 1) * usual_mm) <= tolerance_mm) {
        const Vec3d &from = below.position, &to = slice.position;
        return user_error(fmt::format(messages::kSlicesMissing, missing,
                                      missing == 1 ? " is" : "s are", below.name(), from.x, from.y,
                                      from.z, slice.name(), to.x, to.y, to.z, step_mm, usual_mm),
                          messages::kSlicesMissingHelp);
    }
    return named(
        slice, user_error(fmt::format(messages::kSliceOutOfStep, step_mm, below.name(), usual_mm)));
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
        if (!(steps.back() >= kRounding_mm)) {
            return named(slice, user_error(fmt::format(messages::kSliceAtSamePlace, below.name()),
                                           messages::kSliceAtSamePlaceHelp));
        }
    }
    std::vector<double> sorted = steps;
    // Of two in the middle the lesser one, since what is missing only makes steps longer.
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double usual = *middle;
    for (size_t i = 0; i < steps.size(); ++i) {
        // Scanners round positions; what is above a hundredth of a step is no rounding.
        const double tolerance = std::max(kRounding_mm, usual / 100);
        if (std::abs(steps[i] - usual) <= tolerance) continue;
        return gap((*slices)[i], (*slices)[i + 1], steps[i], usual, tolerance);
    }
    const Vec3d step =
        (slices->back().position - first.position) * (1 / static_cast<double>(slices->size() - 1));
    for (size_t i = 1; i < slices->size(); ++i) {
        const Vec3d off = (*slices)[i].position - first.position - step * static_cast<double>(i);
        if (length(off) > std::max(kRounding_mm, usual / 20))
            return named((*slices)[i], user_error(messages::kSliceBesideLine));
    }
    return step;
}

class SeriesReader final : public VolumeReader {
  public:
    SeriesReader(std::vector<DicomSlice> slices, int64_t memory_bytes)
        : slices_(std::move(slices)), pixels_(memory_bytes) {
        const DicomImage& image = *slices_.front().image;
        size = {image.width, image.height, static_cast<int32_t>(slices_.size())};
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const DicomSlice& slice = slices_[static_cast<size_t>(z)];
        now_reading(slice.image->file);
        if (Result<void> read = pixels_.read(slice, out); !read) return named(slice, read.error());
        wrote(4 * slice_floats());
        return {};
    }

  private:
    std::vector<DicomSlice> slices_;
    DicomPixels pixels_;
};

Result<std::vector<DicomHead>> read_heads(const std::vector<fs::path>& files,
                                          const texture::ReadLimits& limits) {
    std::vector<DicomHead> heads;
    for (const fs::path& file : files) {
        now_reading(file);
        Result<DicomHead> head = read_dicom_head(file, limits.memory_bytes);
        if (!head) return with_context(head.error(), file.filename().string() + ": ");
        heads.push_back(std::move(*head));
    }
    return heads;
}

Error trouble_of(const DicomHead& head) {
    return with_context(*head.trouble, head.file.filename().string() + ": ");
}

/// Why no file of a folder has slices: of a file that might have some, or that is the only one, its own
/// trouble.
Error no_slices(const std::vector<DicomHead>& heads) {
    const auto scan = std::find_if(heads.begin(), heads.end(),
                                   [](const DicomHead& head) { return !head.is_foreign; });
    if (scan != heads.end()) return trouble_of(*scan);
    if (heads.size() == 1 && heads.front().file.filename() != "DICOMDIR")
        return trouble_of(heads.front());
    return user_error(messages::kNoSlices, messages::kNoSlicesHelp);
}

/// Tells which files were passed over. Fails where one of them may belong to the series.
Result<void> pass_over(const std::vector<DicomHead>& heads, const std::string& series) {
    std::vector<std::string> foreign, others;
    for (const DicomHead& head : heads) {
        if (!head.slices.empty()) continue;
        if (!head.is_foreign && (head.series.empty() || head.series == series))
            return trouble_of(head);
        const std::string name = head.file.filename().string();
        head.is_foreign ? foreign.push_back(name)
                        : others.push_back(fmt::format("{} ({})", name, head.trouble->message));
    }
    const std::string folder = heads.front().file.parent_path().filename().string();
    if (!foreign.empty())
        tell(fmt::format(messages::kPassedOverNoSlices, folder, list_some(foreign)));
    if (!others.empty())
        tell(fmt::format(messages::kPassedOverOtherSeries, folder, list_some(others)));
    return {};
}

/// Checks that the pixels of all files are there, before any is read, and tells what is special of them.
Result<void> check_files(const std::vector<DicomSlice>& slices) {
    const DicomImage* last = nullptr;
    std::vector<std::string> unplaced, inverted;
    for (const DicomSlice& slice : slices) {
        const DicomImage& image = *slice.image;
        if (&image == last) continue;
        last = &image;
        now_reading(image.file);
        const std::string name = image.file.filename().string();
        if (Result<void> whole = check_pixels(image); !whole)
            return with_context(whole.error(), name + ": ");
        if (!image.is_placed) unplaced.push_back(name);
        if (image.is_inverted) inverted.push_back(name);
    }
    if (!unplaced.empty()) tell(fmt::format(messages::kPlaceUnknown, list_some(unplaced)));
    if (!inverted.empty()) tell(fmt::format(messages::kStoredMonochrome1, list_some(inverted)));
    return {};
}

}  // namespace

MadeReader open_dicom_series(const std::vector<fs::path>& files,
                             const texture::VolumeOptions& options,
                             const texture::ReadLimits& limits) {
    silence_dicom();
    const Result<std::vector<DicomHead>> heads = read_heads(files, limits);
    if (!heads) return heads.error();
    std::vector<DicomSlice> all;
    for (const DicomHead& head : *heads)
        all.insert(all.end(), head.slices.begin(), head.slices.end());
    if (all.empty()) return no_slices(*heads);
    Result<std::vector<DicomSlice>> slices = choose_series(std::move(all), options.field);
    if (!slices) {
        // Of a series that is there, but cannot be read.
        const auto wanted = std::find_if(heads->begin(), heads->end(), [&](const DicomHead& head) {
            return head.slices.empty() && !options.field.empty() &&
                   std::find(head.names.begin(), head.names.end(), options.field) !=
                       head.names.end();
        });
        return wanted == heads->end() ? slices.error() : trouble_of(*wanted);
    }
    if (Result<void> passed = pass_over(*heads, slices->front().image->series); !passed)
        return passed.error();
    if (Result<void> whole = check_files(*slices); !whole) return whole.error();
    const Result<Vec3d> step = find_step(&*slices);
    if (!step) return step.error();
    const DicomSlice& first = slices->front();
    const GridFrame frame{first.position, {first.across, first.down, *step}};
    if (!is_along_axes(frame) && !options.outside) {
        return user_error(messages::kObliqueSlices, messages::kObliqueSlicesHelp);
    }
    return place_reader(std::make_unique<SeriesReader>(std::move(*slices), limits.memory_bytes),
                        frame, options, limits);
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
