// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads the `build` of a world and its `groups`, flattened to placements of objects.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "base/json.h"
#include "world/json_reader.h"
#include "world/nearly_equal_stretch.h"
#include "world/world.h"
#include "world/world_files.h"

namespace openfab::world {

/// Maximum number of placements of a world.
constexpr size_t kMostPlacements = 100'000;

class BuildReader {
  public:
    /// Fills world->build; the world's meshes and objects must have been read. `extent_of` may be null.
    BuildReader(JsonReader* json, WorldFiles* files, World* world, int64_t memory_bytes,
                ExtentOf extent_of);

    /// `groups` and `arrange` may be null.
    void read(const JsonValue* groups, const JsonValue& build, const JsonValue* arrange);

  private:
    struct Group {
        const JsonValue* items = nullptr;
        enum { kUnread, kBeingRead, kRead } state = kUnread;
        std::vector<Placement> placements;  ///< in the group's own space
        std::optional<Error> no_extent;     ///< why they are not where they should be
    };
    /// The transform of one placement, without those of enclosing groups.
    struct Local {
        Affine3d transform;
        bool on_bed = false;
    };

    std::vector<Placement> items(const JsonValue& list, const std::string& what);
    std::vector<std::vector<Placement>> each_item(const JsonValue& list, const std::string& what);
    void placement(const JsonValue& value, const std::string& what, std::vector<Placement>* out);
    std::vector<Placement> subject(const JsonValue& value, const std::string& what);
    std::vector<Placement> with_pieces(const JsonValue& value, const std::string& what,
                                       Placement placement);
    std::vector<Placement> named_group(const JsonValue& value, const std::string& what,
                                       const UniformBindings& overrides);
    Group* group(const JsonValue& name, const std::string& what);
    std::vector<Placement> group_items(const JsonValue& value, Group* group);
    void override_group(const JsonValue& value, const std::string& what,
                        const UniformBindings& bindings, std::vector<Placement>* placements);
    Local transform(const JsonValue& value, const std::string& what);
    Affine3d matrix(const JsonValue& value, const std::string& what);
    void grid(const JsonValue& value, const std::string& what, std::vector<Placement>* placements);
    void copies(const JsonValue& value, const std::string& what,
                std::vector<Placement>* placements);
    void arrange(const JsonValue& value, std::vector<std::vector<Placement>>* items);
    bool room_for(const JsonValue& value, size_t count);
    bool memory_for(const JsonValue& value, const std::vector<Placement>& placements,
                    size_t copies);
    bool take_memory(const JsonValue& value, double bytes);

    Box3d box(const JsonValue& value, const std::vector<Placement>& placements);
    const Box3d& turned_box(const Placement& placement);
    void note_no_extent(const Error& error);
    bool has_own_extent(const Placement& placement) const;
    UniformBindings overrides_of(const Placement& placement) const;

    JsonReader& json_;
    WorldFiles& files_;
    World& world_;
    std::map<std::string, int32_t> objects_;  ///< worlds may have a hundred thousand placements
    std::map<std::string, Group> groups_;
    int depth_ = 0;    ///< groups being read
    size_t made_ = 0;  ///< placements of all groups and of the build
    int64_t memory_bytes_;
    double made_bytes_ = 0;
    ExtentOf extent_of_;
    std::optional<Error> no_extent_;  ///< of what is read of a group without overrides
    /// Of the groups being read, outer ones first: what their placements override.
    std::vector<UniformBindings> outer_overrides_;
    /// By mesh, region of a piece, scale and rotation; of what has an extent of its own by object, and
    /// by the text of its overrides.
    std::map<std::tuple<int32_t, const pieces::Region*, std::array<double, 9>, std::string>, Box3d>
        boxes_;
    double looked_at_ = 0;  ///< vertices, for boxes_
    WrittenMatrices written_;
};

}  // namespace openfab::world
