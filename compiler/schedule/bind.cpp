// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// bind: chooses branches, and puts numbers in the place of parameters.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "compiler/schedule/rules.h"
#include "compiler/schedule/schedule.h"

namespace openfab::schedule {

namespace {

class Binder {
  public:
    Binder(const File& file, const Binding& binding) : binding_(binding) {
        out_.path = file.path;
        out_.file = file.file;
        out_.target = binding.target;
    }

    std::variant<Schedule, Fault> run(const File& file) {
        if (!items(file.items)) return std::move(fault_);
        return std::move(out_);
    }

  private:
    bool fail(const Word& where, std::string message, std::string help = {}) {
        fault_ = fault_at(where, std::move(message), std::move(help));
        return false;
    }

    bool items(const std::vector<Item>& list) {
        return std::all_of(list.begin(), list.end(), [&](const Item& item) {
            return std::visit([&](const auto& what) { return bind(what); }, item.what);
        });
    }

    bool bind(const Param& param) {
        for (const Param& other : out_.params) {
            if (other.name.text == param.name.text) {
                return fail(
                    param.name,
                    fmt::format("there is a parameter `{}` already, of line {}{}", param.name.text,
                                other.name.line,
                                other.path == param.path ? "" : fmt::format(" of {}", other.path)));
            }
        }
        Param bound = param;
        const auto given = binding_.params.find(param.name.text);
        if (given != binding_.params.end()) bound.value = given->second;
        if (!bound.allows(bound.value)) {
            return fail(param.name, fmt::format("`{}` is set to {}, which is not in {}",
                                                param.name.text, bound.value, param.set()));
        }
        out_.params.push_back(std::move(bound));
        return true;
    }

    bool bind(const When& when) {
        for (const When::Branch& branch : when.branches) {
            bool chosen = true;
            if (branch.condition && !holds(*branch.condition, &chosen)) return false;
            if (chosen) return items(branch.items);
        }
        return true;
    }

    bool holds(const Condition& condition, bool* out) {
        using Kind = Condition::Kind;
        switch (condition.kind) {
            case Kind::kTarget:
                *out = has(condition.words[0].text);
                return true;
            case Kind::kCompare:
                return compare(condition.words, out);
            case Kind::kNot:
                if (!holds(condition.conditions[0], out)) return false;
                *out = !*out;
                return true;
            case Kind::kAnd:
            case Kind::kOr:
                break;
        }
        // Each is looked at, so that a mistake in one shows whatever the others say.
        const bool all = condition.kind == Kind::kAnd;
        *out = all;
        for (const Condition& each : condition.conditions) {
            bool one = false;
            if (!holds(each, &one)) return false;
            *out = all ? *out && one : *out || one;
        }
        return true;
    }

    bool has(const std::string& target) const {
        const std::vector<std::string>& all = targets();
        return std::find(all.begin(), all.end(), target) <=
               std::find(all.begin(), all.end(), binding_.target);
    }

    bool compare(const std::vector<Word>& words, bool* out) {
        int64_t left = 0;
        int64_t right = 0;
        if (!number(words[0], &left) || !number(words[2], &right)) return false;
        const std::string& sign = words[1].text;
        *out = sign == "<"    ? left < right
               : sign == ">"  ? left > right
               : sign == "<=" ? left <= right
               : sign == ">=" ? left >= right
               : sign == "==" ? left == right
                              : left != right;
        return true;
    }

    /// Reads a number, a parameter or `vector_lanes`.
    bool number(const Word& word, int64_t* out) {
        const char* end = word.text.data() + word.text.size();
        const auto [stop, error] = std::from_chars(word.text.data(), end, *out);
        if (error == std::errc() && stop == end && *out >= 0 && *out <= kMostNumber) return true;
        if (word.text[0] >= '0' && word.text[0] <= '9') {
            return fail(word, fmt::format("expected a whole number up to {}", kMostNumber));
        }
        if (word.text == kVectorLanes) {
            *out = vector_lanes(binding_.target);
            return true;
        }
        std::vector<std::string> names;
        for (const Param& param : out_.params) {
            if (param.name.text == word.text) {
                *out = param.value;
                return true;
            }
            names.push_back(param.name.text);
        }
        names.emplace_back(kVectorLanes);
        return fail(
            word,
            fmt::format("`{}` is not a number, nor a parameter from a line before", word.text),
            near_or_all(word.text, names, "there are"));
    }

    bool bind(const Line& line) {
        Line bound = line;
        for (Directive& directive : bound.directives) {
            const DirectiveRule* rule = find_rule(directive.name.text);
            for (size_t k = 0; k < directive.args.size(); ++k) {
                if (!is_number(*rule, directive, k)) continue;
                int64_t value = 0;
                if (!number(directive.args[k], &value)) return false;
                directive.args[k].text = std::to_string(value);
            }
        }
        out_.lines.push_back(std::move(bound));
        return true;
    }

    static bool is_number(const DirectiveRule& rule, const Directive& directive, size_t k) {
        if (!rule.args.empty() && rule.args[0] == ArgKind::kCondition) {
            // var [% number] sign number
            return k + 1 == directive.args.size() || (k == 2 && directive.args[1].text == "%");
        }
        return rule.args[std::min(k, rule.args.size() - 1)] == ArgKind::kNumber;
    }

    const Binding& binding_;
    Schedule out_;
    Fault fault_;
};

bool any_param(const std::vector<Item>& items, const std::string& name) {
    return std::any_of(items.begin(), items.end(), [&](const Item& item) {
        if (const auto* param = std::get_if<Param>(&item.what)) return param->name.text == name;
        const auto* when = std::get_if<When>(&item.what);
        return when != nullptr &&
               std::any_of(when->branches.begin(), when->branches.end(),
                           [&](const auto& branch) { return any_param(branch.items, name); });
    });
}

}  // namespace

const std::vector<std::string>& targets() {
    static const std::vector<std::string> all = {"sse41", "avx2", "avx512"};
    return all;
}

int64_t vector_lanes(std::string_view target) {
    return target == "avx512" ? 16 : target == "avx2" ? 8 : 4;
}

bool has_param(const File& file, const std::string& name) {
    return any_param(file.items, name);
}

std::variant<Schedule, Fault> bind(const File& file, const Binding& binding) {
    return Binder(file, binding).run(file);
}

}  // namespace openfab::schedule
