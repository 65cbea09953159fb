// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/stage_bounds.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "abi/fablet_table.h"

namespace openfab::tools {

namespace {

using ir::Op;
using ir::Type;

constexpr double kPi = std::numbers::pi;

double number_of(Type type, uint32_t bits) {
    if (type == Type::kFloat) return static_cast<double>(std::bit_cast<float>(bits));
    if (type == Type::kInt) return static_cast<double>(static_cast<int32_t>(bits));
    return static_cast<double>(bits);
}

/// Of these numbers all that are; none where one is not a number, such as infinity times 0.
ValueBounds hull(std::initializer_list<double> numbers) {
    if (std::ranges::any_of(numbers, [](double x) { return std::isnan(x); })) return {};
    const auto [lo, hi] = std::minmax(numbers);
    return {lo, hi};
}

ValueBounds both(const ValueBounds& a, const ValueBounds& b) {
    return {std::min(a.lo, b.lo), std::max(a.hi, b.hi)};
}

ValueBounds product(const ValueBounds& a, const ValueBounds& b) {
    return hull({a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi});
}

ValueBounds magnitude(const ValueBounds& a) {
    const double most = std::max(std::fabs(a.lo), std::fabs(a.hi));
    if (a.lo <= 0 && a.hi >= 0) return {0, most};
    return {std::min(std::fabs(a.lo), std::fabs(a.hi)), most};
}

class Bounds {
  public:
    Bounds(const IrStage& stage, std::span<const uint32_t> uniforms, const StagePlace& place,
           const std::vector<bool>& undefined)
        : stage_(stage), uniforms_(uniforms), place_(place), undefined_(undefined) {}

    std::vector<ValueBounds> all() {
        for (const IrLine& line : stage_.lines)
            known_.push_back(line.type == Type::kBool ? ValueBounds{0, 1} : of(line));
        return std::move(known_);
    }

  private:
    ValueBounds at(uint32_t index) const {
        return index < known_.size() ? known_[index] : ValueBounds{};
    }

    ValueBounds of_input(const IrLine& line) const {
        const auto which = static_cast<size_t>(line.numbers.empty() ? 0 : line.numbers[0]);
        if (line.input == "uniform" && which < uniforms_.size())
            return hull({number_of(line.type, uniforms_[which])});
        if (which < 3 && line.input == "shape_point") return place_.point[which];
        if (which < 3 && line.input == "voxel_coord")
            return product(place_.point[which], {place_.scale[which], place_.scale[which]});
        if (line.input == "frame" && which < OPENFAB_FRAME_VOXEL_SIZE) return {0, 1};
        return {};
    }

    /// Of two where `a` < `b` decides; where `a` is undefined it is the second.
    ValueBounds of_extreme(const IrLine& line, const ValueBounds& a, const ValueBounds& b) const {
        ValueBounds out = line.op == Op::kMin
                              ? ValueBounds{std::min(a.lo, b.lo), std::min(a.hi, b.hi)}
                              : ValueBounds{std::max(a.lo, b.lo), std::max(a.hi, b.hi)};
        if (undefined_[line.args[0]]) out = both(out, b);
        return out;
    }

    ValueBounds of_convert(const IrLine& line, const ValueBounds& a) const {
        if (line.type == Type::kFloat) return a;
        ValueBounds out{std::trunc(a.lo), std::trunc(a.hi)};
        if (undefined_[line.args[0]]) out = both(out, {0, 0});
        // Negative ones wrap.
        const bool wraps = line.type == Type::kUint && out.lo < 0;
        return wraps ? ValueBounds{0, 0x1p32} : out;
    }

    ValueBounds of(const IrLine& line) const {
        const ValueBounds a = line.args.empty() ? ValueBounds{} : at(line.args[0]);
        const ValueBounds b = line.args.size() < 2 ? ValueBounds{} : at(line.args[1]);
        switch (line.op) {
            case Op::kConst:
                return hull({number_of(line.type, line.bits)});
            case Op::kInput:
                return of_input(line);
            case Op::kAdd:
                return hull({a.lo + b.lo, a.hi + b.hi});
            case Op::kSub:
                return hull({a.lo - b.hi, a.hi - b.lo});
            case Op::kMul:
                return line.args[0] == line.args[1] ? product(magnitude(a), magnitude(a))
                                                    : product(a, b);
            case Op::kDiv:
                if (line.type != Type::kFloat || (b.lo <= 0 && b.hi >= 0)) return {};
                return hull({a.lo / b.lo, a.lo / b.hi, a.hi / b.lo, a.hi / b.hi});
            case Op::kMod:
                return {-magnitude(b).hi, magnitude(b).hi};
            case Op::kNeg:
                return {-a.hi, -a.lo};
            case Op::kSelect:
                return line.args.size() < 3 ? ValueBounds{} : both(b, at(line.args[2]));
            case Op::kPick: {
                ValueBounds out = at(line.args.back());
                for (size_t i = 1; i < line.args.size(); ++i)
                    out = both(out, at(line.args[i]));
                return out;
            }
            case Op::kConvert:
                return of_convert(line, a);
            case Op::kMin:
            case Op::kMax:
                return of_extreme(line, a, b);
            case Op::kAbs:
                return magnitude(a);
            case Op::kSqrt:
                return {std::sqrt(std::max(a.lo, 0.0)), std::sqrt(std::max(a.hi, 0.0))};
            case Op::kFloor:
                return {std::floor(a.lo), std::floor(a.hi)};
            case Op::kCeil:
                return {std::ceil(a.lo), std::ceil(a.hi)};
            case Op::kRound:
                return {std::floor(a.lo), std::ceil(a.hi)};
            case Op::kTrunc:
                return {std::trunc(a.lo), std::trunc(a.hi)};
            case Op::kSin:
            case Op::kCos:
            case Op::kTanh:
                return {-1, 1};
            case Op::kAtan:
            case Op::kAsin:
                return {-kPi / 2, kPi / 2};
            case Op::kAtan2:
                return {-kPi, kPi};
            case Op::kAcos:
                return {0, kPi};
            case Op::kExp:
                return {std::exp(a.lo), std::exp(a.hi)};
            case Op::kExp2:
                return {std::exp2(a.lo), std::exp2(a.hi)};
            case Op::kCosh:
                return {1, std::cosh(magnitude(a).hi)};
            default:
                return {};  // no bounds, or what is refused
        }
    }

    const IrStage& stage_;
    std::span<const uint32_t> uniforms_;
    const StagePlace& place_;
    const std::vector<bool>& undefined_;
    std::vector<ValueBounds> known_;
};

}  // namespace

std::vector<ValueBounds> stage_bounds(const IrStage& stage, std::span<const uint32_t> uniforms,
                                      const StagePlace& place, const std::vector<bool>& undefined) {
    return Bounds(stage, uniforms, place, undefined).all();
}

}  // namespace openfab::tools
