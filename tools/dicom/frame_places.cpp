// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/frame_places.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/frame_labels.h"
#include "tools/dicom/frame_values.h"
#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

/// Of a length in mm: what the decimals of a file leave open.
constexpr double kRounding_mm = 0.01;

class Places {
  public:
    Places(const gdcm::DataSet& set, DicomImage* image)
        : set_(set),
          groups_(set),
          labels_(set, groups_),
          values_(set, groups_, image),
          image_(image),
          offsets_(bytes_of(set, {0x3004, 0x000c})) {}

    Result<void> open() {
        image_->has_offsets = !offsets_.empty();
        image_->is_in_volume = !groups_.find_grouped(0, kInVolume, kInVolumeTag).empty();
        if (groups_.are_there()) return {};
        return increment_.read(set_, image_->frames);
    }

    Result<void> read(int32_t frame, DicomSlice* out) {
        if (const size_t detector = increment_.detector(frame); detector > 0)
            groups_.use_detector(detector);
        if (Result<void> plane = read_plane(frame, out); !plane) return plane;
        const bool own = !groups_.find_own(frame, group(), position()).empty();
        if (image_->frames > 1 && !own) {
            if (Result<void> moved = move_along_normal(frame, out); !moved) return moved;
        }
        out->stack = trimmed(groups_.find_grouped(frame, {0x0020, 0x9111}, {0x0020, 0x9056}));
        if (groups_.are_there()) {
            labels_.add_labels(frame, own, &out->labels);
        } else if (image_->frames > 1) {
            increment_.add_labels(frame, &out->labels);
        } else {
            add_file_labels(set_, &out->labels);
        }
        return values_.read(frame, out);
    }

  private:
    const gdcm::Tag kPosition{0x0020, 0x9113}, kPositionTag{0x0020, 0x0032};
    const gdcm::Tag kInVolume{0x0020, 0x930e}, kInVolumeTag{0x0020, 0x9301};
    const gdcm::Tag kMeasures{0x0028, 0x9110};

    const gdcm::Tag& group() const { return image_->is_in_volume ? kInVolume : kPosition; }
    const gdcm::Tag& position() const { return image_->is_in_volume ? kInVolumeTag : kPositionTag; }

    Result<void> read_plane(int32_t frame, DicomSlice* out) {
        std::array<double, 3> position{};
        std::array<double, 6> axes{1, 0, 0, 0, 1, 0};
        std::array<double, 2> spacing{};
        const std::string where = place_of(frame);
        const std::string turned = orientation_of(frame);
        // Frames of one file are in place towards each other without it.
        if (frame == 0)
            image_->is_placed = image_->frames == 1 || !where.empty() || !turned.empty();
        if (image_->is_placed && !numbers(where, position.data(), 3))
            return user_error(messages::kNoImagePosition);
        if (image_->is_placed && !numbers(turned, axes.data(), 6))
            return user_error(messages::kNoImageOrientation);
        if (!parse_decimals(groups_.find(frame, kMeasures, {0x0028, 0x0030}), spacing.data(), 2) ||
            !(spacing[0] > 0) || !(spacing[1] > 0))
            return user_error(messages::kNoPixelSpacing);
        out->position = {position[0], position[1], position[2]};
        const Vec3d across{axes[0], axes[1], axes[2]}, down{axes[3], axes[4], axes[5]};
        constexpr double kRounding = 1e-3;
        if (!(std::abs(length(across) - 1) <= kRounding) ||
            !(std::abs(length(down) - 1) <= kRounding) ||
            !(std::abs(dot(across, down)) <= kRounding))
            return user_error(messages::kOrientationNotOrthogonal);
        // Between rows first, then between columns.
        out->down = down * spacing[0];
        out->across = across * spacing[1];
        const std::string thickness = groups_.find(frame, kMeasures, {0x0018, 0x0050});
        if (!trimmed(thickness).empty() && !parse_decimals(thickness, &out->thickness_mm, 1))
            return user_error(messages::kThicknessNotANumber);
        const std::string distance = groups_.find(frame, kMeasures, {0x0018, 0x0088});
        if (!trimmed(distance).empty() && !parse_decimals(distance, &out->spacing_mm, 1))
            return user_error(messages::kFrameDistanceNotANumber);
        return {};
    }

