// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/translate/layout.h"

namespace openfab::translate {

/// Appends the IR type of each component of a value.
void Layout::add_components(const check::Type& type, std::vector<ir::Type>* out) const {
    if (type.is_array()) {
        const check::Type element = type.element();
        for (int i = 0; i < type.length(); ++i)
            add_components(element, out);
        return;
    }
    switch (type.base) {
        case check::Base::kError:
        case check::Base::kVoid:
        case check::Base::kSurfaceAttributes:  // one per stage, without storage
        case check::Base::kVolumeAttributes:
        case check::Base::kDitherAttributes:
        case check::Base::kShapeAttributes:
        case check::Base::kGrowAttributes:
            return;
        case check::Base::kStruct:
            for (const check::StructMember& member : type.record->members)
                add_components(member.type, out);
            return;
        case check::Base::kSurfacePoint:
            for (const check::StructMember& member : place_.fablet.point_members)
                add_components(member.type, out);
            return;
        case check::Base::kComposition:
            out->insert(out->end(), static_cast<size_t>(place_.fablet.ir.slot_count),
                        ir::Type::kFloat);
            return;
        case check::Base::kBool:
        case check::Base::kInt:
        case check::Base::kUint:
        case check::Base::kFloat:
        case check::Base::kTexture2D:
        case check::Base::kTexture3D:
        case check::Base::kMaterial:
        case check::Base::kObject:
        case check::Base::kSpline:
        case check::Base::kColorRamp:
            out->insert(out->end(), static_cast<size_t>(check::min_components(type)),
                        check::component_type(type));
    }
}

std::vector<ir::Type> Layout::components(const check::Type& type) const {
    std::vector<ir::Type> out;
    add_components(type, &out);
    return out;
}

size_t Layout::component_count(const check::Type& type) const {
    if (type.is_arithmetic()) return static_cast<size_t>(check::min_components(type));
    return components(type).size();
}

Value Layout::zero(const check::Type& type) {
    Value out;
    for (ir::Type component : components(type))
        out.push_back(emit_.constant(component, 0));
    return out;
}

Value Layout::unassigned(const check::Type& type) {
    const bool starts = type.is_array() || type.base == check::Base::kComposition;
    if (type.is(check::Base::kStruct) && !starts) {
        Value out;
        for (const check::StructMember& member : type.record->members) {
            const Value part = unassigned(member.type);
            out.insert(out.end(), part.begin(), part.end());
        }
        return out;
    }
    return Value(component_count(type), emit_.constant(starts));
}

std::pair<size_t, size_t> Layout::member_range(const check::Type& type, size_t index) const {
    const std::vector<check::StructMember>& members =
        type.is(check::Base::kSurfacePoint) ? place_.fablet.point_members : type.record->members;
    size_t first = 0;
    for (size_t i = 0; i < index; ++i)
        first += component_count(members[i].type);
    return {first, component_count(members[index].type)};
}

}  // namespace openfab::translate
