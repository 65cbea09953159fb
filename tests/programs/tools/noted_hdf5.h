// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// HDF5 files of which the reader tells something, as VTK writes image data, each one thing.

#include <string>

namespace openfab::testing {

enum class HdfField { kUnwritten, kWithGhosts, kLong };

/// Writes a field of two points, of which no chunk is written, which has ghosts beside it, or a number of more
/// digits than a float has.
void write_vtk_hdf(const std::string& path, HdfField kind);

/// A regular grid of two points whose field lies in a data set, FILE:SET.
inline std::string xdmf_of(const std::string& set) {
    return R"(<Xdmf><Domain><Grid><Topology TopologyType="3DCoRectMesh" Dimensions="1 1 2"/>
<Geometry GeometryType="ORIGIN_DXDYDZ"><DataItem Dimensions="3">0 0 0</DataItem><DataItem Dimensions="3">1 1 1</DataItem></Geometry>
<Attribute Name="f"><DataItem Dimensions="1 1 2" Format="HDF">)" +
           set + "</DataItem></Attribute></Grid></Domain></Xdmf>\n";
}

}  // namespace openfab::testing
