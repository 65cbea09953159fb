// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Random expressions of OpenFL, of what is in scope.

#include <array>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace openfab::testing::random_text {

enum class Base { kBool, kInt, kUint, kFloat };

struct Type {
    Base base = Base::kFloat;
    int size = 1;
    bool operator==(const Type&) const = default;
};

constexpr Type kBool{Base::kBool, 1}, kInt{Base::kInt, 1}, kFloat{Base::kFloat, 1};

std::string spelling(const Type& type);

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers on every system.
class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed) {}
    uint64_t bits() {
        uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    int below(int n) { return static_cast<int>(bits() % static_cast<uint64_t>(n)); }
    bool chance(int percent) { return below(100) < percent; }
    template <typename T, size_t N>
    const T& of(const std::array<T, N>& choices) {
        return choices[static_cast<size_t>(below(static_cast<int>(N)))];
    }

  private:
    uint64_t state_;
};

/// A part of a text.
struct Piece {
    std::string text;
    Piece(std::string value) : text(std::move(value)) {}
    Piece(const char* value) : text(value) {}
    Piece(int value) : text(std::to_string(value)) {}
};

/// Replaces `{}` or `{k}` in `format` by pieces, `{{` and `}}` by braces. Not fmt::format, whose
/// arguments, and with them the random choices, may be evaluated in any order; a braced list is
/// evaluated from left to right.
std::string fill(std::string_view format, std::initializer_list<Piece> pieces);

struct Variable {
    std::string name;
    Type type;
    int array = 0;  ///< elements; 0: no array
    bool writable = true;
};

struct Helper {
    std::string name;
    Type result;
    std::vector<Type> parameters;
    bool last_is_inout = false;
};

class RandomExpressions {
  protected:
    explicit RandomExpressions(uint64_t seed) : random_(seed) {}

    std::vector<const Variable*> variables(bool writable) const;
    Type random_type();
    std::string literal(Base base);
    std::string leaf(const Type& type);
    std::string swizzle(int from, int count);
    std::string construct(const Type& type, int depth);
    std::string atom(const Type& type, int depth);
    std::string expression(const Type& type, int depth);
    std::string index(int count, int depth);
    std::string array_element(const Type& type, int depth);
    std::string helper_call(const Type& type, int depth);
    std::string target_of(const Type& type);
    std::string boolean(const Type& type, int depth);
    std::string integer(const Type& type, int depth);
    std::string floating(const Type& type, int depth);

    Random random_;
    std::vector<Variable> scope_;
    std::vector<Helper> helpers_;
    bool wild_ = false;  ///< `wild` is in scope
};

}  // namespace openfab::testing::random_text
