// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/unknowns.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "base/json_text.h"
#include "base/near_miss.h"
#include "runtime/part/bind.h"
#include "runtime/part/settings.h"
#include "tools/fit/goal_keys.h"
#include "tools/fit/messages.h"

namespace openfab::fit {

namespace {

constexpr double kFarthest = 1e30;

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

class UnknownsReader {
  public:
    UnknownsReader(std::string file, const world::World& world, const openfab_fablet_list& fablets,
                   world::JsonReader* json)
        : json_(*json), file_(std::move(file)), world_(world), fablets_(fablets) {}

    Result<void> bind(const std::vector<std::string>& settings) {
        Result<std::vector<part::BoundUniforms>> bound =
            part::bind_values(world_, fablets_, {settings});
        if (!bound) return bound.error();
        bound_ = std::move(*bound);
        set_ = world_;
        return part::apply_settings(settings, &set_);
    }

    void read(const JsonValue& value) {
        if (!json_.named_things(value, "unknowns")) return;
        if (value.members.empty()) return json_.fail(value, messages::kNoUnknowns);
        for (const JsonMember& member : value.members) {
            Unknown& unknown = out_.emplace_back();
            unknown.location = {file_, member.line, member.column};
            unknown.name = member.key;
            const openfab_uniform* declared = find_uniform(member, &unknown);
            if (declared == nullptr) return;
            const std::string what = fmt::format("`{}`", member.key);
            if (!json_.object(member.value, kUnknownKeys, what)) return;
            const std::vector<std::string> all = all_choices(*declared, unknown);
            if (member.value.find("choices") != nullptr || !all.empty() ||
                declared->kind == OPENFAB_UNIFORM_MATERIAL) {
                read_choices(member, all, &unknown);
            } else {
                read_range(member.value, *declared, what, &unknown);
            }
            if (!json_.ok()) return;
        }
    }

    std::vector<Unknown> take() { return std::move(out_); }

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
        if (found->kind == OPENFAB_UNIFORM_CURVE) {
            const std::string what = take_key(number, component, out);
            return what.empty() ? found
                                : fail(what, fmt::format(messages::kKeysHelp, out->object,
                                                         out->uniform, out->now.size() - 1));
        }
        if (found->kind != OPENFAB_UNIFORM_VALUE)
            return fail(fmt::format(messages::kOfNoNumber, name, part::declaration(*found)),
                        messages::kOfNoNumberHelp);
        const bool whole = component < 0 && member.value.find("choices") != nullptr;
        if (component >= count || (component < 0 && count > 1 && !whole))
            return fail(
                fmt::format(messages::kComponents, name, part::declaration(*found)),
                fmt::format(messages::kComponentsHelp, out->object, out->uniform, count - 1));
        if (count > 1 && !whole) out->component = component;
        out->element = out->uniform;
        out->number = std::max(component, 0);
        if (found->array_length > 1 && component >= 0) {
            out->element += fmt::format("[{}]", component / found->components);
            out->number = component % found->components;
        }
        out->scalar = found->scalar;
        for (int32_t k = 0; k < count; ++k)
            out->now.push_back(number_of(bound.values[static_cast<size_t>(found->first_index + k)],
                                         found->scalar));
        return found;
    }

    /// Takes a value of a curve's keys, and the curve; returns what is wrong.
    std::string take_key(size_t object, int32_t component, Unknown* out) const {
        const world::Object& one = set_.objects[object];
        const auto own = one.uniforms.find(out->uniform);
        const world::UniformBinding& binding =
            own != one.uniforms.end() ? own->second
                                      : set_.fablets.at(one.fablet).uniforms.at(out->uniform);
        out->curve = std::get<world::Curve>(binding.value);  // it was bound
        const auto of_key = static_cast<int32_t>(out->curve->keys[0].size()) - 1;
        out->element = fmt::format("{}[{}]", out->uniform, component / of_key);
        out->number = component % of_key;
        for (const std::vector<double>& key : out->curve->keys)
            out->now.insert(out->now.end(), key.begin() + 1, key.end());
        out->component = component;
        const bool named = component >= 0 && static_cast<size_t>(component) < out->now.size();
        return named ? "" : fmt::format(messages::kKeys, out->name, out->now.size());
    }

    /// What is tried where no choices are given: of a bool both, of an enum its names; else nothing.
    static std::vector<std::string> all_choices(const openfab_uniform& declared,
                                                const Unknown& unknown) {
        if (unknown.scalar == OPENFAB_BOOL) return {"false", "true"};
        std::vector<std::string> out;
        // A line for each, "name\tvalue\tlabel", after that of the type.
        const std::string_view text = declared.type_name;
        for (size_t at = 0; (at = text.find('\n', at)) != std::string_view::npos;) {
            const std::string_view line = text.substr(++at);
            out.push_back(fmt::format("\"{}\"", line.substr(0, line.find('\t'))));
        }
        return out;
    }

    void read_choices(const JsonMember& member, const std::vector<std::string>& all, Unknown* out) {
        const JsonMember* choices = member.value.find("choices");
        if (choices == nullptr && !all.empty()) {
            for (const char* key : {"min", "max"}) {
                if (const JsonMember* other = member.value.find(key); other != nullptr)
                    return json_.fail_at(other->line, other->column,
                                         fmt::format(messages::kBoundOfNames, out->name, key),
                                         messages::kChoicesMissingHelp);
            }
            out->choices = all;
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
        const double limits[] = {declared.limits != nullptr ? declared.limits[0] : -kFarthest,
                                 declared.limits != nullptr ? declared.limits[1] : kFarthest};
        const auto bound = [&](const char* key, double limit) {
            const JsonMember* member = value.find(key);
            if (member != nullptr)
                return json_.number(member->value, fmt::format("`{}` of {}", key, what), limits[0],
                                    limits[1]);
            if (!(std::abs(limit) < kFarthest))
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
        std::vector<double> numbers;
        for (double number = first; number <= last; ++number)
            numbers.push_back(number);
        // The first that reaches all goals is taken.
        std::ranges::stable_sort(numbers, {},
                                 [&](double number) { return std::abs(number - out->start); });
        for (const double number : numbers)
            out->choices.push_back(fmt::format("{:.0f}", number));
    }

    world::JsonReader& json_;
    const std::string file_;
    const world::World& world_;
    const openfab_fablet_list& fablets_;
    world::World set_;  ///< with the settings
    std::vector<part::BoundUniforms> bound_;
    std::vector<Unknown> out_;
};

}  // namespace

std::vector<Unknown> read_unknowns(const JsonValue& value, const std::string& file,
                                   const world::World& world, const openfab_fablet_list& fablets,
                                   const std::vector<std::string>& settings,
                                   world::JsonReader* json) {
    UnknownsReader reader(file, world, fablets, json);
    if (const Result<void> bound = reader.bind(settings); !bound) {
        json->fail_with(bound.error());
        return {};
    }
    reader.read(value);
    return reader.take();
}

}  // namespace openfab::fit
