// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/search.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace openfab::fit {

namespace {

/// Of the differences that slopes are made of, in the unit cube: steps of voxels average out over it.
constexpr double kStep = 0.01;
/// Methods end where unknowns change by less.
constexpr double kLeastMove = 1e-7;
/// Random starts, after that of the user.
constexpr int32_t kMoreStarts = 3;
/// They aim so much closer than is good enough.
constexpr double kCloser = 0.1;

class Searcher {
  public:
    Searcher(size_t unknowns, std::span<const Wanted> wanted, const Values& values,
             const SearchOptions& options)
        : unknowns_(unknowns), wanted_(wanted), values_(values), options_(options) {
        for (size_t g = 0; g < wanted.size(); ++g) {
            if (wanted[g].aim != 0) aim_ = g;
            const bool both = wanted[g].at_least && wanted[g].at_most;
            if (both && *wanted[g].at_least == *wanted[g].at_most) {
                equal_.push_back({g, 1});
                continue;
            }
            if (wanted[g].at_most) bounded_.push_back({g, 1});
            if (wanted[g].at_least) bounded_.push_back({g, -1});
        }
    }

    Result<SearchResult> run(std::vector<double> start) {
        start_ = std::move(start);
        uint64_t state = options_.seed;
        for (int32_t again = 0; again <= kMoreStarts; ++again) {
            again_ = again > 0;
            // As many conditions as unknowns, or fewer, can all hold.
            bool ended = equal_.size() <= unknowns_ && run_slopes();
            if (stopped()) break;
            if (!(ended && is_reached(best_, wanted_))) ended = run_simplices();
            if (stopped() || (ended && is_reached(best_, wanted_))) break;
            for (double& x : start_)
                x = next_number(&state);
        }
        if (error_) return *error_;
        SearchResult out;
        out.best = best_;
        out.interrupted = interrupted();
        out.reached = !best_.values.empty() && is_reached(best_, wanted_);
        return out;
    }

  private:
    /// A condition of a value: that it does not rise above its bound (1), or fall below it (-1).
    struct Condition {
        size_t goal;
        double sign;
    };
    struct Destroy {
        void operator()(nlopt_opt opt) const { nlopt_destroy(opt); }
    };
    using Method = std::unique_ptr<nlopt_opt_s, Destroy>;

    /// Also where what makes the values was, which is a program at times.
    bool interrupted() const {
        return interrupted_ || (options_.interrupt != nullptr && options_.interrupt->load());
    }
    bool stopped() const { return error_.has_value() || interrupted(); }
    /// A size by which values are of the order of 1.
    double size_of(size_t goal) const { return 1000 * wanted_[goal].within; }

    void stop_at(const Error& error) {
        interrupted_ = error.code == ErrorCode::kInterrupted;
        if (!interrupted_) error_ = error;
        if (method_ != nullptr) nlopt_force_stop(method_.get());
    }

    /// Returns the values at a point; nothing where the method must end.
    const std::vector<double>* evaluate(std::span<const double> x) {
        if (stopped()) {
            if (method_ != nullptr) nlopt_force_stop(method_.get());
            return nullptr;
        }
        Result<std::vector<double>> found = values_(x);
        if (!found) {
            stop_at(found.error());
            return nullptr;
        }
        last_ = {{x.begin(), x.end()}, std::move(*found)};
        if (best_.x.empty() || is_better(last_, best_, wanted_)) best_ = last_;
        return &last_.values;
    }

    /// Whether nothing is left to be done: there is nothing to make less or more.
    bool is_done(const std::vector<double>& values) const {
        if (aim_) return false;
        for (size_t g = 0; g < wanted_.size(); ++g) {
            if (std::abs(wanted_[g].beyond(values[g])) > kCloser) return false;
        }
        return true;
    }

