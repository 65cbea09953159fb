// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/goals.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/json.h"
#include "base/near_miss.h"
#include "tools/fit/goal_keys.h"
#include "tools/fit/messages.h"
#include "tools/fit/property_measure.h"
#include "tools/fit/unknowns.h"
#include "world/edit/world_edit.h"
#include "world/json_reader.h"

namespace openfab::fit {

namespace {

constexpr size_t kLargestGoals = size_t{1} << 20;
constexpr double kMost = 1e30;
constexpr const char* kAll = "all";

struct QuantityKey {
    const char* key;
    Quantity quantity;
    const char* unit;
    const char* name;
    const char* command = nullptr;  ///< of `openfab mechanics`
};
constexpr QuantityKey kQuantities[] = {
    {"share", Quantity::kShare, "", "share"},
    {"volume_ml", Quantity::kVolume, " ml", "volume"},
    {"weight_g", Quantity::kWeight, " g", "weight"},
    {"cost", Quantity::kCost, "", "cost"},
    {"property", Quantity::kProperty, "", "property"},
    {"moved_mm", Quantity::kMoved, " mm", "movement", "part"},
    {"deflection_mm", Quantity::kDeflection, " mm", "deflection", "part"},
    {"work_Nmm", Quantity::kWork, " Nmm", "work", "part"},
    {"resistance_ohm", Quantity::kOhm, " ohm", "resistance", "conduct"},
    {"resistance_K_W", Quantity::kKelvinPerWatt, " K/W", "resistance", "conduct"},
    {"young_MPa", Quantity::kYoung, " MPa", "Young's modulus", "cell"},
    {"poisson", Quantity::kPoisson, "", "Poisson's ratio", "cell"},
    {"stiffness_MPa", Quantity::kStiffness, " MPa", "stiffness", "cell"},
};

class GoalsReader {
  public:
    GoalsReader(std::string file, const world::World& world, const openfab_fablet_list& fablets)
        : json_(file), file_(std::move(file)), world_(world), fablets_(fablets) {}

    Result<Goals> read(const JsonValue& root, const std::vector<std::string>& settings) {
        if (json_.object(root, kFileKeys, messages::kFile)) {
            const JsonValue& version = root.find("openfab_fit")->value;
            json_.integer(version, "`openfab_fit`", 1, 1);
            out_.unknowns = read_unknowns(root.find("unknowns")->value, file_, world_, fablets_,
                                          settings, &json_);
            read_list(root.find("goals")->value);
        }
        if (json_.ok()) check_together();
        if (!json_.ok()) return json_.error();
        return std::move(out_);
    }

  private:
    void read_list(const JsonValue& value) {
        if (!json_.ok()) return;
        if (!value.is(JsonValue::Kind::kArray) || value.items.empty())
            return json_.fail(value, messages::kNoGoals, messages::kNoGoalsHelp);
        for (const JsonValue& item : value.items) {
            read_goal(item);
            if (!json_.ok()) return;
        }
    }

    void read_goal(const JsonValue& value) {
        if (!json_.object(value, kGoalKeys, messages::kGoal)) return;
        const QuantityKey* of = nullptr;
        const JsonMember* which = nullptr;
        for (const QuantityKey& one : kQuantities) {
            const JsonMember* member = value.find(one.key);
            if (member == nullptr) continue;
            if (of != nullptr)
                return json_.fail_at(member->line, member->column,
                                     fmt::format(messages::kTwoQuantities, of->key, one.key),
                                     messages::kTwoQuantitiesHelp);
            of = &one;
            which = member;
        }
        if (of == nullptr)
            return json_.fail(value, messages::kNoQuantity, messages::kNoQuantityHelp);
        Goal goal;
        goal.quantity = of->quantity;
        goal.location = {file_, value.line, value.column};
        const std::string what = json_.string(which->value, fmt::format("`{}`", of->key));
        if (!json_.ok()) return;
        if (of->command != nullptr) {
            read_mechanics(value, *of, which->value, what, &goal);
        } else {
            Property property;
            if (goal.quantity == Quantity::kProperty) {
                Result<Property> read =
                    read_property(std::filesystem::path(file_).parent_path() / what, world_);
                if (!read) return json_.fail_with(read.error());
                property = std::move(*read);
                goal.unit = property.unit.empty() ? "" : " " + property.unit;
                goal.least = property.measure->lowest;
                goal.most = property.measure->highest;
                goal.name = property.name.empty() ? what : property.name;
            } else {
                goal.material = material_of(which->value, what, goal.quantity);
                goal.name = goal.material < 0 ? of->name : fmt::format("{} of {}", of->name, what);
            }
            goal.region = region_of(value, std::move(property.measure));
            if (json_.ok() && out_.regions[goal.region].voxels.box_mm)
                goal.name += messages::kInBox;
            if (json_.ok() && !out_.regions[goal.region].object.empty())
                goal.name += fmt::format(messages::kInObject, out_.regions[goal.region].object);
        }
        check_belongs(value, *of);
        if (!json_.ok()) return;
        if (const JsonMember* name = value.find("name"); name != nullptr)
            goal.name = json_.string(name->value, "`name`");
        read_bounds(value, of->key, &goal);
        if (json_.ok()) out_.goals.push_back(std::move(goal));
    }

