// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/fablet_ir.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <iterator>

#include "base/text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

namespace {

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    for (size_t at = 0; at < line.size();) {
        const size_t end = std::min(line.find(' ', at), line.size());
        if (end > at) words.emplace_back(line.substr(at, end - at));
        at = end + 1;
    }
    return words;
}

int32_t number(const std::string& word) {
    return static_cast<int32_t>(std::strtol(word.c_str(), nullptr, 10));
}

/// The value of a `%N`.
uint32_t value_of(const std::string& word) {
    return static_cast<uint32_t>(std::strtoul(word.c_str() + 1, nullptr, 10));
}

bool read_type(const std::string& word, ir::Type* out) {
    constexpr std::string_view kTypes[] = {"bool", "int", "uint", "float"};
    const auto* const known = std::ranges::find(kTypes, word);
    *out = static_cast<ir::Type>(known - std::begin(kTypes));
    return known != std::end(kTypes);
}

bool read_op(const std::string& word, ir::Op* out) {
#define OPENFAB_SPELLING(name, spelling, ...) spelling,
    constexpr std::string_view kOps[] = {OPENFAB_IR_OPS(OPENFAB_SPELLING)};
#undef OPENFAB_SPELLING
    const auto* const known = std::ranges::find(kOps, word);
    *out = static_cast<ir::Op>(known - std::begin(kOps));
    return known != std::end(kOps);
}

uint32_t constant_bits(ir::Type type, const std::string& word) {
    if (type == ir::Type::kBool) return word == "true" ? 1 : 0;
    if (type == ir::Type::kInt) return static_cast<uint32_t>(number(word));
    if (type == ir::Type::kUint)
        return static_cast<uint32_t>(std::strtoul(word.c_str(), nullptr, 10));
    constexpr std::string_view kNan = "nan:";
    if (word.starts_with(kNan))
        return static_cast<uint32_t>(std::strtoul(word.c_str() + kNan.size(), nullptr, 16));
    return std::bit_cast<uint32_t>(std::strtof(word.c_str(), nullptr));
}

/// The text in quotes, of which `"`, `\` and the ends of lines are escaped.
std::string unquoted(std::string_view text) {
    std::string out;
    for (size_t i = 1; i + 1 < text.size(); ++i) {
        if (text[i] != '\\') {
            out += text[i];
            continue;
        }
        ++i;
        out += text[i] == 'n' ? '\n' : text[i];
    }
    return out;
}

class Reader {
  public:
    Result<FabletIr> run(std::string_view text) {
        int32_t number_of_line = 0;
        while (!text.empty()) {
            const size_t end = std::min(text.find('\n'), text.size());
            const std::string_view one = text.substr(0, end);
            text.remove_prefix(std::min(end + 1, text.size()));
            ++number_of_line;
            if (!line(one))
                return internal_error(
                    fmt::format(messages::kCompilerLine, number_of_line, printable(one)));
        }
        if (out_.volume.empty()) return internal_error(messages::kNoVolumeStage);
        return std::move(out_);
    }

  private:
    bool line(std::string_view text) {
        const std::vector<std::string> words = words_of(text);
        if (words.empty()) return true;
        const std::string& first = words[0];
        if (first.starts_with('%')) return instruction(words);
        if (first == "output") return output(words);
        if (first == "fablet" && words.size() == 2) {
            out_.name = words[1];
        } else if (first == "counts" && words.size() == 11) {
            out_.value_count = number(words[2]);
            out_.texture_count = number(words[4]);
            out_.object_count = number(words[6]);
            out_.slot_count = number(words[8]);
            out_.void_slot = number(words[10]);
        } else if (first == "uniform") {
            return uniform(words);
        } else if (first == "annotation" && words.size() > 2) {
            // Names of an enum's values.
            if (words[1] == "@choices" && !out_.uniforms.empty())
                out_.uniforms.back().type_name += "\n" + unquoted(text.substr(text.find('"')));
        } else if (first == "shape" && text.ends_with("is a distance")) {
            out_.shape_is_distance = true;
        } else if (first == "grows") {
            out_.grows = true;
        } else if (first == "stage" && words.size() == 2) {
            out_.has_surface |= words[1] == "surface";
            out_.has_dither |= words[1] == "dither";
            stage_ = words[1] == "shape"    ? &out_.shape
                     : words[1] == "volume" ? &out_.volume
                                            : &other_;
            *stage_ = {};
        }
        return true;
    }

    bool uniform(const std::vector<std::string>& words) {
        // uniform TYPE NAME KIND TYPE COMPONENTS x LENGTH at INDEX = VALUE …
        if (words.size() < 10 || words[6] != "x" || words[8] != "at") return false;
        IrUniform u;
        u.type_name = words[1];
        u.name = words[2];
        u.kind = words[3];
        if (!read_type(words[4], &u.type)) return false;
        u.components = number(words[5]);
        u.array_length = number(words[7]);
        u.first_index = number(words[9]);
        for (size_t i = 11; i < words.size(); ++i)
            u.default_bits.push_back(constant_bits(u.type, words[i]));
        out_.uniforms.push_back(std::move(u));
        return true;
    }

    bool instruction(const std::vector<std::string>& words) {
        // %N = OP TYPE …
        if (stage_ == nullptr || words.size() < 4 || value_of(words[0]) != stage_->lines.size())
            return false;
        IrLine made;
        if (!read_op(words[2], &made.op) || !read_type(words[3], &made.type)) return false;
        size_t at = 4;
        if (made.op == ir::Op::kConst) {
            if (words.size() != 5) return false;
            made.bits = constant_bits(made.type, words[at++]);
        } else if (made.op == ir::Op::kInput) {
            if (words.size() != 7) return false;
            made.input = words[at++];
        }
        for (; at < words.size(); ++at) {
            if (!words[at].starts_with('%')) {
                made.numbers.push_back(number(words[at]));
                continue;
            }
            made.args.push_back(value_of(words[at]));
            if (made.args.back() >= stage_->lines.size()) return false;
        }
        stage_->lines.push_back(std::move(made));
        return true;
    }

    bool output(const std::vector<std::string>& words) {
        // output NAME KIND A B %VALUE
        if (stage_ == nullptr || words.size() != 6) return false;
        IrOutput made{words[1], words[2], number(words[3]), value_of(words[5])};
        if (made.value >= stage_->lines.size()) return false;
        stage_->outputs.push_back(std::move(made));
        return true;
    }

    FabletIr out_;
    IrStage other_;  ///< one that is not kept
    IrStage* stage_ = nullptr;
};

}  // namespace

Result<FabletIr> read_fablet_ir(std::string_view text) {
    return Reader().run(text);
}

}  // namespace openfab::tools
