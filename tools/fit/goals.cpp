// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/goals.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "base/json.h"
#include "base/json_text.h"
#include "base/near_miss.h"
#include "runtime/part/bind.h"
#include "tools/fit/messages.h"
#include "world/json_reader.h"

namespace openfab::fit {

namespace {

constexpr size_t kLargestGoals = size_t{1} << 20;
constexpr double kMost = 1e30;
constexpr const char* kAll = "all";

const world::KeySet kRoot{
    "fit", {"$schema", "openfab_fit", "unknowns", "goals"}, {"openfab_fit", "unknowns", "goals"}};
const world::KeySet kUnknown{"unknown", {"min", "max", "start", "choices"}, {}};
const world::KeySet kGoal{"goal",
                          {"name", "share", "volume_ml", "weight_g", "cost", "box_mm", "equal",
                           "at_most", "at_least", "aim", "within"},
                          {}};

struct QuantityKey {
    const char* key;
    Quantity quantity;
    const char* unit;
    const char* name;
};
constexpr QuantityKey kQuantities[] = {
    {"share", Quantity::kShare, "", "share"},
    {"volume_ml", Quantity::kVolume, " ml", "volume"},
    {"weight_g", Quantity::kWeight, " g", "weight"},
    {"cost", Quantity::kCost, "", "cost"},
};

double number_of(uint32_t bits, openfab_scalar_type scalar) {
    switch (scalar) {
        case OPENFAB_FLOAT:
            return double{std::bit_cast<float>(bits)};
        case OPENFAB_INT:
            return double{static_cast<double>(static_cast<int32_t>(bits))};
        case OPENFAB_UINT:
        case OPENFAB_BOOL:
            return static_cast<double>(bits);
    }
    return 0;
}

class GoalsReader {
  public:
    GoalsReader(std::string file, const world::World& world, const openfab_fablet_list& fablets)
        : json_(file), file_(std::move(file)), world_(world), fablets_(fablets) {}

    Result<Goals> read(const JsonValue& root, const std::vector<std::string>& settings) {
        Result<std::vector<part::BoundUniforms>> bound =
            part::bind_values(world_, fablets_, {settings});
        if (!bound) return bound.error();
        bound_ = std::move(*bound);
        if (json_.object(root, kRoot, messages::kFile)) {
            const JsonValue& version = root.find("openfab_fit")->value;
            json_.integer(version, "`openfab_fit`", 1, 1);
            read_unknowns(root.find("unknowns")->value);
            read_list(root.find("goals")->value);
        }
        if (json_.ok()) check_together();
        if (!json_.ok()) return json_.error();
        return std::move(out_);
    }

  private:
    const openfab_fablet* fablet_of(const world::Object& object) const {
        const world::FabletRef& ref = world_.fablets.at(object.fablet);
        const openfab_fablet* found = nullptr;
        for (int32_t i = 0; i < fablets_.count; ++i) {
            const openfab_fablet* fablet = fablets_.fablets[i];
            if (ref.fablet != fablet->name) continue;
            if (found == nullptr || ref.source.filename() == fablet->source_name) found = fablet;
        }
        return found;
    }

    void read_unknowns(const JsonValue& value) {
        if (!json_.named_things(value, "unknowns")) return;
        if (value.members.empty()) return json_.fail(value, messages::kNoUnknowns);
        for (const JsonMember& member : value.members) {
            Unknown& unknown = out_.unknowns.emplace_back();
            unknown.location = {file_, member.line, member.column};
            unknown.name = member.key;
            const openfab_uniform* declared = find_uniform(member, &unknown);
            if (declared == nullptr) return;
            const std::string what = fmt::format("`{}`", member.key);
            if (!json_.object(member.value, kUnknown, what)) return;
            if (member.value.find("choices") != nullptr || unknown.scalar == OPENFAB_BOOL ||
                declared->kind == OPENFAB_UNIFORM_MATERIAL) {
                read_choices(member, &unknown);
            } else {
                read_range(member.value, *declared, what, &unknown);
            }
            if (!json_.ok()) return;
        }
    }