    /// Keys that say something of other quantities alone.
    void check_belongs(const JsonValue& goal, const QuantityKey& of) {
        const std::string command = of.command != nullptr ? of.command : "";
        for (const auto& [key, fits] :
             {std::pair("box_mm", command.empty() && of.quantity != Quantity::kCost),
              std::pair("object", command.empty() && of.quantity != Quantity::kCost),
              std::pair("element_mm", !command.empty()), std::pair("cell_mm", command == "cell")}) {
            const JsonMember* member = goal.find(key);
            if (member != nullptr && !fits)
                json_.fail_at(member->line, member->column,
                              fmt::format(messages::kDoesNotBelong, key, of.key));
        }
    }

    /// Makes the words of the mechanics that have the number, and where it is in what they write.
    void read_mechanics(const JsonValue& value, const QuantityKey& of, const JsonValue& named,
                        const std::string& what, Goal* goal) {
        goal->name = fmt::format("{} of {}", of.name, what);
        goal->solve = {of.command};
        if (of.command == std::string("cell")) {
            read_cell(value, of, named, what, goal);
        } else {
            check_case(named, what, of.quantity);
            goal->solve.insert(goal->solve.end(), {"--case", what});
        }
        if (const JsonMember* element = value.find("element_mm"); element != nullptr) {
            const double mm = json_.number(element->value, "`element_mm`", 1e-3, 1e3);
            goal->solve.push_back(fmt::format("--voxel={}mm", mm));
        }
    }

    void read_cell(const JsonValue& value, const QuantityKey& of, const JsonValue& named,
                   const std::string& what, Goal* goal) {
        const JsonMember* cell = value.find("cell_mm");
        if (cell == nullptr)
            return json_.fail(value, fmt::format(messages::kNoCell, of.key), messages::kNoCellHelp);
        const std::vector<double> mm = json_.numbers(cell->value, "`cell_mm`", 3, 1e3);
        if (!json_.ok()) return;
        goal->solve.insert(goal->solve.end(),
                           {"--cell", fmt::format("{}mmx{}mmx{}mm", mm[0], mm[1], mm[2])});
        if (of.quantity == Quantity::kStiffness) {
            const bool fits = what.size() == 2 && what[0] >= '1' && what[0] <= '6' &&
                              what[1] >= '1' && what[1] <= '6';
            if (!fits) return json_.fail(named, messages::kTensorEntry, messages::kTensorEntryHelp);
            goal->entry = {what[0] - '1', what[1] - '1'};
            return;
        }
        const std::vector<std::string> names = of.quantity == Quantity::kYoung
                                                   ? std::vector<std::string>{"x", "y", "z"}
                                                   : std::vector<std::string>{"xy", "yz", "zx"};
        goal->entry[0] =
            static_cast<int32_t>(json_.choice(named, fmt::format("`{}`", of.key), names));
    }

