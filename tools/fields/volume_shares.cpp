// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/volume_shares.h"

#include <bit>
#include <map>
#include <set>

namespace openfab::tools {

namespace {

/// Ways through conditions that are looked at.
constexpr int kMostWays = 4096;

class Ways {
  public:
    Ways(const IrStage& stage, const std::vector<uint32_t>& amounts)
        : stage_(stage), amounts_(amounts) {}

    bool any_void() {
        if (++ways_ > kMostWays) return true;
        uint32_t open = 0;
        bool is_open = false, all_zero = true;
        for (const uint32_t amount : amounts_) {
            const uint32_t end = followed(amount);
            const IrLine& line = stage_.lines[end];
            if (line.op == ir::Op::kSelect) {
                open = line.args[0];
                is_open = true;
            } else if (!is_zero(line)) {
                all_zero = false;
            }
        }
        if (!all_zero) return false;  // however the others go
        if (!is_open) return true;
        for (const bool holds : {true, false}) {
            decided_[open] = holds;
            if (any_void()) return true;
        }
        decided_.erase(open);
        return false;
    }

    bool is_always_zero(uint32_t amount) const {
        std::vector<uint32_t> open{amount};
        std::set<uint32_t> seen;
        while (!open.empty()) {
            const uint32_t value = open.back();
            open.pop_back();
            if (!seen.insert(value).second) continue;
            const IrLine& line = stage_.lines[value];
            if (line.op == ir::Op::kSelect) {
                open.insert(open.end(), {line.args[1], line.args[2]});
            } else if (!is_zero(line)) {
                return false;
            }
        }
        return true;
    }

  private:
    static bool is_zero(const IrLine& line) {
        return line.op == ir::Op::kConst && !(std::bit_cast<float>(line.bits) > 0);
    }

    /// What a value is behind the conditions that are decided.
    uint32_t followed(uint32_t value) const {
        while (stage_.lines[value].op == ir::Op::kSelect) {
            const auto known = decided_.find(stage_.lines[value].args[0]);
            if (known == decided_.end()) break;
            value = stage_.lines[value].args[known->second ? 1 : 2];
        }
        return value;
    }

    const IrStage& stage_;
    const std::vector<uint32_t>& amounts_;
    std::map<uint32_t, bool> decided_;
    int ways_ = 0;
};

}  // namespace

bool may_be_void(const IrStage& stage, const std::vector<uint32_t>& amounts) {
    return Ways(stage, amounts).any_void();
}

int only_amount(const IrStage& stage, const std::vector<uint32_t>& amounts) {
    const Ways ways(stage, amounts);
    int only = -1;
    for (size_t i = 0; i < amounts.size(); ++i) {
        if (ways.is_always_zero(amounts[i])) continue;
        if (only >= 0) return -1;
        only = static_cast<int>(i);
    }
    return only;
}

}  // namespace openfab::tools
