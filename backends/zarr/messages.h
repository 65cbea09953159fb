// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of stores of Zarr: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::zarr::messages {

// layout
OPENFAB_MESSAGE(kOtherVersion, "{}: it is of Zarr version {}; OpenFab reads and writes version 3")
OPENFAB_MESSAGE(kNoPrint, "{}: it has no attribute `openfab`, so it is no print; a world takes it as a texture")
OPENFAB_MESSAGE(kPrintDamaged, "{}: its attribute `openfab` is damaged, or of another version")
OPENFAB_MESSAGE(kOtherArray, "{}: its `{}` is not that of a print by OpenFab; copy voxels by another program into a new print's store, and leave its arrays as they are")

// store
OPENFAB_MESSAGE(kShardUnread, "cannot read the shard `{}`: ")
OPENFAB_MESSAGE(kNoStore, "`{}` is no store of Zarr: it has no `zarr.json`")
OPENFAB_MESSAGE(kCannotRead, "cannot read `{}`: ")
OPENFAB_MESSAGE(kShardOtherSize, "the shard `{}` has {} bytes, and its list says {}: it is torn, or of another print; `openfab print --resume` makes it again")
OPENFAB_MESSAGE(kShardDiffers, "the shard `{}` is not the one that its list names: it was changed, or is of another print; `openfab print --resume` makes it again")
OPENFAB_MESSAGE(kShardDamaged, "the shard `{}` is damaged; `openfab print --resume` makes it again")

// whole_store
OPENFAB_MESSAGE(kManifestDamaged, "{}: it is damaged; print into the store again with `--resume`")

// zarr_sink
OPENFAB_MESSAGE(kOutputIsFile, "`{}` is a file; a store of Zarr is a folder")
OPENFAB_MESSAGE(kOtherFiles, "`{}` holds other files, such as `{}`, and no store of Zarr; name another output")
OPENFAB_MESSAGE(kOtherPrint, "`{}` holds another print: {}; name another output, or remove that one")
OPENFAB_MESSAGE(kOtherPrintUnknown, "its zarr.json is not this print's")
OPENFAB_MESSAGE(kNotAtSlabs, "slices {}:{} begin or end within a slab; a shard has all 8 slices of one, so print `--slices {}:{}`, or parts by `--part 1/8`")
OPENFAB_MESSAGE(kOthersSlices, "slices {}:{} of `{}` were printed with other bounds: `{}` has {}:{}; print these with `--resume`, or remove that file first")
OPENFAB_MESSAGE(kCannotCreate, "cannot create `{}`: {}")
OPENFAB_MESSAGE(kCannotWrite, "cannot write to `{}`: {}")

}  // namespace openfab::zarr::messages
