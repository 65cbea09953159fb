// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/support/ir/read.h"

#include <fmt/format.h>

#include <bit>
#include <charconv>
#include <utility>

#include "compiler/ir/text.h"

namespace openfab::ir {

namespace {

/// Splits a line into words; a quoted word keeps its spaces.
std::vector<std::string> split(std::string_view line) {
    std::vector<std::string> words;
    size_t i = 0;
    while (i < line.size()) {
        if (line[i] == ' ') {
            ++i;
            continue;
        }
        std::string word;
        if (line[i] == '"') {
            for (++i; i < line.size() && line[i] != '"'; ++i) {
                const bool escape = line[i] == '\\' && i + 1 < line.size();
                if (escape) ++i;
                word += escape && line[i] == 'n' ? '\n' : line[i];
            }
            ++i;
        } else {
            for (; i < line.size() && line[i] != ' '; ++i)
                word += line[i];
        }
        words.push_back(std::move(word));
    }
    return words;
}

template <typename T>
std::optional<T> number(std::string_view text, int base = 10) {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

std::optional<uint32_t> constant_bits(Type type, std::string_view text) {
    switch (type) {
        case Type::kBool:
            if (text == "true") return 1;
            if (text == "false") return 0;
            return std::nullopt;
        case Type::kInt: {
            const std::optional<int32_t> value = number<int32_t>(text);
            if (!value) return std::nullopt;
            return static_cast<uint32_t>(*value);
        }
        case Type::kUint:
            return number<uint32_t>(text);
        case Type::kFloat:
            break;
    }
    if (text.substr(0, 6) == "nan:0x") return number<uint32_t>(text.substr(6), 16);
    float value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return std::bit_cast<uint32_t>(value);
}

class Reader {
  public:
    explicit Reader(std::string_view text) : text_(text) {}

    std::optional<Fablet> run(std::string* fault) {
        int line = 0;
        while (!text_.empty() && fault_.empty()) {
            ++line;
            const size_t end = text_.find('\n');
            words_ = split(text_.substr(0, end));
            text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
            at_ = 0;
            if (words_.empty() || words_[0][0] == '#') continue;
            read_line();
            if (fault_.empty() && at_ != words_.size()) fail("unexpected `" + words_[at_] + "`");
        }
        if (fault_.empty()) return std::move(fablet_);
        if (fault != nullptr) *fault = fmt::format("line {}: {}", line, fault_);
        return std::nullopt;
    }

  private:
    void fail(std::string what) {
        if (fault_.empty()) fault_ = std::move(what);
    }
    std::string next() {
        if (at_ < words_.size()) return words_[at_++];
        fail("the line ends early");
        return "";
    }
    void expect(const char* word) {
        if (next() != word) fail(fmt::format("expected `{}`", word));
    }
    int32_t next_int() {
        const std::optional<int32_t> value = number<int32_t>(next());
        if (!value) fail("expected an integer");
        return value.value_or(0);
    }
    Type next_type() {
        const std::string word = next();
        for (Type type : {Type::kBool, Type::kInt, Type::kUint, Type::kFloat}) {
            if (word == spelling(type)) return type;
        }
        fail(fmt::format("no type `{}`", word));
        return Type::kFloat;
    }
    int32_t next_kind() {
        const std::string word = next();
        const std::optional<int32_t> kind = kind_from_name(word);
        if (!kind) fail(fmt::format("no input or output kind `{}`", word));
        return kind.value_or(0);
    }
    int32_t next_query_result() {
        const std::string word = next();
        for (int32_t kind = 0; kind <= OPENFAB_QUERY_END_ON; ++kind) {
            if (word == query_result_name(kind)) return kind;
        }
        fail(fmt::format("no result of a query `{}`", word));
        return 0;
    }
    ValueId next_value() {
        const std::string word = next();
        const std::optional<ValueId> id =
            word.size() > 1 && word[0] == '%' ? number<ValueId>(word.substr(1)) : std::nullopt;
        if (!id) fail(fmt::format("expected a value, not `{}`", word));
        return id.value_or(0);
    }
    uint32_t next_constant(Type type) {
        const std::string word = next();
        const std::optional<uint32_t> bits = constant_bits(type, word);
        if (!bits) fail(fmt::format("`{}` is not a valid {}", word, spelling(type)));
        return bits.value_or(0);
    }
    std::vector<uint32_t> read_defaults(Type type) {
        std::vector<uint32_t> bits;
        if (at_ == words_.size()) return bits;
        expect("=");
        while (at_ < words_.size() && fault_.empty())
            bits.push_back(next_constant(type));
        return bits;
    }

    void read_line() {
        const std::string word = next();
        if (word[0] == '%') return read_instr(word);
        if (word == "fablet") {
            fablet_.name = next();
        } else if (word == "counts") {
            read_counts();
        } else if (word == "uniform") {
            read_uniform();
        } else if (word == "annotation" && !fablet_.uniforms.empty()) {
            std::string name = next();
            fablet_.uniforms.back().annotations.emplace_back(std::move(name), next());
        } else if (word == "in") {
            fablet_.surface_inputs.push_back(read_varying());
        } else if (word == "out") {
            fablet_.surface_outputs.push_back(read_varying());
        } else if (word == "nearest") {
            fablet_.nearest.push_back(read_varying());
        } else if (word == "stage") {
            read_stage();
        } else if ((word == "printf" || word == "assert") && stage_ != nullptr) {
            Printf p;
            p.is_assert = word == "assert";
            p.format = next();
            p.source = next();
            p.line = next_int();
            p.column = next_int();
            stage_->printfs.push_back(std::move(p));
        } else if (word == "output" && stage_ != nullptr) {
            read_output();
        } else {
            fail(fmt::format("unexpected `{}`", word));
        }
    }

    void read_counts() {
        expect("values");
        fablet_.uniform_value_count = next_int();
        expect("textures");
        fablet_.texture_count = next_int();
        expect("objects");
        fablet_.object_count = next_int();
        expect("slots");
        fablet_.slot_count = next_int();
        expect("void");
        fablet_.void_slot = next_int();
    }

    void read_uniform() {
        Uniform uniform;
        uniform.type_name = next();
        uniform.name = next();
        const std::string kind = next();
        bool known = false;
        for (openfab_uniform_kind candidate :
             {OPENFAB_UNIFORM_VALUE, OPENFAB_UNIFORM_TEXTURE2D, OPENFAB_UNIFORM_MATERIAL,
              OPENFAB_UNIFORM_TEXTURE3D, OPENFAB_UNIFORM_OBJECT}) {
            if (kind != uniform_kind_name(candidate)) continue;
            uniform.kind = candidate;
            known = true;
        }
        if (!known) fail(fmt::format("no kind of uniform `{}`", kind));
        uniform.type = next_type();
        uniform.components = next_int();
        expect("x");
        uniform.array_length = next_int();
        expect("at");
        uniform.first_index = next_int();
        uniform.default_bits = read_defaults(uniform.type);
        fablet_.uniforms.push_back(std::move(uniform));
    }

    Varying read_varying() {
        Varying varying;
        varying.type_name = next();
        varying.name = next();
        varying.type = next_type();
        varying.components = next_int();
        expect("source");
        varying.source = next_int();
        varying.default_bits = read_defaults(varying.type);
        return varying;
    }

    void read_stage() {
        const std::string name = next();
        for (StageKind kind :
             {StageKind::kSurface, StageKind::kSurfaceBounds, StageKind::kSurfaceSegment,
              StageKind::kVolume, StageKind::kVolumeBounds, StageKind::kVolumeDemand,
              StageKind::kVolumeSegment, StageKind::kDerived, StageKind::kShape,
              StageKind::kShapeBounds}) {
            if (name != stage_name(kind)) continue;
            const bool surface =
                kind <= StageKind::kSurfaceBounds || kind == StageKind::kSurfaceSegment;
            stage_ = surface ? &fablet_.surface : &fablet_.volume;
            stage_->kind = kind;
            fablet_.has_surface = fablet_.has_surface || surface;
            return;
        }
        fail(fmt::format("no stage `{}`", name));
    }

    void read_output() {
        Output output;
        output.name = next();
        output.kind = next_kind();
        output.a = next_int();
        output.b = next_int();
        output.value = next_value();
        stage_->outputs.push_back(std::move(output));
    }

    void read_instr(const std::string& result) {
        if (stage_ == nullptr) return fail("an instruction outside a stage");
        if (result != fmt::format("%{}", stage_->instrs.size())) {
            return fail(fmt::format("expected %{}", stage_->instrs.size()));
        }
        expect("=");
        Instr instr;
        const std::string name = next();
        bool known = false;
        for (size_t op = 0; op < kOpCount; ++op) {
            if (name != spelling(static_cast<Op>(op))) continue;
            instr.op = static_cast<Op>(op);
            known = true;
        }
        if (!known) return fail(fmt::format("no operation `{}`", name));
        instr.type = next_type();
        if (instr.op == Op::kConst) instr.bits = next_constant(instr.type);
        if (instr.op == Op::kInput) instr.kind = next_kind();
        if (instr.op == Op::kQueryResult) instr.kind = next_query_result();
        const bool wide = instr.op == Op::kInput || instr.op == Op::kQueryResult;
        if (wide || has_a(instr.op)) instr.a = next_int();
        if (wide || instr.op == Op::kSample || instr.op == Op::kSampleBound) instr.b = next_int();
        if (instr.op == Op::kSampleBound) instr.bits = static_cast<uint32_t>(next_int());
        if (instr.op == Op::kTable) {
            instr.a = next_int();
            instr.b = next_int();
            instr.bits = static_cast<uint32_t>(next_int());
        }
        while (at_ < words_.size() && fault_.empty())
            instr.args.push_back(next_value());
        stage_->instrs.push_back(std::move(instr));
    }

    std::string_view text_;
    std::vector<std::string> words_;
    size_t at_ = 0;
    std::string fault_;
    Fablet fablet_;
    Stage* stage_ = nullptr;
};

}  // namespace

std::optional<int32_t> kind_from_name(std::string_view name) {
    for (int32_t kind = 0; kind <= kVoxelIndex; ++kind) {
        const char* candidate = kind_name(kind);
        if (candidate != nullptr && name == candidate) return kind;
    }
    return std::nullopt;
}

std::optional<Fablet> read(std::string_view text, std::string* fault) {
    return Reader(text).run(fault);
}

}  // namespace openfab::ir
