// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/lru_cache.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <vector>

namespace openfab {
namespace {

struct Text {
    explicit Text(size_t of, int says = 0) : size(of), number(says) {}
    size_t bytes() const { return size; }
    size_t size;
    int number;
};
using Cache = LruCache<int32_t, Text>;

std::shared_ptr<const Text> text(size_t bytes, int number = 0) {
    return std::make_shared<const Text>(bytes, number);
}

TEST(LruCache, DropsWhatWasUsedLongestAgo) {
    Cache cache(4000, 4000);
    for (int32_t key = 0; key < 3; ++key)
        cache.insert(key, text(1000));
    EXPECT_NE(cache.find(0), nullptr);
    cache.insert(3, text(1000));
    EXPECT_EQ(cache.find(1), nullptr);
    for (const int32_t key : {0, 2, 3})
        EXPECT_NE(cache.find(key), nullptr) << key;
    EXPECT_EQ(cache.counts().evictions, 1);
    EXPECT_EQ(cache.counts().misses, 1);
    EXPECT_EQ(cache.counts().hits, 4);
}

TEST(LruCache, DropsWhatRecentPeriodsDidNotUse) {
    Cache cache(100'000, 100'000);
    for (int32_t key = 0; key < 4; ++key)
        cache.insert(key, text(1000));
    cache.begin_period(1);
    EXPECT_EQ(cache.counts().evictions, 0);
    for (const int32_t key : {1, 3})
        EXPECT_NE(cache.find(key), nullptr) << key;
    cache.begin_period(1);
    for (const int32_t key : {0, 2})
        EXPECT_EQ(cache.find(key), nullptr) << key;
    EXPECT_NE(cache.find(1), nullptr);
    cache.begin_period(2);
    EXPECT_NE(cache.find(3), nullptr);  // two periods ago
    for (int period = 0; period < 3; ++period)
        cache.begin_period(2);
    EXPECT_EQ(cache.counts().evictions, 4);
    cache.insert(5, text(1000));
    EXPECT_NE(cache.find(5), nullptr);
}

TEST(LruCache, NeverHoldsMoreThanItsBudget) {
    Cache cache(10000, 10000);
    for (int32_t key = 0; key < 1000; ++key)
        cache.insert(key, text(static_cast<size_t>(key) * 7 % 3000));
    EXPECT_LE(cache.counts().peak_bytes, 10000);
    EXPECT_GT(cache.counts().peak_bytes, 6000);
}

TEST(LruCache, HoldsTheKeysThatAListInOrderOfUseHolds) {
    constexpr size_t kEntries = 50;
    Cache cache(kEntries * 1500, kEntries * 1500);
    std::vector<int32_t> recent;  // most recent first
    uint32_t random = 1;
    for (int i = 0; i < 20000; ++i) {
        random = random * 1664525u + 1013904223u;
        const auto key = static_cast<int32_t>((random >> 16) % 120 * 64);
        const auto held = std::find(recent.begin(), recent.end(), key);
        ASSERT_EQ(cache.find(key) != nullptr, held != recent.end()) << i;
        if (held != recent.end()) {
            recent.erase(held);
        } else {
            cache.insert(key, text(1400, key));
            if (recent.size() == kEntries) recent.pop_back();
        }
        recent.insert(recent.begin(), key);
    }
}

TEST(LruCache, ANewBudgetHoldsFromThenOn) {
    Cache cache(5000, 5000);
    for (int32_t key = 0; key < 4; ++key)
        cache.insert(key, text(1000));
    cache.set_budget(10000);
    for (int32_t key = 4; key < 8; ++key)
        cache.insert(key, text(1000));
    EXPECT_EQ(cache.counts().evictions, 0);
    cache.set_budget(3000);
    EXPECT_EQ(cache.counts().evictions, 6);
    cache.insert(8, text(1000));
    EXPECT_EQ(cache.counts().evictions, 7);
    EXPECT_NE(cache.find(7), nullptr);
    EXPECT_NE(cache.find(8), nullptr);
}

TEST(LruCache, WhatDoesNotFitComesBackAndIsNotKept) {
    Cache cache(1000, 1000);
    cache.insert(1, text(100));
    EXPECT_EQ(cache.insert(2, text(2000, 5))->number, 5);
    EXPECT_EQ(cache.find(2), nullptr);
    EXPECT_NE(cache.find(1), nullptr);
}

TEST(LruCache, WhatDoesNotFitIsKeptAloneWhereThatIsAsked) {
    Cache cache(4000, 4000, LargeValues::kAreKeptAlone);
    cache.insert(1, text(1000));
    cache.insert(2, text(5000));
    EXPECT_EQ(cache.find(1), nullptr);
    EXPECT_NE(cache.find(2), nullptr);
    cache.insert(3, text(1000));
    EXPECT_EQ(cache.find(2), nullptr);
    EXPECT_NE(cache.find(3), nullptr);
    cache.insert(4, text(1000));
    EXPECT_NE(cache.find(3), nullptr);
}

TEST(LruCache, TheFirstOfTwoStays) {
    Cache cache(10000, 10000);
    EXPECT_EQ(cache.insert(1, text(10, 1))->number, 1);
    EXPECT_EQ(cache.insert(1, text(10, 2))->number, 1);
}

TEST(LruCache, WhatIsHeldOutlivesTheCache) {
    std::shared_ptr<const Text> held;
    {
        Cache cache(1000, 1000);
        held = cache.insert(1, text(500, 7));
        cache.insert(2, text(500));
        EXPECT_EQ(cache.find(1), nullptr);
    }
    EXPECT_EQ(held->number, 7);
}

TEST(LruCache, ThreadsGetTheValueOfTheKey) {
    Cache cache(100000, 1000);
    tbb::parallel_for(0, 20000, [&](int i) {
        const int32_t key = i * 131 % 500;
        std::shared_ptr<const Text> found = cache.find(key);
        if (found == nullptr) found = cache.insert(key, text(400, key));
        ASSERT_EQ(found->number, key);
    });
    EXPECT_LE(cache.counts().peak_bytes, 100000);
    EXPECT_GT(cache.counts().evictions, 0);
}

}  // namespace
}  // namespace openfab
