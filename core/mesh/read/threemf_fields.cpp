// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

namespace {

constexpr size_t kLongest = 1000;
/// Elements of a resource are nested this deep at most: function, node, in, port.
constexpr int kDeepest = 32;

Complaint read_text(const XmlAttributes& a, const char* key, std::string* out) {
    const char* text = a.find(key);
    *out = text != nullptr ? trim_threemf(text) : std::string_view();
    if (out->size() <= kLongest) return {};
    return {fmt::format(messages::kTooManyBytes, key, out->size()),
            fmt::format(messages::kAtMost, kLongest)};
}

Complaint read_number(const XmlAttributes& a, const char* key, double* out) {
    const char* text = a.find(key);
    if (text == nullptr) return {};
    const std::string wrong = scan_number(trim_threemf(text), out);
    return wrong.empty() ? Complaint() : Complaint(fmt::format("`{}`: {}", key, wrong));
}

Complaint read_id(const XmlAttributes& a, const char* key, bool needed, int64_t* out) {
    const char* text = a.find(key);
    if (text == nullptr)
        return needed ? Complaint(fmt::format(messages::kAttributeMissing, key)) : Complaint();
    const std::string wrong = scan_integer(trim_threemf(text), 0, INT32_MAX, out);
    return wrong.empty() ? Complaint() : Complaint(fmt::format("`{}`: {}", key, wrong));
}

bool is_true(const XmlAttributes& a, const char* key) {
    const char* text = a.find(key);
    const std::string_view value = trim_threemf(text != nullptr ? text : "");
    return value == "true" || value == "1";
}

/// The last complaint that is one.
Complaint first_of(std::initializer_list<Complaint> all) {
    for (const Complaint& one : all) {
        if (!one.empty()) return one;
    }
    return {};
}

Complaint read_numbers(const XmlAttributes& a, const char* key, size_t count,
                       std::vector<double>* out) {
    const char* text = a.find(key);
    if (text == nullptr) return fmt::format(messages::kAttributeMissing, key);
    const std::vector<std::string_view> words = threemf_words(text);
    if (words.size() != count)
        return fmt::format(messages::kOtherNumberOfNumbers, key, words.size(), count);
    for (const std::string_view word : words) {
        double value = 0;
        if (std::string wrong = scan_number(word, &value); !wrong.empty()) return wrong;
        out->push_back(value);
    }
    return {};
}

Complaint read_transform(const XmlAttributes& a, Affine3d* out) {
    if (a.find("transform") == nullptr) return {};
    constexpr size_t kCount = 12;
    std::vector<double> m;
    if (Complaint wrong = read_numbers(a, "transform", kCount, &m); !wrong.empty()) return wrong;
    // Written for row vectors: the columns of our matrix, one after another.
    *out = {{m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}, {m[9], m[10], m[11]}};
    return {};
}

Complaint read_field(const XmlAttributes& a, ThreemfField* out) {
    out->required = is_true(a, "required");
    return first_of({read_id(a, "functionid", true, &out->function),
                     read_text(a, "channel", &out->channel), read_text(a, "name", &out->name),
                     read_transform(a, &out->transform),
                     read_number(a, "minfeaturesize", &out->least_feature),
                     read_number(a, "fallbackvalue", &out->fallback)});
}

Complaint read_tile(const XmlAttributes& a, const char* key, PictureWrap* out) {
    const char* text = a.find(key);
    const std::string_view style = trim_threemf(text != nullptr ? text : "wrap");
    if (style == "wrap") {
        *out = PictureWrap::kRepeat;
    } else if (style == "mirror") {
        *out = PictureWrap::kMirror;
    } else if (style == "clamp") {
        *out = PictureWrap::kClamp;
    } else {
        return {fmt::format(messages::kUnknownTileStyle, style.substr(0, 40)),
                messages::kVolumeTileStyleHelp};
    }
    return {};
}

struct Port {
    std::string_view element;
    ThreemfType type;
    bool is_reference;
};
constexpr Port kPorts[] = {
    {"scalar", ThreemfType::kScalar, false},   {"vector", ThreemfType::kVector, false},
    {"matrix", ThreemfType::kMatrix, false},   {"resourceid", ThreemfType::kResource, false},
    {"scalarref", ThreemfType::kScalar, true}, {"vectorref", ThreemfType::kVector, true},
    {"matrixref", ThreemfType::kMatrix, true}, {"resourceref", ThreemfType::kResource, true}};

}  // namespace