    void check_case(const JsonValue& named, const std::string& name, Quantity quantity) {
        const Result<world::WorldEdit> world = world::WorldEdit::of_file(world_.file);
        if (!world) return json_.fail_with(world.error());
        const JsonMember* cases = world->tree().find("cases");
        std::vector<std::string> names;
        const JsonValue* found = nullptr;
        if (cases != nullptr) {
            for (const JsonMember& one : cases->value.members) {
                names.push_back(one.key);
                if (one.key == name) found = &one.value;
            }
        }
        if (found == nullptr)
            return json_.fail(named, fmt::format(messages::kNoSuchCase, name),
                              suggest(name, names));
        if (quantity != Quantity::kDeflection) return;
        const JsonMember* loads = found->find("loads");
        const bool one_force = loads != nullptr && loads->value.items.size() == 1 &&
                               loads->value.items[0].find("force_N") != nullptr &&
                               found->find("gravity_m_s2") == nullptr;
        if (!one_force) json_.fail(named, messages::kOneForce, messages::kOneForceHelp);
    }

    int32_t material_of(const JsonValue& value, const std::string& name, Quantity quantity) {
        std::vector<std::string> names;
        for (const world::Material& material : world_.materials)
            names.push_back(material.name);
        const auto found = std::ranges::find(names, name);
        if (quantity == Quantity::kCost && name != kAll) {
            json_.fail(value, messages::kCostOfAll);
        } else if (found != names.end()) {
            return static_cast<int32_t>(found - names.begin());
        } else if (quantity == Quantity::kShare && name == kAll) {
            json_.fail(value, messages::kShareOfAll, messages::kShareOfAllHelp);
        } else if (name != kAll) {
            json_.fail(value, fmt::format(messages::kNoSuchMaterial, name), suggest(name, names));
        }
        return -1;
    }

    size_t region_of(const JsonValue& goal, std::shared_ptr<const program::SumMeasure> measure) {
        Region region;
        region.voxels.measure = std::move(measure);
        if (const JsonMember* object = goal.find("object"); object != nullptr) {
            region.object = json_.string(object->value, "`object`");
            std::vector<std::string> names;
            for (const world::Placement& placed : world_.build)
                names.push_back(world_.objects[static_cast<size_t>(placed.object)].name);
            std::ranges::sort(names);
            names.erase(std::ranges::unique(names).begin(), names.end());
            if (json_.ok() && !std::ranges::binary_search(names, region.object))
                json_.fail(object->value, fmt::format(messages::kNoSuchPlaced, region.object),
                           suggest(region.object, names));
        }
        if (const JsonMember* box = goal.find("box_mm"); box != nullptr) {
            if (!box->value.is(JsonValue::Kind::kArray) || box->value.items.size() != 2) {
                json_.fail(box->value, messages::kBox, messages::kBoxHelp);
                return 0;
            }
            Box3d corners;
            for (size_t k = 0; k < 2; ++k) {
                const std::vector<double> at =
                    json_.numbers(box->value.items[k], messages::kCorner, 3, 1e6);
                if (!json_.ok()) return 0;
                (k == 0 ? corners.lo : corners.hi) = Vec3d{at[0], at[1], at[2]};
            }
            for (int axis = 0; axis < 3; ++axis) {
                if (corners.lo[axis] < corners.hi[axis]) continue;
                json_.fail(box->value, messages::kBoxEmpty, messages::kBoxHelp);
                return 0;
            }
            region.voxels.box_mm = corners;
        }
        for (size_t r = 0; r < out_.regions.size(); ++r) {
            const std::optional<Box3d>& known = out_.regions[r].voxels.box_mm;
            const std::optional<Box3d>& box = region.voxels.box_mm;
            if (known.has_value() != box.has_value() || out_.regions[r].object != region.object ||
                out_.regions[r].voxels.measure != region.voxels.measure)
                continue;
            if (!known || (known->lo == box->lo && known->hi == box->hi)) return r;
        }
        out_.regions.push_back(region);
        return out_.regions.size() - 1;
    }

