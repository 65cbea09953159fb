#!/usr/bin/env bash
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# Coin 4.0.0 (Debian 4.0.0+ds-3): triangles of a VRML 2.0 IndexedFaceSet with `ccw FALSE`, from SoCallbackAction.
#
# Guess: the action says by getVertexOrdering() that the faces are clockwise, as for SoShapeHints of VRML 1.0 (VRML97, 6.23: with
# `ccw FALSE` the vertices of a face are clockwise when it is seen from outside).
# Seen: the triangles have the order of the file, and getVertexOrdering() is not CLOCKWISE. A tetrahedron whose faces are written
# clockwise, with `ccw FALSE`, has the volume -1/6 by them; the same in VRML 1.0 with SoShapeHints is told as CLOCKWISE.
# What helps: the field `ccw` of the shape itself.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The packages and what they need, in this folder alone.
mkdir -p debs/partial root
apt-get install -y -qq --no-install-recommends --reinstall --download-only -o Dir::Cache::archives="$work/debs" \
    -o APT::Sandbox::User=root libcoin-dev=4.0.0+ds-3 libcoin80c=4.0.0+ds-3 > apt.log 2>&1 || { cat apt.log >&2; exit 1; }
for deb in debs/*.deb; do dpkg -x "$deb" root; done

points='0 0 0, 1 0 0, 0 1 0, 0 0 1' faces='0, 1, 2, -1, 0, 3, 1, -1, 0, 2, 3, -1, 1, 3, 2, -1'
printf '#VRML V2.0 utf8\nShape { geometry IndexedFaceSet { ccw FALSE coord Coordinate { point [%s] } coordIndex [%s] } }\n' \
    "$points" "$faces" > new.wrl
printf '#VRML V1.0 ascii\nSeparator { ShapeHints { vertexOrdering CLOCKWISE } Coordinate3 { point [%s] } IndexedFaceSet { coordIndex [%s] } }\n' \
    "$points" "$faces" > old.wrl

cat > volume.cpp << 'CPP'
#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>
#include <cstdio>

struct Sum { double volume = 0; bool clockwise = false; };

int main(int, char** argv) {
    SoDB::init();
    SoInput input;
    if (!input.openFile(argv[1])) return 1;
    SoSeparator* root = SoDB::readAll(&input);
    if (root == nullptr) return 1;
    root->ref();
    Sum sum;
    SoCallbackAction action;
    action.addTriangleCallback(
        SoShape::getClassTypeId(),
        [](void* to, SoCallbackAction* a, const SoPrimitiveVertex* p, const SoPrimitiveVertex* q, const SoPrimitiveVertex* r) {
            Sum& sum = *static_cast<Sum*>(to);
            sum.volume += static_cast<double>(p->getPoint().dot(q->getPoint().cross(r->getPoint()))) / 6;
            sum.clockwise = a->getVertexOrdering() == SoShapeHints::CLOCKWISE;
        },
        &sum);
    action.apply(root);
    std::printf("%.4f %s\n", sum.volume, sum.clockwise ? "clockwise" : "not said");
}
CPP
lib=root/usr/lib/x86_64-linux-gnu
g++ -std=c++17 -w -isystem root/usr/include volume.cpp -L "$lib" -Wl,-rpath-link,"$lib" -lCoin -o volume
look() { LD_LIBRARY_PATH="$work/$lib:$work/root/lib/x86_64-linux-gnu" ./volume "$1"; }

seen_new=$(look new.wrl) seen_old=$(look old.wrl)
echo "VRML 2.0, ccw FALSE: $seen_new; VRML 1.0, CLOCKWISE: $seen_old"
[ "$seen_new" = "-0.1667 not said" ] || { echo "changed: VRML 2.0" >&2; exit 1; }
[ "$seen_old" = "-0.1667 clockwise" ] || { echo "changed: VRML 1.0" >&2; exit 1; }