void ThreemfFieldsReader::take(size_t bytes) {
    // Lists double, and are copied then.
    memory_bytes_ -= static_cast<int64_t>(3 * bytes);
}

bool ThreemfFieldsReader::takes(std::string_view name) const {
    return within_ != Within::kNothing || name == "implicitfunction" || name == "function" ||
           name == "functionfromimage3d" || name == "image3d" || name == "volumedata";
}

Complaint ThreemfFieldsReader::start(std::string_view name, const XmlAttributes& a) {
    if (++depth_ > kDeepest) return fmt::format(messages::kFunctionNestedTooDeep, kDeepest);
    switch (within_) {
        case Within::kNothing:
            return begin(name, a);
        case Within::kFunction:
            return in_function(name, a);
        case Within::kImage:
            return in_image(name, a);
        case Within::kVolume:
            return in_volume(name, a);
    }
    return {};
}

bool ThreemfFieldsReader::end() {
    if (within_ == Within::kNothing) return false;
    --depth_;
    // Of a function: 1 is its own level, 2 that of in, out and nodes, 3 that of a node's in and out.
    if (depth_ <= 1) in_node_ = false;
    if (depth_ <= (in_node_ ? 2 : 1)) ports_ = nullptr;
    if (depth_ == 0) within_ = Within::kNothing;
    return true;
}

Complaint ThreemfFieldsReader::begin(std::string_view name, const XmlAttributes& a) {
    int64_t id = -1;
    if (Complaint wrong = read_id(a, "id", true, &id); !wrong.empty()) return wrong;
    constexpr size_t kNode = 64;
    if (out_.functions.contains(id) || out_.images.contains(id) || out_.volumes.contains(id))
        return fmt::format(messages::kSecondResource, id);
    if (name == "image3d") {
        take(sizeof(ThreemfImage) + kNode);
        within_ = Within::kImage;
        image_ = &out_.images[id];
        return {};
    }
    if (name == "volumedata") {
        take(sizeof(ThreemfVolumeData) + kNode);
        within_ = Within::kVolume;
        volume_ = &out_.volumes[id];
        return {};
    }
    take(sizeof(ThreemfFunction) + kNode);
    within_ = Within::kFunction;
    function_ = &out_.functions[id];
    in_node_ = false;
    ports_ = nullptr;
    if (Complaint wrong = read_text(a, "displayname", &function_->name); !wrong.empty())
        return wrong;
    take(function_->name.size());
    return name == "functionfromimage3d" ? image_function(a, function_) : Complaint();
}

Complaint ThreemfFieldsReader::image_function(const XmlAttributes& a, ThreemfFunction* out) {
    const char* filter = a.find("filter");
    const std::string_view written = trim_threemf(filter != nullptr ? filter : "linear");
    if (written != "linear" && written != "nearest")
        return {fmt::format(messages::kUnknownFilter, written.substr(0, 40)),
                messages::kUnknownFilterHelp};
    out->nearest = written == "nearest";
    // The specification's own example spells these otherwise than its table.
    const char* image = a.find("image3did") != nullptr ? "image3did" : "image3dID";
    return first_of(
        {read_id(a, image, true, &out->image),
         read_number(a, a.find("valueoffset") != nullptr ? "valueoffset" : "offset", &out->offset),
         read_number(a, a.find("valuescale") != nullptr ? "valuescale" : "scale", &out->scale),
         read_tile(a, "tilestyleu", &out->wrap[0]), read_tile(a, "tilestylev", &out->wrap[1]),
         read_tile(a, "tilestylew", &out->wrap[2])});
}

Complaint ThreemfFieldsReader::in_function(std::string_view name, const XmlAttributes& a) {
    if (ports_ != nullptr) return port(name, a, ports_);
    if (name == "in" || name == "out") {
        const bool in = name == "in";
        if (in_node_) {
            ThreemfNode& node = function_->nodes.back();
            ports_ = in ? &node.inputs : &node.outputs;
        } else {
            ports_ = in ? &function_->inputs : &function_->outputs;
        }
        return {};
    }
    if (in_node_) return {};
    in_node_ = true;
    return node(name, a);
}