    void read_bounds(const JsonValue& value, const char* key, Goal* goal) {
        const double most = goal->quantity == Quantity::kShare ? 1 : kMost;
        const bool signs =
            goal->quantity == Quantity::kPoisson || goal->quantity == Quantity::kStiffness;
        const double least = signs ? -most : 0;
        const bool table = goal->quantity == Quantity::kProperty;
        const auto read = [&](const char* name) -> std::optional<double> {
            const JsonMember* member = value.find(name);
            if (member == nullptr) return {};
            return json_.number(member->value, fmt::format("`{}` of `{}`", name, key),
                                table ? goal->least : least, table ? goal->most : most);
        };
        const std::optional<double> equal = read("equal");
        goal->wanted.at_least = read("at_least");
        goal->wanted.at_most = read("at_most");
        const JsonMember* aim = value.find("aim");
        const bool bounded = goal->wanted.at_least || goal->wanted.at_most;
        if (equal.has_value() + bounded + (aim != nullptr) != 1)
            return json_.fail(value, fmt::format(messages::kOneRelation, key),
                              messages::kOneRelationHelp);
        if (aim != nullptr)
            goal->wanted.aim = json_.choice(aim->value, "`aim`", {"least", "most"}) == 0 ? -1 : 1;
        if (equal) goal->wanted.at_least = goal->wanted.at_most = equal;
        if (goal->wanted.at_least && goal->wanted.at_most &&
            *goal->wanted.at_least > *goal->wanted.at_most)
            return json_.fail(value, fmt::format(messages::kNothingBetween, key,
                                                 *goal->wanted.at_least, *goal->wanted.at_most));
        // A thousandth of what is wanted; of a share of nothing, of the whole.
        const double size = std::max(std::abs(goal->wanted.at_least.value_or(0)),
                                     std::abs(goal->wanted.at_most.value_or(0)));
        goal->wanted.within = 1e-3 * (size > 0 ? size : 1);
        if (const JsonMember* within = value.find("within"); within != nullptr)
            goal->wanted.within = json_.number(within->value, "`within`", 1e-9, kMost);
    }

    void check_together() {
        int32_t aims = 0;
        std::map<size_t, double> shares;  // by region, what they are at least
        std::set<std::pair<size_t, int32_t>> counted;
        for (size_t a = 0; a < out_.goals.size(); ++a) {
            const Goal& goal = out_.goals[a];
            const auto fail = [&](const std::string& what, const std::string& help = {}) {
                json_.fail_at(goal.location.line, goal.location.column, what, help);
            };
            if (goal.wanted.aim != 0 && ++aims > 1)
                return fail(messages::kTwoAims, messages::kTwoAimsHelp);
            for (size_t b = 0; b < a; ++b) {
                const Goal& other = out_.goals[b];
                if (other.quantity != goal.quantity || other.material != goal.material ||
                    other.region != goal.region || other.solve != goal.solve ||
                    other.entry != goal.entry)
                    continue;
                const double least = std::max(goal.wanted.at_least.value_or(-kMost),
                                              other.wanted.at_least.value_or(-kMost));
                const double most = std::min(goal.wanted.at_most.value_or(kMost),
                                             other.wanted.at_most.value_or(kMost));
                if (least > most)
                    return fail(fmt::format(messages::kContradict, goal.name, other.location.line,
                                            least, most));
            }
            if (goal.quantity != Quantity::kShare || !goal.wanted.at_least) continue;
            if (!counted.insert({goal.region, goal.material}).second) continue;
            double& sum = shares[goal.region];
            sum += *goal.wanted.at_least;
            if (sum > 1 + 1e-9)
                return fail(fmt::format(messages::kSharesBeyondOne, sum),
                            messages::kSharesBeyondOneHelp);
        }
    }

    world::JsonReader json_;
    const std::string file_;
    const world::World& world_;
    const openfab_fablet_list& fablets_;
    Goals out_;
};

}  // namespace

bool Goals::ask_cost() const {
    return std::ranges::any_of(goals,
                               [](const Goal& goal) { return goal.quantity == Quantity::kCost; });
}

Result<Goals> read_goals(const std::filesystem::path& file, const world::World& world,
                         const openfab_fablet_list& fablets,
                         const std::vector<std::string>& settings) {
    const Result<std::string> text = read_text_file(file, kLargestGoals);
    if (!text) return text.error();
    const Result<JsonValue> root = parse_json(*text, file.string());
    if (!root) return root.error();
    return GoalsReader(file.string(), world, fablets).read(*root, settings);
}

std::string unit_of(const Goal& goal) {
    for (const QuantityKey& one : kQuantities) {
        if (one.quantity == goal.quantity && goal.unit.empty()) return one.unit;
    }
    return goal.unit;
}

}  // namespace openfab::fit
