#!/usr/bin/env bash
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# PrusaSlicer 2.5.0 (Debian 2.5.0+dfsg-4), command line: the `transform` of a 3MF's build item, where one mesh object is cut into
# volumes by `Metadata/Slic3r_PE_model.config`, the slicer's own list of triangles and extruders.
#
# Guess: the item places the object, so both volumes move together (3MF Core, 3.4: the transform applies to the object).
# Seen: the first volume moves, the others stay. Two boxes that touch, 0 to 4 and 4 to 8 mm along x, moved by 30 mm, are 30 to 34
# and 4 to 8: `--info` says that the object is from 4 to 34. Without a transform it is 8 mm long, as it should be. No message.
# What helps: no transform on such items (the slicer sets objects down on its bed anyway), or coordinates of vertices that are moved.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The package and what it needs, in this folder alone.
mkdir -p debs/partial root
apt-get install -y -qq --no-install-recommends --reinstall --download-only -o Dir::Cache::archives="$work/debs" \
    -o APT::Sandbox::User=root prusa-slicer=2.5.0+dfsg-4 > apt.log 2>&1 || { cat apt.log >&2; exit 1; }
for deb in debs/*.deb; do dpkg -x "$deb" root; done
slicer() {
    LD_LIBRARY_PATH="$work/root/usr/lib/x86_64-linux-gnu:$work/root/lib/x86_64-linux-gnu" HOME="$work" \
        root/usr/bin/prusa-slicer "$@" 2> /dev/null
}

python3 - << 'PYTHON'
import zipfile

FACES = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
         (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
vertices = [(x0 + 4 * (i & 1), 4 * (i >> 1 & 1), 4 * (i >> 2 & 1)) for x0 in (0, 4) for i in range(8)]
triangles = [tuple(8 * box + i for i in face) for box in range(2) for face in FACES]

TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
<Default Extension="config" ContentType="text/xml"/></Types>"""
LINKS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>"""
VOLUMES = """<?xml version="1.0" encoding="UTF-8"?>
<config><object id="1" instances_count="1">
<volume firstid="0" lastid="11"><metadata type="volume" key="extruder" value="1"/></volume>
<volume firstid="12" lastid="23"><metadata type="volume" key="extruder" value="2"/></volume>
</object></config>"""

for name, transform in ("plain", ""), ("moved", ' transform="1 0 0 0 1 0 0 0 1 30 0 0"'):
    model = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<model unit="millimeter" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">'
        '<resources><object id="1" type="model"><mesh><vertices>'
        + "".join('<vertex x="%d" y="%d" z="%d"/>' % p for p in vertices) + "</vertices><triangles>"
        + "".join('<triangle v1="%d" v2="%d" v3="%d"/>' % t for t in triangles)
        + f'</triangles></mesh></object></resources><build><item objectid="1"{transform}/></build></model>')
    with zipfile.ZipFile(f"{name}.3mf", "w", zipfile.ZIP_DEFLATED) as package:
        package.writestr("[Content_Types].xml", TYPES)
        package.writestr("_rels/.rels", LINKS)
        package.writestr("3D/3dmodel.model", model)
        package.writestr("Metadata/Slic3r_PE_model.config", VOLUMES)
PYTHON

range() { slicer --info "$1" | awk '$1 == "min_x" { low = $3 } $1 == "max_x" { high = $3 } END { printf "%g %g\n", low, high }'; }
expect() {
    local found
    found=$(range "$1")
    printf '%s: x from %s\n' "$1" "$found"
    [ "$found" = "$2" ] || { printf '%s: expected %s: the behaviour has changed\n' "$1" "$2" >&2; exit 1; }
}
expect plain.3mf "0 8"
expect moved.3mf "4 34" # 30 to 38 if the item's transform moved all of it
