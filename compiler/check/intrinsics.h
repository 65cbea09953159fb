// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Every built-in function that is no form of its own, in families: X(Name, "spelling", arguments, shape). Meaning, per component unless said; every operation rounds to float:
//   abs sign min max clamp(x,a,b) = min(max(x,a),b), saturate(x) = clamp(x,0,1); min(a,b) = a<b?a:b, max(a,b) = a>b?a:b
//   floor ceil round (halves to even) trunc, frac(x) = x - floor(x), fmod(x,y) = x - y*trunc(x/y)
//   rsqrt(x) = 1/sqrt(x), step(a,x) = x>=a ? 1 : 0, lerp(a,b,t) = a + t*(b-a), mad(a,b,c) = a*b + c in two roundings
//   smoothstep(a,b,x) = t*t*(3 - 2*t), t = saturate((x-a)/(b-a)); radians(x) = x*(pi/180), degrees(x) = x*(180/pi)
//   dot(a,b) = ((a.x*b.x + a.y*b.y) + a.z*b.z) + a.w*b.w, length(v) = sqrt(dot(v,v)), distance(a,b) = length(a-b)
//   normalize(v) = v/length(v), reflect(i,n) = i - (2*dot(i,n))*n, cross(a,b).x = a.y*b.z - a.z*b.y
//   faceforward(n,i,g) = dot(i,g)<0 ? n : -n
//   select(c,a,b) = c ? a : b with all three evaluated, and(a,b) or(a,b) of bools (compiler/check/conditions.cpp)
//
// A switch over them has no `default`: it names the functions that it builds and the families of the others by
// OPENFAB_INTRINSIC_CASES, so that the build fails wherever a new row must be handled.
// clang-format off

#define OPENFAB_COMPONENT_INTRINSICS(X) \
    X(Abs, "abs", 1, kNumeric) \
    X(Sign, "sign", 1, kToInt) \
    X(Min, "min", 2, kNumeric) \
    X(Max, "max", 2, kNumeric) \
    X(Clamp, "clamp", 3, kNumeric) \
    X(Mad, "mad", 3, kNumeric) \
    X(Saturate, "saturate", 1, kFloat) \
    X(Floor, "floor", 1, kFloat) \
    X(Ceil, "ceil", 1, kFloat) \
    X(Round, "round", 1, kFloat) \
    X(Trunc, "trunc", 1, kFloat) \
    X(Frac, "frac", 1, kFloat) \
    X(Fmod, "fmod", 2, kFloat) \
    X(Sqrt, "sqrt", 1, kFloat) \
    X(Rsqrt, "rsqrt", 1, kFloat) \
    X(Rcp, "rcp", 1, kFloat) \
    X(Step, "step", 2, kFloat) \
    X(Smoothstep, "smoothstep", 3, kFloat) \
    X(Lerp, "lerp", 3, kFloat) \
    X(Radians, "radians", 1, kFloat) \
    X(Degrees, "degrees", 1, kFloat) \
    X(IsNan, "isnan", 1, kToBool) \
    X(IsInf, "isinf", 1, kToBool) \
    X(IsFinite, "isfinite", 1, kToBool)

#define OPENFAB_GEOMETRIC_INTRINSICS(X) \
    X(Any, "any", 1, kReduceBool) \
    X(All, "all", 1, kReduceBool) \
    X(Dot, "dot", 2, kDot) \
    X(Length, "length", 1, kReduce) \
    X(Distance, "distance", 2, kReduce) \
    X(Normalize, "normalize", 1, kFloat) \
    X(Reflect, "reflect", 2, kFloat) \
    X(Faceforward, "faceforward", 3, kFloat) \
    X(Cross, "cross", 2, kFloat3)

#define OPENFAB_CHOICE_INTRINSICS(X) \
    X(Select, "select", 3, kSelect) \
    X(And, "and", 2, kBool) \
    X(Or, "or", 2, kBool)

