// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The little numerics that fitting a printer takes.

#include <cstddef>
#include <functional>
#include <vector>

namespace openfab::color {

/// A square matrix.
class Square {
  public:
    explicit Square(size_t size) : size_(size), values_(size * size) {}
    size_t size() const { return size_; }
    double& at(size_t row, size_t column) { return values_[row * size_ + column]; }
    double at(size_t row, size_t column) const { return values_[row * size_ + column]; }

  private:
    size_t size_;
    std::vector<double> values_;
};

/// Replaces a symmetric positive definite matrix by its inverse, by Cholesky's method; returns false
/// where it is not positive definite.
bool invert_positive(Square* matrix);

/// Minimises the sum of squares of `count` residuals by Levenberg's and Marquardt's method with
/// differences for derivatives, from the given values on; returns the sum.
using Residuals =
    std::function<void(const std::vector<double>& values, std::vector<double>* residuals)>;
double minimise_squares(const Residuals& residuals, size_t count, std::vector<double>* values);

}  // namespace openfab::color
