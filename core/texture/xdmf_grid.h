// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The structure of an XDMF file (versions 2 and 3), https://www.xdmf.org/index.php/XDMF_Model_and_Format:
// what its grid is made of, and where the numbers are. The cache reads the names of the data files from
// it, the converter everything else.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "texture/cache.h"

namespace openfab::texture {

/// Which numbers of an array are taken, along each of its sides.
struct XdmfSlab {
    std::vector<int64_t> sizes;  ///< of the array
    std::vector<int64_t> start, stride, count;
};

/// An array of numbers.
struct XdmfItem {
    enum class Kind { kSigned, kUnsigned, kFloat };
    std::vector<int64_t> sizes;  ///< each from 1, as is their product, up to 2^40
    int64_t count = 0;           ///< their product
    Kind kind = Kind::kFloat;
    int bytes = 4;  ///< of a number in a data file
    enum class Place { kHere, kDataFile, kHdf } place = Place::kHere;
    bool big_endian = false;
    int64_t seek = 0;              ///< bytes of the data file before the first number
    std::string text;              ///< the numbers, or the name of the data file
    std::string set;               ///< of an HDF5 file: where the numbers are in it
    std::optional<XdmfSlab> slab;  ///< else all numbers of that array
    Complaint wrong;  ///< why it cannot be read; only where it is wanted does that matter
};

struct XdmfField {
    std::string name;
    bool of_points = true;  ///< else of cells
    XdmfItem item;
};

struct XdmfGrid {
    std::string topology, geometry;     ///< their types, in lower case
    std::vector<int64_t> points_along;  ///< of a structured grid: z, y, x
    int64_t cells = 0;                  ///< of any other
    int64_t first_point = 0;            ///< the number by which cells name it
    Complaint wrong_topology;
    std::vector<XdmfItem> cell_items, point_items;
    std::vector<XdmfField> fields;  ///< of points and of cells
    int steps = 1;                  ///< of time, of which this is one

    /// Returns whether any of its numbers are in an HDF5 file.
    bool has_hdf() const;
    /// Lists its data files, relative to the folder of the file, each once.
    std::vector<std::string> data_files() const;
};

/// Returns whether a file is XDMF by its name.
bool is_xdmf(const std::filesystem::path& file);

/// Reads the one grid of the file; of several steps that of `time`, else the first, of several series of steps that
/// which has the field (xdmf_steps.h). It may
/// include cells and points of the first step, or of one other grid, which then has no fields. Fails
/// where there are several otherwise. Errors do not name the file.
Result<XdmfGrid> read_xdmf_grid(const InputFile& file, std::optional<double> time,
                                const std::string& field, const ReadLimits& limits);

}  // namespace openfab::texture