    /// Returns the slopes of all values at a point, [value][unknown]; nothing where the method must end.
    std::optional<std::vector<double>> slopes(std::span<const double> x) {
        if (options_.slopes) {
            if (stopped()) return {};
            Result<std::vector<double>> found = options_.slopes(x);
            if (found) return std::move(*found);
            stop_at(found.error());
            return {};
        }
        std::vector<double> out(wanted_.size() * unknowns_);
        std::vector<double> at(x.begin(), x.end());
        for (size_t u = 0; u < unknowns_; ++u) {
            // Newton's method gets there by slopes to one side, too; where something is made least, they say where.
            double low = std::max(0.0, x[u] - kStep), high = std::min(1.0, x[u] + kStep);
            if (!aim_) (x[u] < 0.5 ? low : high) = x[u];
            at[u] = low;
            const std::vector<double>* values = evaluate(at);
            if (values == nullptr) return {};
            const std::vector<double> below = *values;
            at[u] = high;
            values = evaluate(at);
            if (values == nullptr) return {};
            for (size_t g = 0; g < wanted_.size(); ++g)
                out[g * unknowns_ + u] = ((*values)[g] - below[g]) / (high - low);
            at[u] = x[u];
        }
        return out;
    }

    static double objective(unsigned n, const double* x, double* gradient, void* self) {
        return static_cast<Searcher*>(self)->far_or_aim({x, n}, gradient);
    }

    /// What SLSQP makes least: the value that is to be least or most; and how far the unknowns are moved.
    double far_or_aim(std::span<const double> x, double* gradient) {
        const double weight = aim_ ? 1e-9 : 1e-4;
        double sum = 0;
        for (size_t u = 0; u < unknowns_; ++u) {
            sum += weight * (x[u] - start_[u]) * (x[u] - start_[u]);
            if (gradient != nullptr) gradient[u] = 2 * weight * (x[u] - start_[u]);
        }
        if (!aim_) return sum;
        const std::vector<double>* values = evaluate(x);
        if (values == nullptr) return sum;
        const double scale = -wanted_[*aim_].aim / aim_size_;
        sum += scale * (*values)[*aim_];
        if (gradient == nullptr) return sum;
        const std::optional<std::vector<double>> slope = slopes(x);
        for (size_t u = 0; slope && u < unknowns_; ++u)
            gradient[u] += scale * (*slope)[*aim_ * unknowns_ + u];
        return sum;
    }

    struct Conditions {
        Searcher* self;
        const std::vector<Condition>* all;
    };

    static void conditions(unsigned count, double* result, unsigned n, const double* x,
                           double* gradient, void* data) {
        const auto* of = static_cast<Conditions*>(data);
        of->self->hold(*of->all, {x, n}, {result, count}, gradient);
    }

    void hold(const std::vector<Condition>& all, std::span<const double> x,
              std::span<double> result, double* gradient) {
        std::ranges::fill(result, 0.0);
        const std::vector<double>* values = evaluate(x);
        if (values == nullptr) return;
        for (size_t k = 0; k < all.size(); ++k) {
            const Wanted& wanted = wanted_[all[k].goal];
            const double bound = all[k].sign > 0 ? *wanted.at_most : *wanted.at_least;
            result[k] = all[k].sign * ((*values)[all[k].goal] - bound) / size_of(all[k].goal);
        }
        if (is_done(*values)) nlopt_force_stop(method_.get());
        if (gradient == nullptr) return;
        const std::optional<std::vector<double>> slope = slopes(x);
        for (size_t k = 0; k < all.size(); ++k) {
            for (size_t u = 0; u < unknowns_; ++u) {
                gradient[k * unknowns_ + u] =
                    slope
                        ? all[k].sign * (*slope)[all[k].goal * unknowns_ + u] / size_of(all[k].goal)
                        : 0;
            }
        }
    }

    void make_method(nlopt_algorithm algorithm) {
        method_.reset(nlopt_create(algorithm, static_cast<unsigned>(unknowns_)));
        nlopt_set_lower_bounds1(method_.get(), 0);
        nlopt_set_upper_bounds1(method_.get(), 1);
        nlopt_set_xtol_abs1(method_.get(), kLeastMove);
        nlopt_set_maxeval(method_.get(), options_.most_evaluations);
    }

    /// Runs a method from a point; returns whether it ended by itself.
    bool optimize(std::vector<double> from) {
        double value = 0;
        const nlopt_result ended = nlopt_optimize(method_.get(), from.data(), &value);
        const bool done = !best_.values.empty() && is_done(best_.values);
        method_.reset();
        return done || (ended > 0 && ended != NLOPT_MAXEVAL_REACHED);
    }