    /// Finds the uniform of `OBJECT.UNIFORM` or `OBJECT.UNIFORM[INDEX]`, and the values that it has; null after an
    /// error.
    const openfab_uniform* find_uniform(const JsonMember& member, Unknown* out) {
        const auto fail = [&](const std::string& what, const std::string& help = {}) {
            json_.fail_at(member.line, member.column, what, help);
            return nullptr;
        };
        const std::string& name = member.key;
        const size_t dot = name.rfind('.');
        if (dot == std::string::npos || dot == 0 || dot + 1 == name.size())
            return fail(fmt::format(messages::kUnknownForm, name), messages::kUnknownFormHelp);
        out->object = name.substr(0, dot);
        out->uniform = name.substr(dot + 1);
        int32_t component = -1;
        if (const size_t bracket = out->uniform.find('['); bracket != std::string::npos) {
            const std::string index = out->uniform.substr(bracket + 1);
            if (index.size() < 2 || index.size() > 5 || index.back() != ']' ||
                index.find_first_not_of("0123456789") != index.size() - 1)
                return fail(fmt::format(messages::kUnknownForm, name), messages::kUnknownFormHelp);
            component = std::atoi(index.c_str());
            out->uniform.resize(bracket);
        }
        std::vector<std::string> objects;
        const world::Object* object = nullptr;
        size_t number = 0;
        for (size_t i = 0; i < world_.objects.size(); ++i) {
            objects.push_back(world_.objects[i].name);
            if (objects.back() != out->object) continue;
            object = &world_.objects[i];
            number = i;
        }
        if (object == nullptr)
            return fail(fmt::format(messages::kNoSuchObject, out->object),
                        suggest(out->object, objects));
        const auto placed = std::ranges::find_if(world_.build, [&](const world::Placement& of) {
            return static_cast<size_t>(of.object) == number;
        });
        if (placed == world_.build.end())
            return fail(fmt::format(messages::kNotPlaced, out->object), messages::kNotPlacedHelp);
        for (const world::Placement& of : world_.build) {
            const auto own = of.overrides.find(out->uniform);
            if (static_cast<size_t>(of.object) != number || own == of.overrides.end()) continue;
            return fail(fmt::format(messages::kPlacementsOwn, out->object, out->uniform,
                                    own->second.location.line),
                        messages::kPlacementsOwnHelp);
        }
        const openfab_fablet* fablet = fablet_of(*object);
        std::vector<std::string> uniforms;
        const openfab_uniform* found = nullptr;
        for (int32_t i = 0; fablet != nullptr && i < fablet->uniform_count; ++i) {
            uniforms.emplace_back(fablet->uniforms[i].name);
            if (uniforms.back() == out->uniform) found = &fablet->uniforms[i];
        }
        if (found == nullptr)
            return fail(fmt::format(messages::kNoSuchUniform, out->object, out->uniform),
                        suggest(out->uniform, uniforms));
        const part::BoundUniforms& bound =
            bound_[static_cast<size_t>(placed - world_.build.begin())];
        const int32_t count = found->components * found->array_length;
        if (found->kind == OPENFAB_UNIFORM_MATERIAL && count == 1 && component < 0) return found;
        if (found->kind != OPENFAB_UNIFORM_VALUE)
            return fail(fmt::format(messages::kOfNoNumber, name, part::declaration(*found)),
                        messages::kOfNoNumberHelp);
        if (component >= count || (component < 0 && count > 1))
            return fail(
                fmt::format(messages::kComponents, name, part::declaration(*found)),
                fmt::format(messages::kComponentsHelp, out->object, out->uniform, count - 1));
        if (count > 1) out->component = component;
        out->scalar = found->scalar;
        for (int32_t k = 0; k < count; ++k)
            out->now.push_back(number_of(bound.values[static_cast<size_t>(found->first_index + k)],
                                         found->scalar));
        return found;
    }

    void read_choices(const JsonMember& member, Unknown* out) {
        const JsonMember* choices = member.value.find("choices");
        if (choices == nullptr && out->scalar == OPENFAB_BOOL) {
            out->choices = {"false", "true"};
            return;
        }
        if (choices == nullptr)
            return json_.fail(member.value, fmt::format(messages::kChoicesMissing, out->name),
                              messages::kChoicesMissingHelp);
        if (out->component >= 0)
            return json_.fail(choices->value, messages::kChoicesOfComponent,
                              messages::kChoicesOfComponentHelp);
        for (const char* key : {"min", "max", "start"}) {
            if (const JsonMember* other = member.value.find(key); other != nullptr)
                return json_.fail_at(other->line, other->column,
                                     fmt::format(messages::kBesideChoices, key));
        }
        const JsonValue& list = choices->value;
        if (!list.is(JsonValue::Kind::kArray) || list.items.empty())
            return json_.fail(list, messages::kChoicesNoList);
        for (const JsonValue& item : list.items) {
            std::string text = JsonText().value(item).take();
            // A wrong one is told now, not when it is tried.
            const Result<std::vector<part::BoundUniforms>> fits = part::bind_values(
                world_, fablets_, {{out->object + "." + out->uniform + "=" + text}});
            if (!fits) return json_.fail(item, fits.error().message, fits.error().help);
            out->choices.push_back(std::move(text));
        }
    }

