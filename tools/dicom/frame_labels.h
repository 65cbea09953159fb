// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the next frame of a file means: the next place, or another time, segment, echo, detector, energy
// window or whatever else a file's frames differ in (PS3.3, C.7.6.5, C.7.6.16, C.7.6.17, C.8.4.8).

#include <gdcmDataSet.h>

#include <cstdint>
#include <string>
#include <vector>

#include "base/result.h"
#include "tools/dicom/dicom_elements.h"
#include "tools/dicom/dicom_slice.h"

namespace openfab::tools {

/// How the frames of a file without functional groups follow each other, by its Frame Increment Pointer.
class FrameIncrement {
  public:
    /// Fails, without the file's name, where a list that it points at has not a number for each frame.
    Result<void> read(const gdcm::DataSet& set, int32_t frames);

    /// Whether it is along something that is not space.
    bool leaves_space() const { return !lists_.empty(); }
    /// Whether it says which slice each frame is.
    bool has_slices() const { return !slices_.empty(); }
    bool has_places() const { return !places_mm_.empty(); }
    /// The number of the frame's slice, from 0, and its place along the normal.
    int32_t slice(int32_t frame) const { return slices_[static_cast<size_t>(frame)] - 1; }
    double place_mm(int32_t frame) const { return places_mm_[static_cast<size_t>(frame)]; }
    /// The number of the frame's detector, from 1; 0 where it says none.
    size_t detector(int32_t frame) const;
    void add_labels(int32_t frame, std::vector<FrameLabel>* out) const;

  private:
    struct List {
        uint32_t source;
        const char* key;
        const char* name;
        std::vector<int32_t> numbers;
    };

    Result<void> read_one(const gdcm::DataSet& set, const gdcm::Tag& tag, int32_t frames);

    std::vector<List> lists_;
    std::vector<int32_t> slices_;
    std::vector<double> places_mm_;
};

/// What functional groups say of frames.
class GroupLabels {
  public:
    GroupLabels(const gdcm::DataSet& set, const FrameGroups& groups);

    /// Adds what the frame's groups say; `has_place`: one of them is its own position.
    void add_labels(int32_t frame, bool has_place, std::vector<FrameLabel>* out) const;

  private:
    struct Index {
        uint32_t source;
        std::string name;
        bool is_known;  ///< space, or added as something else
    };

    const FrameGroups& groups_;
    std::vector<Index> indices_;
};

/// Adds what a file of one frame says of itself.
void add_file_labels(const gdcm::DataSet& set, std::vector<FrameLabel>* out);

}  // namespace openfab::tools
