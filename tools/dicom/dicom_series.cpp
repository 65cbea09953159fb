// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "tools/dicom/choose_frames.h"
#include "tools/dicom/dicom_pixels.h"
#include "tools/dicom/dicom_slice.h"
#include "tools/dicom/messages.h"
#include "tools/dicom/series_list.h"
#include "tools/dicom/slice_stack.h"
#include "tools/texture/guarded.h"
#include "tools/texture/placed_grid.h"
#include "tools/texture/write_volume.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

Error named(const DicomSlice& slice, const Error& error) {
    return with_context(error, slice.name() + ": ");
}

class SeriesReader final : public VolumeReader {
  public:
    SeriesReader(SliceStack stack, std::optional<double> outside, int64_t memory_bytes)
        : stack_(std::move(stack)), outside_(outside), pixels_(memory_bytes) {
        const DicomImage& image = *stack_.slices.front().image;
        size = {image.width, image.height, static_cast<int32_t>(stack_.planes.size())};
    }

    Result<void> read_slice(int32_t z, float* out, const Wrote& wrote) override {
        const StackPlane& plane = stack_.planes[static_cast<size_t>(z)];
        if (plane.below < 0) {
            // Of a label map such a plane has the label 0.
            const bool is_chosen = stack_.slices.front().only == 0;
            std::fill_n(out, slice_floats(), is_chosen ? 1.0F : 0.0F);
        } else if (plane.share == 0) {
            if (Result<void> read = read_into(plane.below, out); !read) return read;
        } else if (Result<void> mixed = mix(plane, out); !mixed) {
            return mixed;
        }
        wrote(4 * slice_floats());
        if (z + 1 == size.z && pixels_.has_rounded())
            tell(fmt::format(messages::kRounded, stack_.slices.front().image->label));
        return {};
    }

  private:
    Result<void> read_into(int32_t index, float* out) {
        const DicomSlice& slice = stack_.slices[static_cast<size_t>(index)];
        now_reading(slice.image->file);
        if (Result<void> read = pixels_.read(slice, out); !read) return named(slice, read.error());
        for (int64_t i = 0; i < slice_floats(); ++i) {
            if (!std::isnan(out[i])) continue;
            if (outside_) {
                out[i] = static_cast<float>(*outside_);
                continue;
            }
            return named(slice,
                         user_error(slice.range ? messages::kNotMapped : messages::kValueNotANumber,
                                    messages::kGiveOutside));
        }
        return {};
    }

    /// A plane between two slices.
    Result<void> mix(const StackPlane& plane, float* out) {
        std::vector<float> above(static_cast<size_t>(slice_floats()));
        if (Result<void> read = read_into(plane.below, out); !read) return read;
        if (Result<void> read = read_into(plane.below + 1, above.data()); !read) return read;
        for (size_t i = 0; i < above.size(); ++i) {
            const auto low = static_cast<double>(out[i]), high = static_cast<double>(above[i]);
            out[i] = static_cast<float>(low + plane.share * (high - low));
        }
        return {};
    }

    SliceStack stack_;
    std::optional<double> outside_;
    DicomPixels pixels_;
};

/// The folder that all files lie in or below.
fs::path common_folder(const std::vector<fs::path>& files) {
    fs::path folder = files.front().parent_path();
    for (const fs::path& file : files) {
        while (!folder.empty() && folder != folder.root_path() &&
               *file.lexically_relative(folder).begin() == "..")
            folder = folder.parent_path();
    }
    return folder;
}

Result<std::vector<DicomHead>> read_heads(const std::vector<fs::path>& files,
                                          const texture::ReadLimits& limits) {
    std::vector<DicomHead> heads;
    const fs::path folder = common_folder(files);
    for (const fs::path& file : files) {
        now_reading(file);
        const std::string label =
            folder.empty() ? file.string() : file.lexically_relative(folder).string();
        Result<DicomHead> head = read_dicom_head(file, label, limits.memory_bytes);
        if (!head) return with_context(head.error(), label + ": ");
        heads.push_back(std::move(*head));
    }
    return heads;
}

