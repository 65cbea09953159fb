// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/programs/tools/noted_hdf5.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <array>
#include <cstdint>

namespace openfab::testing {

void write_vtk_hdf(const std::string& path, HdfField kind) {
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t root = H5Gcreate2(file, "VTKHDF", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t text = H5Tcopy(H5T_C_S1), one = H5Screate(H5S_SCALAR);
    H5Tset_size(text, 9);
    const hid_t type = H5Acreate2(root, "Type", text, one, H5P_DEFAULT, H5P_DEFAULT);
    EXPECT_GE(H5Awrite(type, text, "ImageData"), 0);
    const hsize_t six = 6;
    const hid_t sides = H5Screate_simple(1, &six, nullptr);
    const hid_t extent =
        H5Acreate2(root, "WholeExtent", H5T_STD_I32LE, sides, H5P_DEFAULT, H5P_DEFAULT);
    const std::array<int, 6> corners{0, 1, 0, 0, 0, 0};
    EXPECT_GE(H5Awrite(extent, H5T_NATIVE_INT, corners.data()), 0);
    const hid_t points = H5Gcreate2(root, "PointData", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const std::array<hsize_t, 3> size{1, 1, 2};
    const hid_t space = H5Screate_simple(3, size.data(), nullptr);
    const hid_t layout = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_chunk(layout, 3, size.data());
    const auto add = [&](const char* name, hid_t stored, const std::array<int64_t, 2>& values) {
        const hid_t set = H5Dcreate2(points, name, stored, space, H5P_DEFAULT, layout, H5P_DEFAULT);
        if (kind != HdfField::kUnwritten) {
            EXPECT_GE(H5Dwrite(set, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
                      0);
        }
        H5Dclose(set);
    };
    const bool is_long = kind == HdfField::kLong;
    add("f", is_long ? H5T_STD_I64LE : H5T_IEEE_F32LE, {is_long ? (1 << 24) + 1 : 1, 0});
    if (kind == HdfField::kWithGhosts) add("vtkGhostType", H5T_STD_U8LE, {0, 1});
    for (const hid_t each : {type, extent})
        H5Aclose(each);
    for (const hid_t each : {one, sides, space})
        H5Sclose(each);
    for (const hid_t each : {points, root})
        H5Gclose(each);
    H5Pclose(layout);
    H5Tclose(text);
    H5Fclose(file);
}

}  // namespace openfab::testing
