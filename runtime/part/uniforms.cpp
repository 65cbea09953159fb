// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/uniforms.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string_view>

#include "abi/curve_table.h"
#include "abi/element_name.h"
#include "abi/kernel_call.h"
#include "base/check.h"
#include "base/near_miss.h"
#include "runtime/part/bind_shape.h"
#include "runtime/part/curve.h"
#include "runtime/part/messages.h"

namespace openfab::part {
namespace {

size_t value_count(const openfab_uniform& u) {
    return static_cast<size_t>(u.components) * static_cast<size_t>(u.array_length);
}

const char* what_fits(openfab_scalar_type scalar) {
    switch (scalar) {
        case OPENFAB_BOOL:
            return messages::kTrueOrFalse;
        case OPENFAB_INT:
            return messages::kAnInt;
        case OPENFAB_UINT:
            return messages::kAUint;
        case OPENFAB_FLOAT:
            return messages::kANumber;
    }
    return messages::kANumber;
}

/// Returns the 32-bit pattern of a number, if the type can hold it.
bool to_bits(double value, bool boolean, openfab_scalar_type scalar, uint32_t* bits) {
    if (boolean != (scalar == OPENFAB_BOOL)) return false;
    switch (scalar) {
        case OPENFAB_BOOL:
            *bits = value != 0 ? 1 : 0;
            return true;
        case OPENFAB_INT:
            if (value != std::floor(value) || value < -2147483648.0 || value > 2147483647.0)
                return false;
            *bits = static_cast<uint32_t>(static_cast<int32_t>(value));
            return true;
        case OPENFAB_UINT:
            if (value != std::floor(value) || value < 0 || value > 4294967295.0) return false;
            *bits = static_cast<uint32_t>(value);
            return true;
        case OPENFAB_FLOAT:
            if (!(std::fabs(value) <= static_cast<double>(std::numeric_limits<float>::max())))
                return false;
            *bits = std::bit_cast<uint32_t>(static_cast<float>(value));
            return true;
    }
    return false;
}

/// The name of a value: of an enum's, or of a bool's.
struct Choice {
    std::string name;
    std::string label;
    uint32_t bits = 0;
};

/// Returns the names of a uniform's values; none if any value of its type will do.
std::vector<Choice> choices_of(const openfab_uniform& u) {
    std::vector<Choice> out;
    const std::string_view text = u.type_name;
    for (size_t at = text.find('\n'); at < text.size();) {
        const size_t end = std::min(text.find('\n', at + 1), text.size());
        const std::string line(text.substr(at + 1, end - at - 1));
        const size_t value = line.find('\t');
        const size_t label = line.find('\t', value + 1);
        out.push_back({line.substr(0, value), line.substr(label + 1),
                       static_cast<uint32_t>(std::strtol(line.c_str() + value + 1, nullptr, 10))});
        at = end;
    }
    return out;
}

class Binder {
  public:
    Binder(const world::World& world, const openfab_fablet& fablet,
           const world::UniformBindings& bindings, const std::string& object,
           const SourceLocation& object_location, bool unplaced)
        : world_(world),
          fablet_(fablet),
          bindings_(bindings),
          object_(object),
          object_location_(object_location),
          unplaced_(unplaced) {}

    Result<BoundUniforms> run() {
        out_.values.assign(static_cast<size_t>(fablet_.uniform_value_count), 0);
        out_.textures.assign(static_cast<size_t>(fablet_.texture_count), -1);
        out_.texture_is_volume.assign(static_cast<size_t>(fablet_.texture_count), false);
        out_.objects.assign(static_cast<size_t>(fablet_.object_count), -1);
        out_.slot_material.assign(static_cast<size_t>(fablet_.slot_count), 0);
        if (Result<void> known = check_names(); !known) return known.error();
        for (int32_t i = 0; i < fablet_.uniform_count; ++i) {
            const openfab_uniform& u = fablet_.uniforms[i];
            if (u.kind == OPENFAB_UNIFORM_CURVE_CHANGE) {
                if (Result<void> bound = bind_change(u); !bound) return bound.error();
                continue;
            }
            const auto it = bindings_.find(u.name);
            const Result<void> bound =
                it == bindings_.end() ? take_default(u) : bind_one(u, it->second);
            if (!bound) return bound.error();
        }
        derive_uniforms(fablet_, &out_.values);
        return std::move(out_);
    }

