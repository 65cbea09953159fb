// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/number_slab.h"

#include <algorithm>
#include <array>
#include <utility>

#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

class SlabNumbers final : public ArrayNumbers {
  public:
    SlabNumbers(std::unique_ptr<ArrayNumbers> whole, texture::XdmfSlab slab)
        : whole_(std::move(whole)), slab_(std::move(slab)), index_(slab_.sizes.size(), 0) {}

    Result<void> next(double* out, size_t count) override {
        const size_t last = index_.size() - 1;
        while (count > 0) {
            if (at_end_) return user_error(messages::kArrayCutShort);
            if (Result<void> there = pass_over(place() - passed_); !there) return there;
            const bool dense = slab_.stride[last] == 1;
            const auto row = static_cast<size_t>(slab_.count[last] - index_[last]);
            const size_t run = dense ? std::min(count, row) : 1;
            if (Result<void> got = whole_->next(out, run); !got) return got;
            passed_ += static_cast<int64_t>(run);
            out += run;
            count -= run;
            advance(static_cast<int64_t>(run));
        }
        return {};
    }

    bool are_integers() const override { return whole_->are_integers(); }
    bool has_lost() const override { return whole_->has_lost(); }

  private:
    /// Of the number at hand in the whole array.
    int64_t place() const {
        int64_t out = 0;
        for (size_t a = 0; a < index_.size(); ++a)
            out = out * slab_.sizes[a] + slab_.start[a] + index_[a] * slab_.stride[a];
        return out;
    }
    Result<void> pass_over(int64_t count) {
        std::array<double, 1024> unused{};
        while (count > 0) {
            const auto n = static_cast<size_t>(std::min<int64_t>(count, unused.size()));
            if (Result<void> got = whole_->next(unused.data(), n); !got) return got;
            passed_ += static_cast<int64_t>(n);
            count -= static_cast<int64_t>(n);
        }
        return {};
    }
    /// Goes on in the last row, or to the next one.
    void advance(int64_t by) {
        index_.back() += by;
        for (size_t a = index_.size(); a-- > 0 && index_[a] == slab_.count[a];) {
            index_[a] = 0;
            if (a == 0) {
                at_end_ = true;
            } else {
                ++index_[a - 1];
            }
        }
    }

    std::unique_ptr<ArrayNumbers> whole_;
    texture::XdmfSlab slab_;
    std::vector<int64_t> index_;
    int64_t passed_ = 0;  ///< numbers of the whole array
    bool at_end_ = false;
};

}  // namespace

std::unique_ptr<ArrayNumbers> take_slab(std::unique_ptr<ArrayNumbers> whole,
                                        const texture::XdmfSlab& slab) {
    return std::make_unique<SlabNumbers>(std::move(whole), slab);
}

}  // namespace openfab::tools
