/* Copyright 2026 The OpenFab Authors
 * SPDX-License-Identifier: Apache-2.0 */

/* A print program without fablets. It is linked when the project is built, to record the link line that `openflc build`
 * repeats and to see that it is complete. */

#include "abi/fablet_table.h"

static const struct openfab_fablet* const none[] = {0};
const struct openfab_fablet_list openfab_fablets = {0, none};
