// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The functions of a 3MF model as functions of OpenFL: one for each output that is used, with the nodes that it
// needs, one a line.

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/result.h"
#include "mesh/read/threemf_model.h"
#include "tools/fields/node_text.h"

namespace openfab::tools {

class FunctionTexts {
  public:
    /// `file` is for messages; the model is kept.
    FunctionTexts(const mesh::ThreemfModel& model, std::string file)
        : model_(model), file_(std::move(file)) {}

    /// Returns the expression of a function's output at `point`, an expression of a float3, of this type.
    /// `whose` says who asks, for messages: "the level set of object 4".
    Result<std::string> at(const mesh::ThreemfField& field, const std::string& point,
                           mesh::ThreemfType type, const std::string& whose);

    /// The functions, each behind those that it calls.
    const std::vector<std::string>& texts() const { return texts_; }
    /// Ids of functions from images that are looked up: uniforms `image_ID`.
    const std::set<int64_t>& images() const { return images_; }
    /// Ids of objects whose distance is asked for: uniforms `mesh_ID`. The point is that of `place_of_mesh(p)`,
    /// and the distance is multiplied by `unit_of_mesh`, which the caller writes before the functions.
    const std::set<int64_t>& meshes() const { return meshes_; }
    /// Likewise of objects with lattices of beams: uniforms `lattice_ID`.
    const std::set<int64_t>& lattices() const { return lattices_; }
    /// Whether what was written may be undefined somewhere.
    bool may_be_undefined() const { return may_be_undefined_; }

  private:
    /// A function's output, where its inputs that are resources are these.
    struct Key {
        int64_t function = 0;
        std::string output;
        std::map<std::string, int64_t> resources;
        auto operator<=>(const Key&) const = default;
    };
    struct Made {
        std::string name;  ///< empty while it is written
        mesh::ThreemfType type = mesh::ThreemfType::kScalar;
    };
    /// What a function is written with.
    struct Scope {
        const Key* key = nullptr;
        const mesh::ThreemfFunction* function = nullptr;
        std::map<std::string, size_t> nodes;       ///< by name
        std::map<std::string, FieldValue> inputs;  ///< by name
        std::map<std::string, FieldValue> values;  ///< by "NODE.OUTPUT", of those written
        std::set<std::string> taken;               ///< names in the text
        std::string lines;
    };

    Result<Made> make(const Key& key);
    Result<Made> make_image(const Key& key, const mesh::ThreemfFunction& function);
    Result<Made> make_graph(const Key& key, const mesh::ThreemfFunction& function);
    Result<std::vector<std::pair<size_t, std::string>>> order(const Scope& scope,
                                                              const std::string& from);
    Result<void> write(Scope* scope, size_t node, const std::string& output);
    Result<FieldValue> node_value(Scope* scope, const mesh::ThreemfNode& node,
                                  const std::string& output);
    std::string keep_undefined(const NodeKind& kind);
    Result<FieldValue> call(Scope* scope, const mesh::ThreemfNode& node, const std::string& output);
    struct Slope {
        std::string value, gradient;
    };
    Result<Slope> slope(Scope* scope, const mesh::ThreemfNode& node);
    Result<FieldValue> normalized(Scope* scope, const mesh::ThreemfNode& node);
    Result<FieldValue> gradient(Scope* scope, const mesh::ThreemfNode& node,
                                const std::string& output);
    Result<FieldValue> distance(Scope* scope, const mesh::ThreemfNode& node);
    Result<FieldValue> input(const Scope& scope, const mesh::ThreemfNode& node,
                             std::string_view name);
    Result<FieldValue> value_of(const Scope& scope, const mesh::ThreemfNode& node,
                                const mesh::ThreemfPort& port);
    /// A name of the file, for messages.
    static std::string shown(std::string_view name);
    std::string place(const Scope& scope, const mesh::ThreemfNode* node) const;
    std::string place(int64_t function) const;
    Error error(const std::string& place, const std::string& what,
                const std::string& help = {}) const;
    std::string unique(const std::string& wanted);

    const mesh::ThreemfModel& model_;
    std::string file_;
    std::map<Key, Made> made_;
    std::vector<std::string> texts_;
    size_t length_ = 0;  ///< of them
    std::set<int64_t> images_, meshes_, lattices_;
    bool may_be_undefined_ = false;
    std::set<std::string> names_;
    std::vector<int64_t> open_;  ///< functions that are being written, the outermost first
};

/// A name of letters, digits and underscores.
std::string openfl_name(std::string_view name);

/// A point behind an affine map, as an expression.
std::string mapped_text(const Affine3d& map, const std::string& point);

}  // namespace openfab::tools