  private:
    Result<void> check_names() const {
        std::vector<std::string> known;
        for (int32_t i = 0; i < fablet_.uniform_count; ++i) {
            if (fablet_.uniforms[i].kind != OPENFAB_UNIFORM_CURVE_CHANGE)
                known.emplace_back(fablet_.uniforms[i].name);
        }
        for (const auto& [name, binding] : bindings_) {
            if (std::find(known.begin(), known.end(), name) != known.end()) continue;
            return error_at(binding.location,
                            fmt::format(messages::kNoSuchUniform, fablet_.name, name),
                            suggest(name, known));
        }
        return Ok{};
    }

    Result<void> take_default(const openfab_uniform& u) {
        if (u.kind != OPENFAB_UNIFORM_VALUE || u.default_bits == nullptr) {
            return error_at(object_location_,
                            fmt::format(messages::kNotBound, object_, declaration(u), fablet_.name),
                            fmt::format(messages::kGiveIt, what_is_needed(u)));
        }
        std::copy_n(u.default_bits, value_count(u), out_.values.begin() + u.first_index);
        return Ok{};
    }

    static bool is_ramp(const openfab_uniform& u) { return abi::curve_channels(u.components) > 1; }

    static std::string numbers_text(size_t n, bool boolean) {
        return boolean ? fmt::format(messages::kBooleans, n) : fmt::format(messages::kNumbers, n);
    }

    static std::string what_is_needed(const openfab_uniform& u) {
        const size_t n = value_count(u);
        if (u.kind == OPENFAB_UNIFORM_OBJECT)
            return n == 1 ? messages::kNameOfObject : fmt::format(messages::kNamesOfObjects, n);
        if (u.kind == OPENFAB_UNIFORM_TEXTURE2D || u.kind == OPENFAB_UNIFORM_TEXTURE3D)
            return n == 1 ? messages::kNameOfTexture : fmt::format(messages::kNamesOfTextures, n);
        if (u.kind == OPENFAB_UNIFORM_MATERIAL) {
            return n == 1 ? messages::kNameOfMaterial : fmt::format(messages::kNamesOfMaterials, n);
        }
        if (const std::vector<Choice> choices = choices_of(u); !choices.empty()) {
            std::string names;
            for (size_t i = 0; i < choices.size(); ++i)
                names += fmt::format("{}`{}`",
                                     i == 0                    ? ""
                                     : i + 1 == choices.size() ? " or "
                                                               : ", ",
                                     choices[i].label);
            return n == 1 ? names : fmt::format(messages::kAnArrayEach, n, names);
        }
        if (u.kind == OPENFAB_UNIFORM_CURVE) {
            return is_ramp(u) ? messages::kACurveOfColors : messages::kACurveAs;
        }
        return n == 1 ? what_fits(u.scalar)
                      : fmt::format(messages::kAnArray, numbers_text(n, u.scalar == OPENFAB_BOOL));
    }

    std::string found(const world::UniformBinding& b) const {
        if (const auto* names = std::get_if<std::vector<std::string>>(&b.value)) {
            return names->size() == 1 ? fmt::format(messages::kTheString, (*names)[0])
                                      : fmt::format(messages::kStrings, names->size());
        }
        if (std::holds_alternative<world::Curve>(b.value)) return messages::kACurve;
        const auto& numbers = std::get<std::vector<double>>(b.value);
        if (numbers.size() != 1) return numbers_text(numbers.size(), b.boolean);
        return b.boolean ? (numbers[0] != 0 ? "true" : "false")
                         : fmt::format(messages::kTheNumber, numbers[0]);
    }

