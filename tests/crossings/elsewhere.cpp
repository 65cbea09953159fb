// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Words of the product that no column shows, and why. A new command, option or kind of mesh is either here or in a column or
// row: complete_test.cpp asks.

#include "tests/crossings/columns.h"

namespace openfab::testing {

namespace {

constexpr Elsewhere kElsewhere[] = {
    // Commands.
    {"new", "makes a folder, of no world"},
    {"coupon", "makes a folder, and prints its world: coupon_test prints it for every printer"},
    {"specimens", "writes worlds of test pieces, and reads curves: specimens_test"},
    {"verify", "reads a print's file, whatever made it"},
    {"printers", "lists printers"},
    {"archive", "keeps what a print was made from: archive_test prints each kind of input again"},
    {"cache", "lists and purges what is kept"},
    {"property", "makes a module of a table"},
    {"compensate", "makes a field of measurements, which the columns of fields apply"},
    {"receive", "takes slices, whatever made them"},
    {"profile", "times a print, whose voxels it drops"},
    {"tune", "times a print, whose voxels it drops"},
    {"fit", "counts the voxels of a print with other uniforms: fit_test prints what it found"},
    {"text", "makes a mesh of a file"},
    {"color", "makes charts and tables"},
    {"texture", "converts a picture"},
    // Options of a print.
    {"--help", "shows a text"},
    {"--token-file", "of a receiver"},
    {"--tls-ca", "of a receiver"},
    {"--z", "chooses slices, as `--slices` does"},
    {"--allow", "names folders that may be read"},
    {"--png", "how pictures are written"},
    {"--grey-material", "which material pictures show"},
    {"--flip-x", "mirrors slices, whatever made them"},
    {"filament-mixed", "mixtures: mixed_mesh_test reads them back"},
    {"--fractions", "mixtures: print_fractions_test"},
    {"--sampling", "mixtures: print_fractions_test"},
    {"--fractions-supersample", "mixtures: print_fractions_test"},
    {"--progress", "what is said"},
    {"--dry-run", "a print without its slices"},
    {"--part", "slices of it: print_merge_test"},
    {"--no-cache", "what is kept: openfab_print_cache_test"},
    {"--slab-limit", "ends a print: print_generator_test"},
    {"--only-object",
     "the voxels of an object: print_only_object_test, and the column `marker` through mechanics"},
    {"--as-built",
     "without what a process does: mechanics_model_test compares it with a world without one"},
    // Kinds of meshes.
    {"box", "a primitive: made into a mesh when a world is read, as `capsule`"},
    {"sphere", "likewise"},
    {"cylinder", "likewise"},
    {"plane", "likewise"},
    {"cone", "likewise"},
    {"torus", "likewise"},
    {"extrusion", "likewise"},
    {"revolution", "likewise"},
};

}  // namespace

std::span<const Elsewhere> elsewhere() {
    return kElsewhere;
}

}  // namespace openfab::testing