    void read_range(const JsonValue& value, const openfab_uniform& declared,
                    const std::string& what, Unknown* out) {
        const double now = out->now[static_cast<size_t>(std::max(out->component, 0))];
        const double limits[] = {declared.limits != nullptr ? declared.limits[0] : -kMost,
                                 declared.limits != nullptr ? declared.limits[1] : kMost};
        const auto bound = [&](const char* key, double limit) {
            const JsonMember* member = value.find(key);
            if (member != nullptr)
                return json_.number(member->value, fmt::format("`{}` of {}", key, what), limits[0],
                                    limits[1]);
            if (!(std::abs(limit) < kMost))
                json_.fail(value, fmt::format(messages::kNoBound, what, key),
                           fmt::format(messages::kNoBoundHelp, key));
            return limit;
        };
        out->min = bound("min", limits[0]);
        out->max = bound("max", limits[1]);
        if (!json_.ok()) return;
        if (!(out->min < out->max))
            return json_.fail(value, fmt::format(messages::kNoRoom, what, out->min, out->max),
                              messages::kNoRoomHelp);
        const JsonMember* start = value.find("start");
        const bool inside = now >= out->min && now <= out->max;
        out->start =
            start != nullptr
                ? json_.number(start->value, fmt::format("`start` of {}", what), out->min, out->max)
            : inside ? now
                     : (out->min + out->max) / 2;
        if (out->scalar == OPENFAB_FLOAT) return;
        // Whole numbers are searched through.
        const double first = std::ceil(out->min), last = std::floor(out->max);
        constexpr double kMostNumbers = 1000;
        if (last < first || last - first >= kMostNumbers)
            return json_.fail(value, fmt::format(messages::kWholeNumbers, what, out->min, out->max),
                              messages::kWholeNumbersHelp);
        if (out->component >= 0)
            return json_.fail(value, messages::kChoicesOfComponent,
                              messages::kChoicesOfComponentHelp);
        for (double number = first; number <= last; ++number)
            out->choices.push_back(fmt::format("{:.0f}", number));
    }

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
        if (!json_.object(value, kGoal, messages::kGoal)) return;
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
        const std::string material = json_.string(which->value, fmt::format("`{}`", of->key));
        if (!json_.ok()) return;
        goal.material = material_of(which->value, material, goal.quantity);
        goal.region = region_of(value);
        if (!json_.ok()) return;
        goal.name = goal.material < 0 ? of->name : fmt::format("{} of {}", of->name, material);
        if (out_.regions[goal.region].box_mm) goal.name += messages::kInBox;
        if (const JsonMember* name = value.find("name"); name != nullptr)
            goal.name = json_.string(name->value, "`name`");
        read_bounds(value, of->key, &goal);
        if (json_.ok()) out_.goals.push_back(std::move(goal));
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

    size_t region_of(const JsonValue& goal) {
        program::SumRegion region;
        if (const JsonMember* box = goal.find("box_mm"); box != nullptr) {
            if (goal.find("cost") != nullptr) json_.fail(box->value, messages::kCostInBox);
            if (!box->value.is(JsonValue::Kind::kArray) || box->value.items.size() != 2) {
                json_.fail(box->value, messages::kBox, messages::kBoxHelp);
                return 0;
            }
            Box3d corners;
            for (size_t k = 0; k < 2; ++k) {
                const std::vector<double> at =
                    json_.numbers(box->value.items[k], messages::kCorner, 3, 1e6);
                if (!json_.ok()) return 0;
                (k == 0 ? corners.lo : corners.hi) = {at[0], at[1], at[2]};
            }
            for (int axis = 0; axis < 3; ++axis) {
                if (corners.lo[axis] < corners.hi[axis]) continue;
                json_.fail(box->value, messages::kBoxEmpty, messages::kBoxHelp);
                return 0;
            }
            region.box_mm = corners;
        }
        for (size_t r = 0; r < out_.regions.size(); ++r) {
            const std::optional<Box3d>& known = out_.regions[r].box_mm;
            if (known.has_value() != region.box_mm.has_value()) continue;
            if (!known || (known->lo == region.box_mm->lo && known->hi == region.box_mm->hi))
                return r;
        }
        out_.regions.push_back(region);
        return out_.regions.size() - 1;
    }

    void read_bounds(const JsonValue& value, const char* key, Goal* goal) {
        const double most = goal->quantity == Quantity::kShare ? 1 : kMost;
        const auto read = [&](const char* name) -> std::optional<double> {
            const JsonMember* member = value.find(name);
            if (member == nullptr) return {};
            return json_.number(member->value, fmt::format("`{}` of `{}`", name, key), 0, most);
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
        const double size =
            std::max(goal->wanted.at_least.value_or(0), goal->wanted.at_most.value_or(0));
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
                    other.region != goal.region)
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
    std::vector<part::BoundUniforms> bound_;
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

const char* unit_of(Quantity quantity) {
    for (const QuantityKey& one : kQuantities) {
        if (one.quantity == quantity) return one.unit;
    }
    return "";
}

}  // namespace openfab::fit