Error trouble_of(const DicomHead& head) {
    return with_context(*head.trouble, head.label + ": ");
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

std::string common_folder_name(const std::vector<DicomHead>& heads) {
    std::vector<fs::path> files;
    for (const DicomHead& head : heads)
        files.push_back(head.file);
    return common_folder(files).filename().string();
}

/// Tells which files were passed over. Fails where one of them may belong to the series.
Result<void> pass_over(const std::vector<DicomHead>& heads, const std::string& series) {
    std::vector<std::string> foreign, others;
    for (const DicomHead& head : heads) {
        if (!head.slices.empty()) continue;
        if (!head.is_foreign && (head.series.empty() || head.series == series))
            return trouble_of(head);
        const std::string& name = head.label;
        head.is_foreign ? foreign.push_back(name)
                        : others.push_back(fmt::format("{} ({})", name, head.trouble->message));
    }
    const std::string folder = common_folder_name(heads);
    if (!foreign.empty())
        tell(fmt::format(messages::kPassedOverNoSlices, folder, list_some(foreign)));
    if (!others.empty())
        tell(fmt::format(messages::kPassedOverOtherSeries, folder, list_some(others)));
    return {};
}

/// Checks that the pixels of all files are there, before any is read, and tells what is special of them.
Result<void> check_files(const std::vector<DicomSlice>& slices) {
    const DicomImage* last = nullptr;
    std::vector<std::string> unplaced, inverted, in_volume, contiguous, other_values, relative,
        longer;
    for (const DicomSlice& slice : slices) {
        const DicomImage& image = *slice.image;
        if (&image == last) continue;
        last = &image;
        now_reading(image.file);
        if (Result<void> whole = check_pixels(slice.image.get()); !whole)
            return with_context(whole.error(), image.label + ": ");
        if (!image.is_placed) unplaced.push_back(image.label);
        if (image.is_inverted) inverted.push_back(image.label);
        if (image.is_in_volume) in_volume.push_back(image.label);
        if (image.is_contiguous) contiguous.push_back(image.label);
        if (image.is_relative) relative.push_back(image.label);
        // Fewer bytes fill the file up.
        if (image.behind_bytes >= image.frame_bytes()) longer.push_back(image.label);
        if (image.has_other_values) other_values.push_back(image.label);
    }
    const std::pair<const char*, const std::vector<std::string>*> notes[] = {
        {messages::kPlaceUnknown, &unplaced},    {messages::kStoredMonochrome1, &inverted},
        {messages::kPlaceOfVolume, &in_volume},  {messages::kContiguous, &contiguous},
        {messages::kOtherValues, &other_values}, {messages::kRelativeDose, &relative},
        {messages::kPixelsBehind, &longer},
    };
    for (const auto& [text, names] : notes) {
        if (!names->empty()) tell(fmt::format(fmt::runtime(text), list_some(*names)));
    }
    return {};
}

/// The slices of the series that is wanted, of one volume. A field may name a segment, where no series has
/// that name.
Result<std::vector<DicomSlice>> choose_slices(const std::vector<DicomHead>& heads,
                                              std::vector<DicomSlice> all,
                                              texture::VolumeOptions options) {
    if (!options.field.empty() && options.segment.empty() && !names_series(all, options.field) &&
        names_segment(all, options.field))
        std::swap(options.segment, options.field);
    Result<std::vector<DicomSlice>> slices = choose_series(std::move(all), options.field);
    if (!slices) {
        // Of a series that is there, but cannot be read.
        const auto wanted = std::find_if(heads.begin(), heads.end(), [&](const DicomHead& head) {
            return head.slices.empty() && !options.field.empty() &&
                   std::find(head.names.begin(), head.names.end(), options.field) !=
                       head.names.end();
        });
        return wanted == heads.end() ? slices.error() : trouble_of(*wanted);
    }
    return choose_frames(std::move(*slices), options);
}

/// Whether a grid that is turned is sampled anew.
Result<void> check_turned(const SliceStack& stack, const texture::VolumeOptions& options) {
    const DicomSlice& first = stack.slices.front();
    const Vec3i size{first.image->width, first.image->height,
                     static_cast<int32_t>(stack.planes.size())};
    if (is_along_axes(stack.frame, size)) return {};
    // Nothing lies around a segment.
    if (first.image->kind == DicomKind::kSegmentation || first.only) return {};
    if (first.image->kind == DicomKind::kLabelMap)
        return user_error(messages::kObliqueLabels, messages::kObliqueLabelsHelp);
    if (!options.outside) return user_error(messages::kObliqueSlices, messages::kObliqueSlicesHelp);
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
    Result<std::vector<DicomSlice>> slices = choose_slices(*heads, std::move(all), options);
    if (!slices) return slices.error();
    if (Result<void> passed = pass_over(*heads, slices->front().image->series); !passed)
        return passed.error();
    if (Result<void> whole = check_files(*slices); !whole) return whole.error();
    Result<SliceStack> stack = stack_slices(std::move(*slices));
    if (!stack) return stack.error();
    if (Result<void> turned = check_turned(*stack, options); !turned) return turned.error();
    const GridFrame frame = stack->frame;
    MadeReader reader = place_reader(
        std::make_unique<SeriesReader>(std::move(*stack), options.outside, limits.memory_bytes),
        frame, options, limits);
    if (reader) (*reader)->in_mm = true;
    return reader;
}

Result<void> make_dicom_volume_file(const fs::path& source, const fs::path& out,
                                    const texture::VolumeOptions& options,
                                    const texture::ReadLimits& limits) {
    const Result<std::vector<fs::path>> files = texture::volume_files(source);
    if (!files) return files.error();
    return write_volume(
        source, out, options, limits, [&] { return open_dicom_series(*files, options, limits); },
        true);
}

}  // namespace openfab::tools