Complaint ThreemfFieldsReader::node(std::string_view name, const XmlAttributes& a) {
    ThreemfNode node;
    node.kind = name.substr(0, kLongest);
    if (Complaint wrong = read_text(a, "identifier", &node.name); !wrong.empty()) return wrong;
    Complaint wrong;
    if (name == "constant") {
        wrong = read_numbers(a, "value", 1, &node.numbers);
    } else if (name == "constvec") {
        for (const char* axis : {"x", "y", "z"}) {
            if (wrong.empty()) wrong = read_numbers(a, axis, 1, &node.numbers);
        }
    } else if (name == "constmat") {
        constexpr size_t kCount = 16;
        wrong = read_numbers(a, "matrix", kCount, &node.numbers);
    } else if (name == "constresourceid") {
        wrong = read_id(a, "value", true, &node.resource);
    } else if (name == "functiongradient" || name == "normalizedistance") {
        wrong = first_of({read_text(a, "scalaroutput", &node.of_output),
                          read_text(a, "vectorinput", &node.of_input)});
    }
    take(sizeof node + node.kind.size() + node.name.size() + 8 * node.numbers.size() +
         node.of_output.size() + node.of_input.size());
    function_->nodes.push_back(std::move(node));
    return wrong;
}

Complaint ThreemfFieldsReader::port(std::string_view name, const XmlAttributes& a,
                                    std::vector<ThreemfPort>* to) {
    const auto known = std::ranges::find(kPorts, name, &Port::element);
    if (known == std::end(kPorts)) return {};
    ThreemfPort port;
    port.type = known->type;
    Complaint wrong = read_text(a, "identifier", &port.name);
    if (wrong.empty() && known->is_reference) wrong = read_text(a, "ref", &port.from);
    if (!wrong.empty()) return wrong;
    if (port.name.empty()) return {};
    take(sizeof port + port.name.size() + port.from.size());
    to->push_back(std::move(port));
    return {};
}

Complaint ThreemfFieldsReader::in_image(std::string_view name, const XmlAttributes& a) {
    if (name == "imagestack")
        return first_of({read_id(a, "rowcount", true, &image_->rows),
                         read_id(a, "columncount", true, &image_->columns),
                         read_id(a, "sheetcount", true, &image_->count)});
    if (name != "imagesheet") return {};
    std::string path;
    if (Complaint wrong = read_text(a, "path", &path); !wrong.empty()) return wrong;
    take(sizeof path + path.size());
    image_->sheets.push_back(std::move(path));
    return {};
}

Complaint ThreemfFieldsReader::in_volume(std::string_view name, const XmlAttributes& a) {
    if (name == "composite") {
        const Complaint wrong = read_id(a, "basematerialid", false, &volume_->materials);
        return wrong.empty() && volume_->materials < 0 ? Complaint(messages::kBaseMaterialMissing)
                                                       : wrong;
    }
    const bool mixed = name == "materialmapping", property = name == "property";
    if (name != "color" && !mixed && !property) return {};
    ThreemfField field;
    if (Complaint wrong = read_field(a, &field); !wrong.empty()) return wrong;
    take(sizeof field + field.name.size() + field.channel.size());
    if (mixed) {
        volume_->mixture.push_back(std::move(field));
    } else if (property &&
               field.name == fmt::format("{}{}", kThreemfShare, volume_->shares.size())) {
        volume_->shares.push_back(std::move(field));
    } else if (property) {
        volume_->properties.push_back(std::move(field));
    } else {
        volume_->color = std::move(field);
    }
    return {};
}

Complaint ThreemfFieldsReader::read_level_set(const XmlAttributes& a, ThreemfLevelSet* out) {
    out->box_only = is_true(a, "meshbboxonly");
    return first_of({read_field(a, &out->field), read_id(a, "meshid", true, &out->mesh),
                     read_id(a, "volumeid", false, &out->volume)});
}

}  // namespace openfab::mesh
