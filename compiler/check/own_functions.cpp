// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Built-in functions whose arguments are not all of one type: noises, hashes, what has `out`
// parameters, derivatives, the bits of numbers. A word encodes their parameters, one letter
// each:
//   p  float or vector of floats; all `p` of a call have one size
//   o  an `out` of that type
//   q  as many ints as `p` has components; one is meant for all
//   x  any number or vector, kept as it is
//   i  int    f  float    s  seed, an int or uint
// `?` precedes optional ones. The result is p, void (v), uint (u) or n
// floats (1 to 4).
#include "compiler/check/own_functions.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <string>
#include <string_view>
#include <utility>

#include "compiler/check/nodes.h"

namespace openfab::check {

namespace {

struct OwnFunction {
    Intrinsic id;
    const char* parameters;
    char result;
    int least_size;  ///< of p and x
    int most_size;
};

constexpr OwnFunction kOwnFunctions[] = {
    {Intrinsic::kSincos, "poo", 'v', 1, 4},
    {Intrinsic::kModf, "po", 'p', 1, 4},
    {Intrinsic::kFrexp, "po", 'p', 1, 4},
    {Intrinsic::kRefract, "ppf", 'p', 1, 4},
    {Intrinsic::kDdx, "p", 'p', 1, 4},
    {Intrinsic::kDdy, "p", 'p', 1, 4},
    {Intrinsic::kFwidth, "p", 'p', 1, 4},
    {Intrinsic::kNoise, "p?s", '1', 1, 4},
    {Intrinsic::kNoiseGradient, "p?s", 'p', 1, 4},
    {Intrinsic::kPnoise, "pq?s", '1', 1, 4},
    {Intrinsic::kPnoiseGradient, "pq?s", 'p', 1, 4},
    {Intrinsic::kSimplex, "p?s", '1', 2, 4},
    {Intrinsic::kSimplexGradient, "p?s", 'p', 2, 4},
    {Intrinsic::kCellular, "p?s", '3', 2, 3},
    {Intrinsic::kFbm, "pi?ffs", '1', 1, 4},
    {Intrinsic::kTurbulence, "pi?ffs", '1', 1, 4},
    {Intrinsic::kCurl, "p?s", 'p', 2, 3},
    {Intrinsic::kHash, "x?s", '1', 1, 4},
    {Intrinsic::kHash2, "x?s", '2', 1, 4},
    {Intrinsic::kHash3, "x?s", '3', 1, 4},
    {Intrinsic::kHash4, "x?s", '4', 1, 4},
    {Intrinsic::kHashUint, "x?s", 'u', 1, 4},
};

const OwnFunction& own_function(Intrinsic id) {
    return *std::find_if(std::begin(kOwnFunctions), std::end(kOwnFunctions),
                         [&](const OwnFunction& f) { return f.id == id; });
}

bool is_derivative(Intrinsic id) {
    return id == Intrinsic::kDdx || id == Intrinsic::kDdy || id == Intrinsic::kFwidth;
}

std::string sized(const char* base, int least, int most) {
    std::string out;
    for (int size = least; size <= most; ++size) {
        out += (out.empty() ? "" : "|") + std::string(base);
        if (size > 1) out += std::to_string(size);
    }
    return out;
}

/// `fbm(float|float2|float3|float4 p, int octaves, float lacunarity = 2, …)`
std::string signature(const OwnFunction& f, std::string_view name) {
    std::string out;
    int floats = 0;
    bool optional = false;
    for (const char* at = f.parameters; *at != 0; ++at) {
        if (*at == '?') {
            optional = true;
            continue;
        }
        if (!out.empty()) out += ", ";
        switch (*at) {
            case 'p':
                out += sized("float", f.least_size, f.most_size);
                break;
            case 'o':
                out += "out of that type";
                break;
            case 'q':
                out += "as many ints";
                break;
            case 'x':
                out += "numbers";
                break;
            case 'i':
                out += "int octaves";
                break;
            case 'f':
                out += !optional ? "float eta" : floats++ == 0 ? "float lacunarity" : "float gain";
                break;
            default:
                out += "uint seed";
                break;
        }
        if (optional) out += *at == 's' ? " = 0" : floats == 1 ? " = 2" : " = 0.5";
    }
    return fmt::format("`{}({})`", name, out);
}

struct ParameterCount {
    size_t least = 0;
    size_t most = 0;
};

ParameterCount parameter_count(const OwnFunction& f) {
    ParameterCount out;
    bool optional = false;
    for (const char* at = f.parameters; *at != 0; ++at) {
        if (*at == '?') {
            optional = true;
            continue;
        }
        ++out.most;
        if (!optional) ++out.least;
    }
    return out;
}

/// Returns the size of `p`, or 0 where the arguments do not fit.
int common_size(const OwnFunction& f, const std::vector<ExprPtr>& args) {
    int size = 0;
    size_t index = 0;
    for (const char* at = f.parameters; *at != 0; ++at) {
        if (*at == '?') continue;
        if (index == args.size()) break;
        const Type& type = args[index++]->type;
        if (!type.is_numeric()) return 0;
        const bool scalar = *at == 'i' || *at == 'f' || *at == 's';
        if (scalar && !type.is_scalar()) return 0;
        if (*at == 's' && !type.is_integer()) return 0;
        if (*at == 'q' && !type.is_integer()) return 0;
        if ((*at == 'p' || *at == 'x') && type.size > 1) {
            if (size > 1 && type.size != size) return 0;
            size = type.size;
        }
        if ((*at == 'p' || *at == 'x') && size == 0) size = 1;
        if (*at == 'q' && type.size != 1 && type.size != size) return 0;
        if (*at == 'o' && type != Type{Base::kFloat, size}) return 0;
    }
    return size >= f.least_size && size <= f.most_size ? size : 0;
}

}  // namespace

bool writes_an_argument(Intrinsic id) {
    return std::any_of(
        std::begin(kOwnFunctions), std::end(kOwnFunctions), [&](const OwnFunction& f) {
            return f.id == id && std::string_view(f.parameters).find('o') != std::string_view::npos;
        });
}

ExprPtr OwnFunctions::call(const ast::Expr& expr, const IntrinsicInfo& info,
                           std::vector<ExprPtr> args) const {
    const OwnFunction& f = own_function(info.id);
    const ast::Expr& callee = *expr.args[0];
    if (is_derivative(info.id) &&
        (rules_.refuse_in_dither(callee.span, info.name) ||
         rules_.refuse_in_shape(callee.span, info.name,
                                "a shape has no micropolygons; `gradient(f, p)` differentiates a "
                                "function")))
        return poison(expr.span);
    if (is_derivative(info.id) && place_.context != StageContext::kSurface &&
        place_.context != StageContext::kFunction) {
        diag::Diagnostic& d =
            sink_->report(callee.span, diag::kStageMismatch, info.name,
                          place_.context == StageContext::kGlobal ? "called outside a stage"
                                                                  : "called in a volume stage");
        if (place_.context == StageContext::kVolume)
            d.note(place_.stage, "stage declared `@Volume` here");
        d.help("it is the change along the surface's micropolygons; a volume has none");
        return poison(expr.span);
    }
    const ParameterCount count = parameter_count(f);
    if (args.size() < count.least || args.size() > count.most) {
        const std::string right =
            count.least == count.most
                ? fmt::format("{} argument{}", count.most, count.most == 1 ? "" : "s")
                : fmt::format("{} to {} arguments", count.least, count.most);
        wrong_count(sink_, expr, info.name, right, args.size());
        return poison(expr.span);
    }
    const int size = common_size(f, args);
    if (size == 0) {
        std::string given;
        for (const ExprPtr& arg : args)
            given += (given.empty() ? "" : ", ") + type_name(arg->type);
        diag::Diagnostic& d = sink_->report(callee.span, diag::kNoOverload, info.name, given);
        d.help(fmt::format("it is {}", signature(f, info.name)));
        const bool coordinates = f.parameters[0] == 'p' && args.size() > 1 && args.size() <= 4 &&
                                 std::all_of(args.begin(), args.end(), [](const ExprPtr& arg) {
                                     return arg->type == kFloatType;
                                 });
        if (coordinates) d.help("coordinates go in one vector, as in `float2(x, y)`");
        return poison(expr.span);
    }
    return convert_arguments(expr, info, f.parameters, f.result, size, std::move(args));
}

ExprPtr OwnFunctions::convert_arguments(const ast::Expr& expr, const IntrinsicInfo& info,
                                        const char* parameters, char result, int size,
                                        std::vector<ExprPtr> args) const {
    const auto constant = [&](const Type& type, uint32_t bits) {
        ExprPtr value = make(ExprKind::kConstant, type, expr.span);
        value->bits = bits;
        return value;
    };
    ExprPtr out = make(ExprKind::kIntrinsic, kVoidType, expr.span);
    out->intrinsic = info.id;
    const Type floats{Base::kFloat, size};
    size_t index = 0;
    int float_scalars = 0;
    for (const char* at = parameters; *at != 0; ++at) {
        if (*at == '?') continue;
        if (index == args.size()) {
            const float left_out = float_scalars++ == 0 ? 2.0f : 0.5f;
            args.push_back(*at == 's' ? constant(kUintType, 0)
                                      : constant(kFloatType, std::bit_cast<uint32_t>(left_out)));
        } else if (*at == 'f') {
            ++float_scalars;
        }
        ExprPtr& arg = args[index++];
        switch (*at) {
            case 'p':
                arg = conversions_.implicit(std::move(arg), floats);
                break;
            case 'q':
                arg = conversions_.implicit(std::move(arg), {Base::kInt, size});
                break;
            case 'i':
                arg = conversions_.implicit(std::move(arg), kIntType);
                break;
            case 'f':
                arg = conversions_.implicit(std::move(arg), kFloatType);
                break;
            case 's':
                arg = conversions_.implicit(std::move(arg), kUintType);
                break;
            case 'o':
                if (!targets_.assignable(*arg)) return poison(expr.span);
                break;
            default:  // 'x': any numbers, as they are
                break;
        }
        if (arg->type.is_error()) return poison(expr.span);
    }
    out->args = std::move(args);
    if (result == 'p') out->type = floats;
    if (result == 'u') out->type = kUintType;
    if (result >= '1' && result <= '4') out->type = {Base::kFloat, result - '0'};
    return out;
}

}  // namespace openfab::check
