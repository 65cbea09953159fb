// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/load_case.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/near_miss.h"
#include "mechanics/messages.h"
#include "mechanics/model/print_world.h"

namespace openfab::mechanics {

namespace {

constexpr const char* kSides[] = {"-x", "+x", "-y", "+y", "-z", "+z"};
constexpr const char* kFaceKeys[] = {"object", "box_mm", "point_mm", "normal", "side", "facing"};

class CaseReader {
  public:
    /// `objects`: those of the world, where it has any.
    CaseReader(std::string file, const JsonMember* objects) : file_(std::move(file)) {
        if (objects)
            for (const JsonMember& m : objects->value.members)
                objects_.push_back(m.key);
    }

    Result<LoadCase> read(const JsonMember& member);

  private:
    Error at(const JsonValue& value, std::string what, std::string help = {}) const {
        return error_at({file_, value.line, value.column}, std::move(what), std::move(help));
    }
    Error at(const JsonMember& m, std::string what, std::string help = {}) const {
        return error_at({file_, m.line, m.column}, std::move(what), std::move(help));
    }
    Result<Vec3> three(const JsonMember& m) const;
    Result<int> side(const JsonMember& m) const;
    /// Whether the key is one of the faces'; then it is read.
    Result<bool> face_key(const JsonMember& m, FaceChoice* out) const;
    /// What is left to check when all keys are read.
    Result<void> complete(const JsonValue& value, FaceChoice* out) const;
    Result<Holding> holding(const JsonValue& value);
    Result<Load> load(const JsonValue& value);
    Error unknown(const JsonMember& m, std::vector<std::string> keys) const;
    /// Keys of a kind of case: all have to be of the same.
    Result<void> is_of(const JsonMember& m, CaseKind kind);
    Result<double> number(const JsonMember& m) const;
    Result<void> check_flow(const JsonMember& member, const LoadCase& c) const;