    Error mismatch(const openfab_uniform& u, const world::UniformBinding& b) const {
        return error_at(b.location,
                        fmt::format(messages::kIsGiven, declaration(u), fablet_.name, found(b)),
                        fmt::format(messages::kItTakes, what_is_needed(u)));
    }

    Error beyond(const openfab_uniform& u, const world::UniformBinding& b, double value) const {
        const bool low = value < u.limits[0];
        return error_at(b.location,
                        fmt::format(messages::kIsGivenNumber, declaration(u), fablet_.name, value),
                        fmt::format(messages::kLimit, low ? "min" : "max", u.limits[low ? 0 : 1]));
    }

    Result<void> bind_one(const openfab_uniform& u, const world::UniformBinding& b) {
        if (u.kind == OPENFAB_UNIFORM_CURVE) return bind_curve(u, b);
        if (u.kind != OPENFAB_UNIFORM_VALUE) return bind_names(u, b);
        const std::vector<Choice> choices = choices_of(u);
        if (!choices.empty() && std::holds_alternative<std::vector<std::string>>(b.value))
            return bind_choices(u, b, choices);
        const auto* numbers = std::get_if<std::vector<double>>(&b.value);
        if (numbers == nullptr || numbers->size() != value_count(u)) return mismatch(u, b);
        for (size_t i = 0; i < numbers->size(); ++i) {
            uint32_t bits = 0;
            if (!to_bits((*numbers)[i], b.boolean, u.scalar, &bits)) {
                if (numbers->size() == 1 || b.boolean != (u.scalar == OPENFAB_BOOL))
                    return mismatch(u, b);
                return error_at(b.location,
                                fmt::format(messages::kIsGivenAsValue, declaration(u), fablet_.name,
                                            (*numbers)[i], i),
                                fmt::format(messages::kEachMustBe, what_fits(u.scalar)));
            }
            if (u.limits != nullptr &&
                !((*numbers)[i] >= u.limits[0] && (*numbers)[i] <= u.limits[1])) {
                return beyond(u, b, (*numbers)[i]);
            }
            const bool named = std::any_of(choices.begin(), choices.end(),
                                           [&](const Choice& one) { return one.bits == bits; });
            if (!choices.empty() && !named) return mismatch(u, b);
            out_.values[static_cast<size_t>(u.first_index) + i] = bits;
        }
        return Ok{};
    }

    /// Values by their names or labels.
    Result<void> bind_choices(const openfab_uniform& u, const world::UniformBinding& b,
                              const std::vector<Choice>& choices) {
        const auto& names = std::get<std::vector<std::string>>(b.value);
        if (names.size() != value_count(u)) return mismatch(u, b);
        for (size_t i = 0; i < names.size(); ++i) {
            const auto found = std::find_if(choices.begin(), choices.end(), [&](const Choice& one) {
                return names[i] == one.name || names[i] == one.label;
            });
            if (found == choices.end()) {
                std::vector<std::string> known;
                for (const Choice& one : choices)
                    known.insert(known.end(), {one.label, one.name});
                return error_at(b.location,
                                fmt::format(messages::kIsGiven, declaration(u), fablet_.name,
                                            fmt::format(messages::kTheString, names[i])),
                                near_miss(names[i], known).empty()
                                    ? fmt::format(messages::kItTakes, what_is_needed(u))
                                    : suggest(names[i], known));
            }
            out_.values[static_cast<size_t>(u.first_index) + i] = found->bits;
        }
        return Ok{};
    }

    Result<void> bind_curve(const openfab_uniform& u, const world::UniformBinding& b) {
        const auto* curve = std::get_if<world::Curve>(&b.value);
        if (curve == nullptr) return mismatch(u, b);
        const int32_t channels = abi::curve_channels(u.components);
        if (const std::string fault = curve_fault(*curve, channels); !fault.empty()) {
            return error_at(
                b.location,
                fmt::format(messages::kUniformBefore, declaration(u), fablet_.name, fault),
                fmt::format(messages::kItTakes, what_is_needed(u)));
        }
        for (const std::vector<double>& key : curve->keys) {
            for (size_t k = 1; u.limits != nullptr && k < key.size(); ++k) {
                if (!(key[k] >= u.limits[0] && key[k] <= u.limits[1])) return beyond(u, b, key[k]);
            }
        }
        auto to = out_.values.begin() + u.first_index;
        for (const float value : curve_table(*curve, channels))
            *to++ = std::bit_cast<uint32_t>(value);
        return Ok{};
    }

