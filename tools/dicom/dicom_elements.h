// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Values of GDCM's data sets.

#include <gdcmDataSet.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmSmartPointer.h>
#include <gdcmTag.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace openfab::tools {

using DicomItems = gdcm::SmartPointer<gdcm::SequenceOfItems>;

/// Returns an element's bytes, as long as the set lives; empty where there are none.
std::string_view bytes_of(const gdcm::DataSet& set, const gdcm::Tag& tag);

/// Returns text without its padding.
std::string_view trimmed(std::string_view text);

/// Parses `count` finite decimals that backslashes part, and no more.
bool parse_decimals(std::string_view text, double* out, size_t count);

/// Returns a number of 16 bits; `otherwise` where there is none.
int32_t short_of(const gdcm::DataSet& set, const gdcm::Tag& tag, int32_t otherwise);

/// Returns unsigned numbers of 2, 4 or 8 bytes each; what is left over is none.
std::vector<uint64_t> whole_numbers(std::string_view bytes, size_t each);

/// Returns the one binary number of 4 or 8 bytes, as its length says; nothing where there is another.
std::optional<double> binary_number(std::string_view bytes);

/// Returns a sequence; null where there is none.
DicomItems items_of(const gdcm::DataSet& set, const gdcm::Tag& tag);

/// The functional groups of a file of frames (PS3.3, C.7.6.16): what is said of one frame, of all, or,
/// in files that have no groups, at the top.
class FrameGroups {
  public:
    explicit FrameGroups(const gdcm::DataSet& set);

    /// Returns the bytes of `tag` in `group` of the frame, else in that of all frames, else at the top,
    /// else of the first detector (nuclear medicine); empty where it is nowhere.
    std::string find(int32_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const;
    /// Same, but of the frame alone.
    std::string find_own(int32_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const;
    /// Same, but of the frame, else of all frames.
    std::string find_grouped(int32_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const;
    /// Returns the items of a group, of the frame, of all frames or at the top; null where there are none.
    DicomItems items(int32_t frame, const gdcm::Tag& group) const;
    /// Whether the file says what its frames have in common, or each for itself.
    bool are_there() const { return shared_ != nullptr || frames_ != nullptr; }
    /// From now on detectors are asked from this one on, from 1.
    void use_detector(size_t number) { detector_ = number; }

  private:
    const gdcm::DataSet& set_;
    DicomItems shared_, frames_, detectors_;
    size_t detector_ = 1;
};

}  // namespace openfab::tools
