/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The @Grow stage in a table of kernels: a rule that makes nodes, structs, each of the node that it grows from.
 * It stands in the place of a @Shape (openfab_shape), whose outputs are the members of a node; it has no
 * values and no bounds, and `attributes` computes nodes from their parents: GROW_PARENT and GROW_PLACE to
 * SHAPE_OUT, one value per node. */
#pragma once

#include "abi/fablet_table.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Kinds of arguments beside those of openfab_arg_kind. */
enum openfab_grow_arg_kind {
    OPENFAB_ARG_GROW_PARENT = 56, /* a = output, b = component: what SHAPE_OUT was of the parent */
    OPENFAB_ARG_GROW_PLACE = 57,  /* 32 bits; a = openfab_grow_place */
};

/* Where a node stands among the nodes of a rule (kind OPENFAB_ARG_GROW_PLACE, a). */
enum openfab_grow_place {
    OPENFAB_GROW_CHILD = 0, /* int32: its number among its parent's children; 0 of the root */
    OPENFAB_GROW_LEVEL = 1, /* int32: how many parents it has */
    OPENFAB_GROW_PATH = 2,  /* uint32: a hash of the numbers from the root on */
};

/* Returns whether a solid is a @Grow: of a @Shape the value is an output. */
static inline int openfab_grows(const struct openfab_shape* shape) {
    return shape != NULL && shape->values.arg_count == 0;
}

#ifdef __cplusplus
}
#endif
