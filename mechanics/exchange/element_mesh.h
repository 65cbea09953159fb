// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The elements of a part as a mesh of hexahedra that share their nodes, for other programs.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mechanics/part/part_problem.h"

namespace openfab::mechanics {

/// Labels of our own sets in an input file, upper-case: the last two with a number. No section's name begins
/// with one of these.
inline constexpr const char* kAllNodes = "NALL";
inline constexpr const char* kLoaded = "LOADED";
inline constexpr const char* kHeldPrefix = "HELD_";
inline constexpr const char* kMostPrefix = "MOST_";

/// Names of materials as formats with quotes have them: in one line, without quotes, unique.
std::vector<std::string> shown_names(const std::vector<std::string>& materials);

/// Elements that are alike: one section of an input file.
struct Section {
    std::string name;  ///< of letters, digits and `_`, unique in upper case, no label of ours
    double young_MPa = 0, poisson = 0, density_g_cm3 = 0;
};

struct ElementMesh {
    Grid grid;
    Vec3 origin_mm{};
    std::vector<int64_t> nodes;     ///< of the grid, that an element has, rising
    std::vector<int64_t> elements;  ///< of the grid, rising
    std::vector<int32_t> section;   ///< of each element
    std::vector<Section> sections;
    std::vector<std::string> materials;
    std::vector<uint8_t> material;  ///< of each element: the largest share, from 1
    std::vector<float> shares;      ///< [element][material]

    /// Corners of an element: those below, against the clock, then those above, as C3D8, VTK, gmsh and
    /// XDMF have them; places in `nodes`.
    std::array<int64_t, 8> corners(size_t element) const;
    Vec3 place_mm(size_t node) const;
    int64_t index_of(int64_t grid_node) const;
};

/// All elements with stiffness. Those of one material are a section of its name; mixtures are sections by
/// what they are like, to a thousandth where there are very many.
ElementMesh mesh_of(const Grid& grid, const Voxels& voxels);

/// What a case does, in the mesh's nodes.
struct MeshCase {
    std::string name;
    const PartProblem* problem = nullptr;
};

/// Abaqus' and CalculiX' input: nodes, C3D8, element sets, materials in MPa, mm and t/mm3; with a case
/// its holds, forces at nodes, and a static step.
Result<void> write_inp(const std::filesystem::path& file, const ElementMesh& mesh,
                       const std::optional<MeshCase>& load_case);
/// VTK's unstructured grid, with fields of elements.
Result<void> write_vtu(const std::filesystem::path& file, const ElementMesh& mesh);
/// gmsh's MSH 4.1, binary; a physical volume a material.
Result<void> write_msh(const std::filesystem::path& file, const ElementMesh& mesh);
/// XDMF 3 with its numbers as HDF5 beside it, FILE.h5.
Result<void> write_xdmf(const std::filesystem::path& file, const ElementMesh& mesh);

/// Fields of elements, for the formats that have such: young_MPa, poisson, density_g_cm3, and share_NAME.
std::vector<std::pair<std::string, std::vector<float>>> element_fields(const ElementMesh& mesh);

}  // namespace openfab::mechanics
