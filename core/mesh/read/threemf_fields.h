// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Functions, level sets and volumetric data of a 3MF file, as written (volumetric extension, 2022/01, and
// implicit extension, 2023/12). Nothing is checked here that takes more than one element to see.

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "base/xml.h"
#include "mesh/model/look.h"

namespace openfab::mesh {

/// Begins the name of a property that is the share of a material of the object's own group; the
/// material's number follows.
constexpr std::string_view kThreemfShare = "openfab:share.";

enum class ThreemfType : uint8_t { kScalar, kVector, kMatrix, kResource };

/// An input or output of a function or a node.
struct ThreemfPort {
    std::string name;
    ThreemfType type = ThreemfType::kScalar;
    std::string from;  ///< "NODE.OUTPUT" where it is a reference
};

struct ThreemfNode {
    std::string kind;  ///< the element: `addition`
    std::string name;
    std::vector<ThreemfPort> inputs, outputs;
    std::vector<double> numbers;      ///< of constants
    int64_t resource = -1;            ///< of a constresourceid
    std::string of_output, of_input;  ///< of a gradient: the names in the function
};

struct ThreemfFunction {
    std::string name;
    std::vector<ThreemfPort> inputs, outputs;
    std::vector<ThreemfNode> nodes;
    /// Of a function from an image, which has no nodes.
    int64_t image = -1;
    double offset = 0, scale = 1;
    bool nearest = false;
    std::array<PictureWrap, 3> wrap{};
};

struct ThreemfImage {
    int64_t rows = 0, columns = 0, count = 0;
    std::vector<std::string> sheets;  ///< paths
};

/// What a function says of points of an object.
struct ThreemfField {
    std::string name;  ///< of a property
    int64_t function = -1;
    std::string channel;
    Affine3d transform;        ///< from the object to the function
    double least_feature = 0;  ///< a hint
    double fallback = 0;       ///< of a value that is undefined
    bool required = false;
};

struct ThreemfLevelSet {
    ThreemfField field;
    int64_t mesh = -1;  ///< the object that bounds it
    bool box_only = false;
    int64_t volume = -1;  ///< its volumetric data
};

struct ThreemfVolumeData {
    std::optional<ThreemfField> color;
    int64_t materials = -1;             ///< of the mixture: a group of them
    std::vector<ThreemfField> mixture;  ///< of each of these materials
    /// Of each of the object's own materials, as `openfab export` writes them where readers know no mixtures.
    std::vector<ThreemfField> shares;
    std::vector<ThreemfField> properties;
};

struct ThreemfFields {
    std::map<int64_t, ThreemfFunction> functions;
    std::map<int64_t, ThreemfImage> images;
    std::map<int64_t, ThreemfVolumeData> volumes;
};

/// Reads the elements of one model part, in their order.
class ThreemfFieldsReader {
  public:
    /// Decreases `*memory_bytes` by what it keeps.
    ThreemfFieldsReader(ThreemfFields* out, int64_t* memory_bytes)
        : out_(*out), memory_bytes_(*memory_bytes) {}

    /// Whether an element is for this reader: it opens one of these resources, or one is open.
    bool takes(std::string_view name) const;
    Complaint start(std::string_view name, const XmlAttributes& a);
    /// Ends an element that was begun here; returns whether there was one.
    bool end();

    static Complaint read_level_set(const XmlAttributes& a, ThreemfLevelSet* out);

  private:
    enum class Within { kNothing, kFunction, kImage, kVolume };

    Complaint begin(std::string_view name, const XmlAttributes& a);
    Complaint in_function(std::string_view name, const XmlAttributes& a);
    Complaint node(std::string_view name, const XmlAttributes& a);
    Complaint port(std::string_view name, const XmlAttributes& a, std::vector<ThreemfPort>* to);
    Complaint image_function(const XmlAttributes& a, ThreemfFunction* out);
    Complaint in_image(std::string_view name, const XmlAttributes& a);
    Complaint in_volume(std::string_view name, const XmlAttributes& a);
    void take(size_t bytes);

    ThreemfFields& out_;
    int64_t& memory_bytes_;
    Within within_ = Within::kNothing;
    int depth_ = 0;  ///< of elements that are open, that of the resource included
    ThreemfFunction* function_ = nullptr;
    ThreemfImage* image_ = nullptr;
    ThreemfVolumeData* volume_ = nullptr;
    bool in_node_ = false;
    std::vector<ThreemfPort>* ports_ = nullptr;  ///< those that are open
};

}  // namespace openfab::mesh