    std::string file_;
    std::vector<std::string> objects_;
    std::optional<CaseKind> kind_;
    std::string by_;  ///< the key that said so
};

Result<void> CaseReader::is_of(const JsonMember& m, CaseKind kind) {
    if (kind_ && *kind_ != kind)
        return at(m, fmt::format(messages::kKindsMixed, by_, m.key), messages::kKindsMixedHelp);
    kind_ = kind;
    by_ = m.key;
    return {};
}

Result<double> CaseReader::number(const JsonMember& m) const {
    if (!m.value.is(JsonValue::Kind::kNumber) || !std::isfinite(m.value.number))
        return at(m.value, fmt::format(messages::kMustBeNumber, m.key));
    return m.value.number;
}

Result<Vec3> CaseReader::three(const JsonMember& m) const {
    Vec3 out{};
    const std::vector<JsonValue>& items = m.value.items;
    bool good = m.value.is(JsonValue::Kind::kArray) && items.size() == 3;
    for (size_t i = 0; good && i < 3; ++i) {
        good = items[i].is(JsonValue::Kind::kNumber) && std::isfinite(items[i].number);
        out[i] = items[i].number;
    }
    if (!good) return at(m.value, fmt::format(messages::kMustThreeNumbers, m.key));
    return out;
}

Result<int> CaseReader::side(const JsonMember& m) const {
    const auto* found = std::ranges::find(kSides, m.value.text);
    if (!m.value.is(JsonValue::Kind::kString) || found == std::end(kSides))
        return at(m.value, fmt::format(messages::kMustOneOf, m.key, fmt::join(kSides, ", ")));
    return static_cast<int>(found - kSides);
}

Error CaseReader::unknown(const JsonMember& m, std::vector<std::string> keys) const {
    keys.insert(keys.end(), std::begin(kFaceKeys), std::end(kFaceKeys));
    return at(m, fmt::format(messages::kUnknownHere, m.key),
              fmt::format(messages::kChooseFrom, fmt::join(keys, ", ")));
}

Result<bool> CaseReader::face_key(const JsonMember& m, FaceChoice* out) const {
    if (m.key == "object") {
        if (!m.value.is(JsonValue::Kind::kString) || m.value.text.empty())
            return at(m.value, messages::kMustObjectName);
        if (!objects_.empty() && std::ranges::find(objects_, m.value.text) == objects_.end())
            return at(m.value, fmt::format(messages::kNoSuchObject, m.value.text),
                      suggest(m.value.text, objects_));
        out->object = m.value.text;
    } else if (m.key == "box_mm") {
        if (!m.value.is(JsonValue::Kind::kArray) || m.value.items.size() != 2)
            return at(m.value, messages::kMustTwoCorners);
        out->box_mm.emplace();
        for (size_t i = 0; i < 2; ++i) {
            const Result<Vec3> corner = three({m.key, m.line, m.column, m.value.items[i]});
            if (!corner) return corner.error();
            (*out->box_mm)[i] = *corner;
        }
        for (size_t a = 0; a < 3; ++a)
            if ((*out->box_mm)[0][a] > (*out->box_mm)[1][a])
                return at(m.value, messages::kLowerCornerFirst);
    } else if (m.key == "point_mm" || m.key == "normal") {
        const Result<Vec3> v = three(m);
        if (!v) return v.error();
        (m.key == "normal" ? out->normal : out->point_mm) = *v;
    } else if (m.key == "side" || m.key == "facing") {
        const Result<int> s = side(m);
        if (!s) return s.error();
        (m.key == "side" ? out->side : out->facing) = *s;
    } else {
        return false;
    }
    return true;
}

Result<void> CaseReader::complete(const JsonValue& value, FaceChoice* out) const {
    out->location = {file_, value.line, value.column};
    if (out->object.empty() && !out->box_mm && !out->point_mm && !out->normal && !out->side &&
        !out->facing)
        return at(value, messages::kNoFacesChosen,
                  fmt::format(messages::kNoFacesChosenHelp, fmt::join(kFaceKeys, ", ")));
    if (out->point_mm.has_value() != out->normal.has_value())
        return at(value, messages::kPlaneIncomplete);
    if (out->normal) {
        const double length = std::hypot((*out->normal)[0], (*out->normal)[1], (*out->normal)[2]);
        if (!(length > 0)) return at(value, messages::kNormalWithoutLength);
        for (double& v : *out->normal)
            v /= length;
    }
    if (!out->object.empty()) out->text += fmt::format(messages::kAtObject, out->object);
    if (out->side) out->text += fmt::format(messages::kOnSide, kSides[*out->side]);
    if (out->box_mm)
        out->text += fmt::format(messages::kInBox, fmt::join((*out->box_mm)[0], ", "),
                                 fmt::join((*out->box_mm)[1], ", "));
    if (out->point_mm)
        out->text += fmt::format(messages::kOnPlane, fmt::join(*out->point_mm, ", "));
    if (out->facing) out->text += fmt::format(messages::kFacing, kSides[*out->facing]);
    return {};
}

Result<Holding> CaseReader::holding(const JsonValue& value) {
    if (!value.is(JsonValue::Kind::kObject))
        return at(value, fmt::format(messages::kHeldNoObject, value.kind_name()));
    Holding out;
    for (const JsonMember& m : value.members) {
        const Result<bool> face = face_key(m, &out.faces);
        if (!face) return face.error();
        if (*face) continue;
        const bool volt = m.key == "volt";
        if (volt || m.key == "celsius" || m.key == "along" || m.key == "move_mm") {
            const CaseKind kind = volt                 ? CaseKind::kCurrent
                                  : m.key == "celsius" ? CaseKind::kHeat
                                                       : CaseKind::kForces;
            if (Result<void> done = is_of(m, kind); !done) return done.error();
        }
        if (volt || m.key == "celsius") {
            const Result<double> level = number(m);
            if (!level) return level.error();
            constexpr double kAbsoluteZero = -273.15;
            if (!volt && *level < kAbsoluteZero)
                return at(m.value, fmt::format(messages::kBelowAbsoluteZero, *level));
            out.level = *level;
        } else if (m.key == "along") {
            const std::string& axes = m.value.text;
            if (!m.value.is(JsonValue::Kind::kString) || axes.empty() ||
                axes.find_first_not_of("xyz") != std::string::npos)
                return at(m.value, messages::kAlongAxes);
            for (size_t a = 0; a < 3; ++a)
                out.along[a] = axes.find("xyz"[a]) != std::string::npos;
        } else if (m.key == "move_mm") {
            const Result<Vec3> move = three(m);
            if (!move) return move.error();
            out.move_mm = *move;
        } else {
            return unknown(m, {"along", "move_mm", "volt", "celsius"});
        }
    }
    for (size_t a = 0; a < 3; ++a) {
        if (out.along[a] || out.move_mm[a] == 0) continue;
        return at(value.find("move_mm")->value, fmt::format(messages::kMovedNotHeld, "xyz"[a]),
                  messages::kMovedNotHeldHelp);
    }
    if (Result<void> done = complete(value, &out.faces); !done) return done.error();
    return out;
}

Result<Load> CaseReader::load(const JsonValue& value) {
    if (!value.is(JsonValue::Kind::kObject))
        return at(value, fmt::format(messages::kLoadNoObject, value.kind_name()));
    Load out;
    for (const JsonMember& m : value.members) {
        const Result<bool> face = face_key(m, &out.faces);
        if (!face) return face.error();
        if (*face) continue;
        const bool ampere = m.key == "ampere", watt = m.key == "watt";
        if (ampere || watt || m.key.ends_with("_N") || m.key.ends_with("_Nmm") ||
            m.key.ends_with("_MPa")) {
            const CaseKind kind = ampere ? CaseKind::kCurrent
                                  : watt ? CaseKind::kHeat
                                         : CaseKind::kForces;
            if (Result<void> done = is_of(m, kind); !done) return done.error();
        }
        if (ampere || watt) {
            const Result<double> flow = number(m);
            if (!flow) return flow.error();
            out.inflow = *flow;
        } else if (m.key == "force_N" || m.key == "torque_Nmm") {
            const Result<Vec3> v = three(m);
            if (!v) return v.error();
            (m.key == "force_N" ? out.force_N : out.torque_Nmm) = *v;
        } else if (m.key == "pressure_MPa") {
            const Result<double> pressure = number(m);
            if (!pressure) return pressure.error();
            out.pressure_MPa = *pressure;
        } else {
            return unknown(m, {"force_N", "torque_Nmm", "pressure_MPa", "ampere", "watt"});
        }
    }
    if (!out.force_N && !out.torque_Nmm && !out.pressure_MPa && !out.inflow)
        return at(value, messages::kLoadWithoutForce, messages::kLoadWithoutForceHelp);
    if (Result<void> done = complete(value, &out.faces); !done) return done.error();
    return out;
}

Result<void> CaseReader::check_flow(const JsonMember& member, const LoadCase& c) const {
    const char* level = c.kind == CaseKind::kCurrent ? "volt" : "celsius";
    const char* flow = c.kind == CaseKind::kCurrent ? "ampere" : "watt";
    bool flows = !c.loads.empty();
    for (const Holding& h : c.held) {
        if (!h.level)
            return error_at(h.faces.location, fmt::format(messages::kHoldLacks, by_, level));
        flows = flows || *h.level != *c.held.front().level;
    }
    if (!flows)
        return at(member, fmt::format(messages::kNothingFlows, member.key),
                  fmt::format(messages::kNothingFlowsHelp, level, flow));
    return {};
}

Result<LoadCase> CaseReader::read(const JsonMember& member) {
    const JsonValue& value = member.value;
    if (!value.is(JsonValue::Kind::kObject))
        return at(value, fmt::format(messages::kCaseNoObject, member.key, value.kind_name()));
    LoadCase out;
    out.name = member.key;
    out.location = {file_, member.line, member.column};
    for (const JsonMember& m : value.members) {
        if (m.key == "held" || m.key == "loads") {
            if (!m.value.is(JsonValue::Kind::kArray))
                return at(m.value, fmt::format(messages::kMustList, m.key));
            for (const JsonValue& one : m.value.items) {
                if (m.key == "held") {
                    Result<Holding> h = holding(one);
                    if (!h) return h.error();
                    out.held.push_back(std::move(*h));
                } else {
                    Result<Load> l = load(one);
                    if (!l) return l.error();
                    out.loads.push_back(std::move(*l));
                }
            }
        } else if (m.key == "gravity_m_s2") {
            const Result<Vec3> g = three(m);
            if (!g) return g.error();
            if (Result<void> done = is_of(m, CaseKind::kForces); !done) return done.error();
            out.gravity_m_s2 = *g;
        } else {
            return at(m, fmt::format(messages::kCaseLacks, m.key), messages::kCaseLacksHelp);
        }
    }
    if (out.held.empty())
        return at(member, fmt::format(messages::kNothingHeld, member.key),
                  messages::kNothingHeldHelp);
    out.kind = kind_.value_or(CaseKind::kForces);
    if (out.kind != CaseKind::kForces) {
        if (Result<void> done = check_flow(member, out); !done) return done.error();
        return out;
    }
    const bool moves =
        std::ranges::any_of(out.held, [](const Holding& h) { return h.move_mm != Vec3{}; });
    if (out.loads.empty() && !out.gravity_m_s2 && !moves)
        return at(member, fmt::format(messages::kNothingLoads, member.key),
                  messages::kNothingLoadsHelp);
    return out;
}

}  // namespace

std::vector<std::string> LoadCase::objects() const {
    std::vector<std::string> out;
    const auto add = [&](const std::string& name) {
        if (!name.empty() && std::ranges::find(out, name) == out.end()) out.push_back(name);
    };
    for (const Holding& h : held)
        add(h.faces.object);
    for (const Load& l : loads)
        add(l.faces.object);
    return out;
}

Result<LoadCase> parse_load_case(const std::string& text, const std::string& file,
                                 const std::string& name) {
    const Result<JsonValue> json = parse_json(text, file);
    if (!json) return json.error();
    const JsonMember* cases = json->find("cases");
    if (!cases || !cases->value.is(JsonValue::Kind::kObject) || cases->value.members.empty())
        return user_error(fmt::format(messages::kNoCases, file), messages::kNoCasesHelp);
    std::vector<std::string> names;
    for (const JsonMember& m : cases->value.members)
        names.push_back(m.key);
    if (name.empty() && names.size() > 1)
        return usage_error(fmt::format(messages::kChooseCase, fmt::join(names, ", ")));
    const JsonMember* found = name.empty() ? cases->value.members.data() : cases->value.find(name);
    if (!found)
        return usage_error(fmt::format(messages::kNoSuchCase, name, fmt::join(names, ", ")));
    return CaseReader(file, json->find("objects")).read(*found);
}

Result<void> check_kind(const LoadCase& c, bool flows) {
    if ((c.kind != CaseKind::kForces) == flows) return {};
    Error error = user_error(fmt::format(messages::kCaseOfOther, c.name,
                                         c.kind == CaseKind::kForces    ? "forces"
                                         : c.kind == CaseKind::kCurrent ? "current"
                                                                        : "heat"),
                             flows ? messages::kPartTakesIt : messages::kConductTakesIt);
    error.location = c.location;
    return error;
}

Result<LoadCase> read_load_case(const std::filesystem::path& world, const std::string& name) {
    const Result<std::string> text = read_text_file(world, kMostWorldBytes);
    if (!text) return text.error();
    return parse_load_case(*text, world.string(), name);
}

}  // namespace openfab::mechanics