    bool run_slopes() {
        const std::vector<double>* values = evaluate(start_);
        if (values == nullptr) return false;
        if (is_done(*values)) return true;
        if (aim_) aim_size_ = std::max(std::abs((*values)[*aim_]), 1e-9);
        make_method(NLOPT_LD_SLSQP);
        nlopt_set_min_objective(method_.get(), objective, this);
        Conditions equal{this, &equal_}, bounded{this, &bounded_};
        for (Conditions* of : {&equal, &bounded}) {
            if (of->all->empty()) continue;
            const std::vector<double> tolerances(of->all->size(), 1e-3 * kCloser);
            const auto count = static_cast<unsigned>(of->all->size());
            const auto add =
                of == &equal ? nlopt_add_equality_mconstraint : nlopt_add_inequality_mconstraint;
            add(method_.get(), count, conditions, of, tolerances.data());
        }
        return optimize(start_);
    }

    static double penalty(unsigned n, const double* x, double* /*gradient*/, void* self) {
        return static_cast<Searcher*>(self)->far_beyond({x, n});
    }

    /// What simplices make least: how far values are beyond their bounds, and hardly what is aimed at.
    double far_beyond(std::span<const double> x) {
        const std::vector<double>* values = evaluate(x);
        if (values == nullptr) return std::numeric_limits<double>::max();
        double sum = 0;
        for (size_t g = 0; g < wanted_.size(); ++g) {
            const double beyond = std::abs(wanted_[g].beyond((*values)[g]));
            sum += 1e-3 * (aim_ ? beyond : std::max(0.0, beyond - kCloser));
        }
        if (aim_) sum -= 1e-4 * wanted_[*aim_].aim * (*values)[*aim_] / aim_size_;
        return sum;
    }

    bool run_simplices() {
        if (best_.x.empty() && evaluate(start_) == nullptr) return false;
        make_method(NLOPT_LN_SBPLX);
        nlopt_set_min_objective(method_.get(), penalty, this);
        nlopt_set_initial_step1(method_.get(), 0.2);
        if (!aim_) nlopt_set_stopval(method_.get(), 0);
        return optimize(again_ ? start_ : best_.x);
    }

    const size_t unknowns_;
    const std::span<const Wanted> wanted_;
    const Values& values_;
    const SearchOptions& options_;
    std::vector<Condition> equal_, bounded_;
    std::optional<size_t> aim_;
    double aim_size_ = 1;
    bool again_ = false;  ///< from a start of its own, not from the best
    std::vector<double> start_;
    Method method_;
    Point last_, best_;
    std::optional<Error> error_;
    bool interrupted_ = false;
};

}  // namespace

double next_number(uint64_t* state) {
    uint64_t z = (*state += 0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

double Wanted::beyond(double value) const {
    if (at_least && value < *at_least) return (value - *at_least) / within;
    if (at_most && value > *at_most) return (value - *at_most) / within;
    return 0;
}

bool is_reached(const Point& point, std::span<const Wanted> wanted) {
    for (size_t g = 0; g < wanted.size(); ++g) {
        if (std::abs(wanted[g].beyond(point.values[g])) > 1) return false;
    }
    return true;
}

bool is_better(const Point& a, const Point& b, std::span<const Wanted> wanted) {
    const bool reached = is_reached(a, wanted);
    if (reached != is_reached(b, wanted)) return reached;
    double beyond = 0, aim = 0;
    for (size_t g = 0; g < wanted.size(); ++g) {
        beyond += std::abs(wanted[g].beyond(a.values[g])) - std::abs(wanted[g].beyond(b.values[g]));
        aim += wanted[g].aim * (a.values[g] - b.values[g]);
    }
    // What is reached is made less or more; without that, nearer is better.
    return reached && aim != 0 ? aim > 0 : beyond < 0;
}

Result<SearchResult> search_unknowns(std::vector<double> start, std::span<const Wanted> wanted,
                                     const Values& values, const SearchOptions& options) {
    const size_t unknowns = start.size();
    return Searcher(unknowns, wanted, values, options).run(std::move(start));
}

}  // namespace openfab::fit