    /// The curve, which comes before, is bound.
    Result<void> bind_change(const openfab_uniform& u) {
        const abi::Element element = abi::element_of(u.name);
        const world::UniformBinding& binding = bindings_.at(element.name);
        const auto& curve = std::get<world::Curve>(binding.value);
        const auto key = static_cast<size_t>(element.index);
        if (key >= curve.keys.size()) {
            return error_at(
                binding.location,
                fmt::format(messages::kCurveHasNoKey, element.name, curve.keys.size(), key),
                fmt::format(messages::kCurveHasNoKeyHelp, curve.keys.size() - 1));
        }
        const auto channels = static_cast<int32_t>(curve.keys[0].size()) - 1;
        auto to = out_.values.begin() + u.first_index;
        for (int32_t channel = 0; channel < channels; ++channel) {
            for (const float value : curve_change(curve, channels, key, channel))
                *to++ = std::bit_cast<uint32_t>(value);
        }
        return Ok{};
    }

    Result<void> bind_names(const openfab_uniform& u, const world::UniformBinding& b) {
        const auto* names = std::get_if<std::vector<std::string>>(&b.value);
        if (names == nullptr || names->size() != static_cast<size_t>(u.array_length))
            return mismatch(u, b);
        for (size_t i = 0; i < names->size(); ++i) {
            const size_t index = static_cast<size_t>(u.first_index) + i;
            Result<void> one = bind_name(u, b, (*names)[i], index);
            if (!one) return one;
        }
        return Ok{};
    }

    /// Returns the kind of thing that has this name in the world, or null.
    const char* kind_of(const std::string& name) const {
        if (find(world_.textures, name) >= 0) return messages::kATexture;
        if (find(world_.materials, name) >= 0) return messages::kAMaterial;
        return find(world_.objects, name) >= 0 ? messages::kAnObject : nullptr;
    }

    /// Makes the error of a name that none of `things` has, as `finding` says.
    template <typename Thing>
    Error unknown(const openfab_uniform& u, const world::UniformBinding& b, const std::string& name,
                  const std::string& finding, const std::vector<Thing>& things) const {
        if (const char* other = kind_of(name); other != nullptr) {
            return error_at(b.location,
                            fmt::format(messages::kOtherKind, name, other, declaration(u),
                                        fablet_.name, what_is_needed(u)));
        }
        std::vector<std::string> known;
        for (const Thing& thing : things)
            known.push_back(thing.name);
        return error_at(b.location,
                        fmt::format(messages::kForUniform, finding, declaration(u), fablet_.name),
                        suggest(name, known));
    }

    template <typename Thing>
    static int32_t find(const std::vector<Thing>& things, const std::string& name) {
        for (size_t i = 0; i < things.size(); ++i) {
            if (things[i].name == name) return static_cast<int32_t>(i);
        }
        return -1;
    }

    Result<void> bind_name(const openfab_uniform& u, const world::UniformBinding& b,
                           const std::string& name, size_t index) {
        if (u.kind == OPENFAB_UNIFORM_MATERIAL) {
            const int32_t found = find(world_.materials, name);
            if (found < 0 && name != kVoidName)
                return unknown(u, b, name, fmt::format(messages::kNoSuchMaterial, name),
                               world_.materials);
            out_.slot_material[index] = static_cast<uint8_t>(found + 1);
        } else if (u.kind == OPENFAB_UNIFORM_OBJECT) {
            const int32_t found = find(world_.objects, name);
            if (found < 0)
                return unknown(u, b, name, fmt::format(messages::kNoSuchObject, name),
                               world_.objects);
            const bool placed = unplaced_ || std::any_of(world_.build.begin(), world_.build.end(),
                                                         [&](const world::Placement& p) {
                                                             return p.object == found;
                                                         });
            const auto slot = static_cast<int32_t>(index);
            const bool in_its_place = shape_asks(fablet_, slot) && !volume_asks(fablet_, slot);
            if (!placed && !in_its_place) {
                return error_at(
                    b.location,
                    fmt::format(messages::kNotPlaced, name, declaration(u), fablet_.name),
                    messages::kNotPlacedHelp);
            }
            out_.objects[index] = found;
        } else {
            const int32_t found = find(world_.textures, name);
            if (found < 0)
                return unknown(u, b, name, fmt::format(messages::kNoSuchTexture, name),
                               world_.textures);
            out_.textures[index] = found;
            out_.texture_is_volume[index] = u.kind == OPENFAB_UNIFORM_TEXTURE3D;
        }
        return Ok{};
    }

