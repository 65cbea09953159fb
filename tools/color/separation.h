// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The way back: from a colour to amounts of ink. The printer is a grid of colours, which a profile
// holds too; a colour is separated by least squares over it.
//
//   gamut     what the inks cannot reach becomes the nearest colour that they can, where hue counts
//             more than lightness and lightness more than chroma
//   black     of the many mixtures that give one dark colour, the one whose black is nearest to a
//             share of what black alone would need for that lightness; less in strong colours. Never at the
//             cost of the colour: where more black comes nearer, it is taken
//   limit     amounts add up to it at most

#include <vector>

#include "tools/color/printer_model.h"

namespace openfab::color {

/// Colours on a grid over inks, relative to the printer's white. Nodes lie at squares of equal
/// steps, as inks tint most where there is little of them. Amounts that add up to more than 1 stand
/// for the same mixture with a sum of 1; but nodes of cells that mixtures of 1 reach into continue what
/// lies within, so that these mixtures, which have no white, are interpolated without any.
class InkGrid {
  public:
    /// `nodes` an axis, 2 to 33.
    InkGrid(const PrinterModel& model, int nodes);

    int nodes() const { return nodes_; }
    /// Returns the colour of a node; `at` counts nodes along cyan, magenta, yellow, black.
    const Lab& node(const std::array<int, 4>& at) const { return colours_[index(at)]; }
    /// Interpolates as colour management does: along cyan linearly, in the others within
    /// tetrahedra. Takes roots of amounts, 0..1.
    Lab at_roots(const Inks& roots) const;
    Lab at(const Inks& inks) const;

  private:
    size_t index(const std::array<int, 4>& at) const {
        const auto n = static_cast<size_t>(nodes_);
        return ((static_cast<size_t>(at[0]) * n + static_cast<size_t>(at[1])) * n +
                static_cast<size_t>(at[2])) *
                   n +
               static_cast<size_t>(at[3]);
    }

    int nodes_;
    std::vector<Lab> colours_;
};

struct SeparationOptions {
    double black = 0.5;  ///< 0: as little as can be; 1: as much
    double limit = 1;    ///< of the sum of all inks
};

class Separation {
  public:
    Separation(const InkGrid& grid, const SeparationOptions& options);

    /// Returns the inks of a colour relative to the printer's white.
    Inks find(const Lab& colour) const;
    /// Returns the same colour with its lightness, and its chroma alike, scaled from `black` to 100 into
    /// what lies between the printer's black and white.
    Lab perceptual(const Lab& colour, double black) const;

  private:
    struct Start {
        Inks roots;
        Lab lab;
    };
    double wanted_black(const Lab& colour) const;
    void bring_to_limit(Inks* roots) const;
    /// Finds the roots with the least cost, black being held near what is wanted by a weight; returns how far
    /// the colour is off.
    double settle(const Lab& colour, double black, double weight, Inks* roots) const;
    double refine(const Lab& colour, double black, double weight, Inks* roots) const;
    /// Goes on in ever smaller steps of single inks and of one for another: where a colour is beyond reach, costs
    /// are flat and have edges, which slopes do not follow. Returns the cost.
    double polish(const Lab& colour, double black, double weight, Inks* roots) const;

    const InkGrid& grid_;
    SeparationOptions options_;
    std::vector<Start> starts_;
    std::vector<double> black_wedge_;  ///< lightness of black in equal steps of roots
    double darkest_ = 0;
};

}  // namespace openfab::color