// IR functions of the same name, per component; compiler/functions/README.md states their errors.
#define OPENFAB_ELEMENTARY_INTRINSICS(X) \
    X(Sin, "sin", 1, kFloat) \
    X(Cos, "cos", 1, kFloat) \
    X(Tan, "tan", 1, kFloat) \
    X(Asin, "asin", 1, kFloat) \
    X(Acos, "acos", 1, kFloat) \
    X(Atan, "atan", 1, kFloat) \
    X(Atan2, "atan2", 2, kFloat) \
    X(Sinh, "sinh", 1, kFloat) \
    X(Cosh, "cosh", 1, kFloat) \
    X(Tanh, "tanh", 1, kFloat) \
    X(Exp, "exp", 1, kFloat) \
    X(Exp2, "exp2", 1, kFloat) \
    X(Log, "log", 1, kFloat) \
    X(Log2, "log2", 1, kFloat) \
    X(Log10, "log10", 1, kFloat) \
    X(Pow, "pow", 2, kFloat) \
    X(Cbrt, "cbrt", 1, kFloat)

// Of the bits of a number, per component.
#define OPENFAB_BITWISE_INTRINSICS(X) \
    X(Ldexp, "ldexp", 2, kFloat) \
    X(AsFloat, "asfloat", 1, kBits) \
    X(AsInt, "asint", 1, kBits) \
    X(AsUint, "asuint", 1, kBits) \
    X(CountBits, "countbits", 1, kBits) \
    X(ReverseBits, "reversebits", 1, kBits) \
    X(FirstBitHigh, "firstbithigh", 1, kBits) \
    X(FirstBitLow, "firstbitlow", 1, kBits)

// Those below are typed one by one in compiler/check/own_functions.cpp. Results in `out` parameters:
#define OPENFAB_SEVERAL_INTRINSICS(X) \
    X(Sincos, "sincos", 3, kOwn) \
    X(Modf, "modf", 2, kOwn) \
    X(Frexp, "frexp", 2, kOwn)

#define OPENFAB_BENDING_INTRINSICS(X) \
    X(Refract, "refract", 3, kOwn)

#define OPENFAB_DERIVATIVE_INTRINSICS(X) \
    X(Ddx, "ddx", 1, kOwn) \
    X(Ddy, "ddy", 1, kOwn) \
    X(Fwidth, "fwidth", 1, kOwn)

#define OPENFAB_FIELD_INTRINSICS(X) \
    X(Noise, "noise", 2, kOwn) \
    X(NoiseGradient, "noise_gradient", 2, kOwn) \
    X(Pnoise, "pnoise", 3, kOwn) \
    X(PnoiseGradient, "pnoise_gradient", 3, kOwn) \
    X(Simplex, "simplex", 2, kOwn) \
    X(SimplexGradient, "simplex_gradient", 2, kOwn) \
    X(Cellular, "cellular", 2, kOwn) \
    X(Fbm, "fbm", 5, kOwn) \
    X(Turbulence, "turbulence", 5, kOwn) \
    X(Curl, "curl", 2, kOwn) \
    X(Hash, "hash", 2, kOwn) \
    X(Hash2, "hash2", 2, kOwn) \
    X(Hash3, "hash3", 2, kOwn) \
    X(Hash4, "hash4", 2, kOwn) \
    X(HashUint, "hash_uint", 2, kOwn)

#define OPENFAB_INTRINSICS(X) \
    OPENFAB_COMPONENT_INTRINSICS(X) \
    OPENFAB_GEOMETRIC_INTRINSICS(X) \
    OPENFAB_CHOICE_INTRINSICS(X) \
    OPENFAB_ELEMENTARY_INTRINSICS(X) \
    OPENFAB_BITWISE_INTRINSICS(X) \
    OPENFAB_SEVERAL_INTRINSICS(X) \
    OPENFAB_BENDING_INTRINSICS(X) \
    OPENFAB_DERIVATIVE_INTRINSICS(X) \
    OPENFAB_FIELD_INTRINSICS(X)

#define OPENFAB_INTRINSIC_CASE(name, ...) case ::openfab::check::Intrinsic::k##name:
#define OPENFAB_INTRINSIC_CASES(family) OPENFAB_##family##_INTRINSICS(OPENFAB_INTRINSIC_CASE)