    const world::World& world_;
    const openfab_fablet& fablet_;
    const world::UniformBindings& bindings_;
    const std::string& object_;
    const SourceLocation& object_location_;
    const bool unplaced_;
    BoundUniforms out_;
};

}  // namespace

std::string declaration(const openfab_uniform& u) {
    const std::string_view written = u.type_name;
    const std::string_view type = written.substr(0, written.find('\n'));
    return u.array_length == 1 ? fmt::format("{} {}", type, u.name)
                               : fmt::format("{} {}[{}]", type, u.name, u.array_length);
}

namespace {

void fill_tables(const openfab_fablet& fablet, std::vector<uint32_t>* values) {
    size_t to = static_cast<size_t>(fablet.uniform_value_count + fablet.derived_count);
    for (int32_t k = 0; k < fablet.table_value_count; ++k) {
        const openfab_table_value& value = fablet.table_values[k];
        (*values)[to++] = value.from < 0 ? value.bits : (*values)[static_cast<size_t>(value.from)];
    }
}

}  // namespace

void derive_uniforms(const openfab_fablet& fablet, std::vector<uint32_t>* values) {
    const openfab_kernel& kernel = fablet.derived;
    const auto count = static_cast<size_t>(fablet.uniform_value_count);
    if (fablet.derived_count + fablet.table_value_count == 0) return;
    values->resize(count + static_cast<size_t>(fablet.derived_count + fablet.table_value_count));
    // Derived values may be read from tables of uniforms, and tables hold derived values.
    fill_tables(fablet, values);
    if (fablet.derived_count == 0) return;
    abi::KernelCall call(kernel, abi::best_isa());
    const auto buffers =
        std::make_unique<abi::KernelBuffer[]>(static_cast<size_t>(kernel.arg_count));
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const openfab_arg& arg = kernel.args[i];
        const auto a = static_cast<size_t>(arg.a);
        if (arg.kind == OPENFAB_ARG_UNIFORM) {
            call.set(i, &(*values)[a]);
            continue;
        }
        abi::KernelBuffer& buffer = buffers[i];
        if (kernel.packed != 0 && arg.kind == OPENFAB_ARG_DERIVED) {
            buffer.set_dense(abi::halide_type(OPENFAB_UINT), &(*values)[count],
                             {1, fablet.derived_count});
            call.set(i, buffer.raw());
            break;
        }
        if (arg.kind == OPENFAB_ARG_VALUES) {
            buffer.set_dense(abi::halide_type(arg), values->data(),
                             {static_cast<int32_t>(values->size())});
            call.set(i, buffer.raw());
        } else {
            buffer.set_dense(abi::halide_type(arg.scalar), &(*values)[count + a], {1});
            call.set(i, buffer.raw());
        }
    }
    // The kernel reads scalars and writes single values: nothing can fail.
    OPENFAB_CHECK(call.run().ok());
    fill_tables(fablet, values);
}

Result<BoundUniforms> bind_uniforms(const world::World& world, const openfab_fablet& fablet,
                                    const world::UniformBindings& bindings,
                                    const std::string& object,
                                    const SourceLocation& object_location, bool unplaced) {
    return Binder(world, fablet, bindings, object, object_location, unplaced).run();
}

}  // namespace openfab::part
