// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A kernel while a schedule is applied to it: the loops that each Func has by now, in our names, and
// where it is computed. Halide knows the same, but says what is wrong late, and in words of its own.

#include <Halide.h>

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/lower/algorithm/kernel.h"
#include "compiler/schedule/schedule.h"

namespace openfab::lower {

struct Loop {
    enum class Kind { kSerial, kVector, kUnrolled, kParallel };

    std::string name;  ///< Halide's too, but for `taps$x`, which is taps_x here
    Halide::VarOrRVar var;
    std::optional<int64_t> extent;  ///< where it is the same in every call
    Kind kind = Kind::kSerial;
    bool reduces = false;  ///< over a reduction: its order is what the result is
    bool is_part = false;  ///< of a split, maybe fused with another since
};

/// The loops of one definition of a Func, or of a specialization of it.
struct LoopNest {
    Halide::Stage stage;
    std::vector<Loop> loops;      ///< innermost first
    std::set<std::string> names;  ///< ever used
    std::string condition;        ///< of a specialization, as written
    size_t given = 0;             ///< loops before any directive

    /// Returns whether something asks for other loops than the Func's own, one after the other.
    bool is_changed() const;
    Loop* find(const std::string& name);
    const Loop* find(const std::string& name) const {
        return const_cast<LoopNest*>(this)->find(name);
    }
};

/// Where a Func is computed or stored.
struct Placement {
    enum class Level { kInline, kRoot, kAt };
    Level level = Level::kInline;
    size_t func = 0;                          ///< of kAt
    std::string var;                          ///< of kAt
    std::optional<schedule::Word> directive;  ///< what put it there; none: the kernel itself
};

/// A vectorized part of a loop of what is stored between stages. Halide is told of it when it is known
/// that vectors are whole wherever the Func is computed: where the last one is masked, Halide 14 drops
/// the stores behind an update, and mixes up lanes of loops that are vectorized inside each other.
struct PartVector {
    size_t definition = 0;
    std::string loop;
    schedule::Word directive;
};

/// What a Func fetches before it reads it.
struct Prefetch {
    size_t func = 0;  ///< that is read
    std::string var;
    schedule::Word directive;
};

/// What a line says is enough of a dimension of a Func's storage.
struct StorageFold {
    std::string var;  ///< Halide's
    int64_t extent = 0;
    schedule::Word directive;
};

struct ScheduledFunc {
    std::string name;
    Halide::Func func;
    /// [definition][0: general, then specializations]; none for a Func that the runtime computes.
    std::vector<std::vector<LoopNest>> definitions;
    std::vector<std::set<size_t>> calls;  ///< by definition: the Funcs that it reads
    /// By definition: those of them on which depends which steps of its reduction there are.
    std::vector<std::set<size_t>> conditions;
    Placement compute;
    std::optional<Placement> store;  ///< where it is not where it is computed
    std::vector<StorageFold> folds;
    std::vector<PartVector> part_vectors;
    std::vector<Prefetch> prefetches;
    std::optional<schedule::Word> last_word;  ///< of the last line that names it
    bool is_listed = true;                    ///< in Kernel::funcs
    bool is_result = false;
    bool has_memory = false;  ///< a line says which: store_in
    bool is_read_by_extern = false;

    bool is_extern() const { return definitions.empty(); }
    bool is_reduction() const { return definitions.size() > 1; }
    /// It has no loops of its own: it is part of what reads it. A reduction that nothing places is
    /// computed at its reader's innermost loop.
    bool is_inline() const { return compute.level == Placement::Level::kInline; }
    /// Returns the word that places it, else the last line that names it.
    std::optional<schedule::Word> placed_by() const;
};

/// One loop around something.
struct LoopSite {
    size_t func = 0;
    const Loop* loop = nullptr;
};

/// The loops of one var of a definition in lowered code: Halide's names of them begin and end so.
struct LoopNames {
    std::string begin;  ///< "weights.s0."
    std::string end;    ///< ".column"

    LoopNames(const ScheduledFunc& func, size_t definition, const Loop& loop);
    /// Loops that do not begin at 0 are made to, under another name.
    bool has(std::string_view name) const {
        constexpr std::string_view kFromZero = ".rebased";
        if (name.ends_with(kFromZero)) name.remove_suffix(kFromZero.size());
        return name.starts_with(begin) && name.ends_with(end);
    }
};

class ScheduledKernel {
  public:
    explicit ScheduledKernel(const Kernel& kernel);

    std::vector<ScheduledFunc>& funcs() { return funcs_; }
    const std::vector<ScheduledFunc>& funcs() const { return funcs_; }
    /// Returns the index of a Func that a schedule may name.
    std::optional<size_t> find(std::string_view name) const;
    std::vector<std::string> names() const;
    /// Returns a dimension's extent in the kernel's first result.
    std::optional<Halide::Expr> result_extent(const std::string& var) const;

    /// A definition of a Func that is computed in loops.
    struct Use {
        size_t func = 0;
        size_t definition = 0;
        bool operator<(const Use& other) const {
            return func != other.func ? func < other.func : definition < other.definition;
        }
    };
    /// Returns where a Func is read, through Funcs that are inline.
    std::set<Use> uses(size_t func) const;

    /// Returns whether `reader` reads `func`, itself or through others.
    bool reads(size_t reader, size_t func) const;
    /// Returns the definitions of `at` in whose loops `func` is read, by them or by what is computed
    /// inside.
    std::set<size_t> definitions_that_need(size_t at, size_t func) const;

    /// Returns whether the steps of a reduction depend on a Func, itself or through Funcs that are
    /// inline.
    bool decides(size_t func, size_t reduction) const;

    /// Returns the loops, outermost first, in which everything that reads a Func is computed, and in
    /// each of which it may be computed itself.
    std::vector<LoopSite> loops_around_uses(size_t func) const;

    /// Unrolls the loops that are to be. Halide is told of them when it is known how often they write
    /// out what is inside: what is too much code takes it minutes, or more memory than there is.
    std::vector<LoopNames> unrolled() const;
    void unroll_loops();

    /// Vectorizes the parts of loops for which Halide has waited.
    bool has_part_vectors() const;
    void vectorize_parts();

    /// Returns the loops around a Func's computation, outermost first, after check_placements.
    std::vector<LoopSite> path(size_t func) const;
    /// Returns how many of them are around its storage, too; more than there are where it is stored in
    /// a loop that is none of them.
    size_t loops_to_storage(size_t func) const;

  private:
    void add(const Halide::Func& func, const std::string& name, const NamedFunc* named);
    void add_calls();
    /// Where the kernel has two results computed in the same loops, what one reads counts as read by
    /// the other, whose loops they are.
    void join_fused();
    size_t index_of(const Halide::Internal::Function& function);
    /// Returns whether an inline Func reads `func`, itself or through others that are inline.
    bool reads_inline(size_t func, size_t part) const;

    std::vector<ScheduledFunc> funcs_;
    Halide::Func output_;
};

}  // namespace openfab::lower
