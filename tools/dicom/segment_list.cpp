// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/segment_list.h"

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <set>
#include <string_view>
#include <vector>

#include "base/json_text.h"
#include "texture/volume.h"
#include "tools/dicom/dicom_series.h"
#include "tools/dicom/dicom_slice.h"
#include "tools/dicom/messages.h"
#include "tools/texture/guarded.h"

namespace openfab::tools {

namespace {

/// The numbers of segments that are anywhere: of labels, those of pixels, where they lie along the axes.
Result<std::set<int32_t>> used_segments(const DicomHead& head, const texture::ReadLimits& limits) {
    std::set<int32_t> out;
    const DicomImage& image = *head.slices.front().image;
    const auto all = [&] {
        for (const DicomSegment& segment : image.segments)
            out.insert(segment.number);
        return out;
    };
    for (const DicomSlice& slice : head.slices) {
        if (const FrameLabel* label = slice.label(kSegmentLabel))
            out.insert(static_cast<int32_t>(label->value));
    }
    if (image.kind != DicomKind::kLabelMap) return out;
    const MadeReader reader = open_dicom_series({head.file}, {}, limits);
    if (!reader) return all();
    std::vector<float> texels(static_cast<size_t>((*reader)->slice_floats()));
    for (int32_t z = 0; z < (*reader)->size.z; ++z) {
        if (Result<void> read = (*reader)->read_slice(z, texels.data(), [](int64_t) {}); !read)
            return read.error();
        for (const float label : texels)
            out.insert(static_cast<int32_t>(label));
    }
    return out;
}

}  // namespace

Result<void> write_segment_list(const std::filesystem::path& file, const std::filesystem::path& out,
                                const texture::ReadLimits& limits) {
    silence_dicom();
    const std::string name = file.filename().string();
    const Result<DicomHead> head = read_dicom_head(file, name, limits.memory_bytes);
    if (!head) return head.error();
    if (head->trouble) return *head->trouble;
    const DicomImage& image = *head->slices.front().image;
    if (image.segments.empty())
        return user_error(messages::kNoSegmentation, messages::kNoSegmentationHelp);
    const Result<std::set<int32_t>> used = used_segments(*head, limits);
    if (!used) return used.error();
    texture::VolumeOptions options;
    options.segment = std::to_string(image.segments.front().number);
    const MadeReader reader = open_dicom_series({file}, options, limits);
    if (!reader) return reader.error();
    const VolumeReader& volume = **reader;
    const std::array<double, 3> step = volume.spacing.value_or(std::array<double, 3>{1, 1, 1});
    JsonText text;
    text.begin_object().key("size_mm").begin_array();
    for (size_t a = 0; a < 3; ++a)
        text.value(step[a] * volume.size[static_cast<int>(a)]);
    text.end_array().key("segments").begin_array();
    for (const DicomSegment& segment : image.segments) {
        if (segment.number == 0) continue;  // what lies around the others
        if (!used->contains(segment.number)) {
            tell(fmt::format(messages::kSegmentNowhere, segment.number, segment.label));
            continue;
        }
        text.begin_object().member("number", segment.number);
        text.member("label", std::string_view(segment.label));
        if (const auto& c = segment.color)
            text.member("color", std::string_view(fmt::format("#{:02x}{:02x}{:02x}", (*c)[0],
                                                              (*c)[1], (*c)[2])));
        text.end_object();
    }
    text.end_array().end_object();
    std::ofstream file_out(out, std::ios::binary);
    file_out << text.take();
    if (!file_out.flush())
        return outside_error(fmt::format(messages::kCannotWriteList, out.string()));
    return {};
}

}  // namespace openfab::tools
