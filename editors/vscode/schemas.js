// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Copies what an installed extension needs from the rest of the repository: the schema of worlds, and the licence.

const fs = require("node:fs");
const path = require("node:path");

const root = path.join(__dirname, "..", "..");
fs.mkdirSync(path.join(__dirname, "schemas"), { recursive: true });
fs.copyFileSync(path.join(root, "world", "fab_world.schema.json"), path.join(__dirname, "schemas", "fab_world.schema.json"));
fs.copyFileSync(path.join(root, "LICENSE"), path.join(__dirname, "LICENSE"));