    std::string place_of(int32_t frame) const { return groups_.find(frame, group(), position()); }
    std::string orientation_of(int32_t frame) const {
        if (image_->is_in_volume) return groups_.find(frame, {0x0020, 0x930f}, {0x0020, 0x9302});
        return groups_.find(frame, {0x0020, 0x9116}, {0x0020, 0x0037});
    }

    /// Of a volume they are binary, of a patient text.
    bool numbers(const std::string& bytes, double* out, size_t count) const {
        if (!image_->is_in_volume) return parse_decimals(bytes, out, count);
        if (bytes.size() != count * sizeof(double)) return false;
        for (size_t i = 0; i < count; ++i) {
            const std::optional<double> value =
                binary_number(std::string_view(bytes).substr(i * sizeof(double), sizeof(double)));
            if (!value || !std::isfinite(*value)) return false;
            out[i] = *value;
        }
        return true;
    }

    /// Moves a frame that does not state its own position to where it lies by the file's lists or its
    /// one distance. A position that all frames state stands for each of them.
    Result<void> move_along_normal(int32_t frame, DicomSlice* out) {
        const Vec3d plane = cross(out->across, out->down);
        const Vec3d normal = plane * (1 / length(plane));
        if (!offsets_.empty()) return move_by_offset(frame, normal, out);
        if (groups_.are_there() && !groups_.find_grouped(0, group(), position()).empty()) return {};
        if (increment_.has_places()) {
            const double along = increment_.place_mm(frame) - increment_.place_mm(0);
            out->position = out->position + normal * along;
            return {};
        }
        if (increment_.leaves_space() && !increment_.has_slices()) return {};
        double step = out->spacing_mm;
        if (step == 0 && increment_.has_slices()) {
            // Slices of tomography follow each other without a distance between them.
            step = out->thickness_mm;
            image_->is_contiguous = true;
        }
        if (step == 0) return user_error(messages::kNoSliceSpacing);
        const int32_t slice = increment_.has_slices() ? increment_.slice(frame) : frame;
        out->position = out->position + normal * (step * slice);
        return {};
    }

    /// Doses (PS3.3, C.8.8.3.2): the first offset is 0, or all are positions along z of the patient.
    Result<void> move_by_offset(int32_t frame, const Vec3d& normal, DicomSlice* out) {
        const auto count = static_cast<size_t>(image_->frames);
        if (offset_.empty()) {
            offset_.resize(count);
            if (!parse_decimals(offsets_, offset_.data(), count))
                return user_error(fmt::format(messages::kFrameOffsets, count));
        }
        const double along = offset_[static_cast<size_t>(frame)], first = offset_[0];
        if (first == 0) {
            out->position = out->position + normal * along;
            return {};
        }
        constexpr double kStraight = 1e-4;
        if (std::abs(std::abs(normal.z) - 1) > kStraight ||
            std::abs(first - out->position.z) > kRounding_mm)
            return user_error(fmt::format(messages::kFrameOffsetsStart, first));
        out->position.z += along - first;
        return {};
    }

    const gdcm::DataSet& set_;
    FrameGroups groups_;
    GroupLabels labels_;
    FrameValues values_;
    FrameIncrement increment_;
    DicomImage* image_;
    std::string_view offsets_;
    std::vector<double> offset_;
};

}  // namespace

Result<std::vector<DicomSlice>> read_frames(const gdcm::DataSet& set,
                                            const std::shared_ptr<DicomImage>& image) {
    std::vector<DicomSlice> slices(static_cast<size_t>(image->frames));
    Places places(set, image.get());
    if (Result<void> opened = places.open(); !opened) return opened.error();
    for (int32_t frame = 0; frame < image->frames; ++frame) {
        DicomSlice& slice = slices[static_cast<size_t>(frame)];
        slice.image = image;
        slice.frame = frame;
        if (Result<void> place = places.read(frame, &slice); !place) {
            if (image->frames == 1) return place.error();
            return with_context(place.error(), fmt::format(messages::kInFrame, frame + 1));
        }
    }
    return slices;
}

}  // namespace openfab::tools
