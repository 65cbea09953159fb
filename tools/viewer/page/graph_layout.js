// Where the nodes of a graph stand: columns from what is read on the left to the result on the right, each node beside
// what it gives its value to. Nothing here touches the page.

export const kSize = { width: 156, head: 24, row: 20, column: 204, gap: 16, look: 52 };

/** Where the rows of a node end: its inputs, and beside them the outputs after the first. */
export function rowsEnd(node) {
    return kSize.head + Math.max(node.ports.length, node.outputs.length - 1, node.kind === "opaque" ? 1 : 0) * kSize.row;
}

/** With room for its picture, if it has one; of a folded one its head. */
export function heightOf(node) {
    if (node.folded) return kSize.head;
    return rowsEnd(node) + 4 + (node.look ? kSize.look : 0);
}

/** The nodes that read each node. */
function readersOf(nodes) {
    const readers = nodes.map(() => []);
    for (const node of nodes) for (const port of node.ports) if (port.from !== undefined) readers[port.from].push(node.id);
    return readers;
}

/** How many columns each node stands before the last. */
function ranksOf(nodes, readers) {
    const ranks = new Array(nodes.length).fill(-1);
    const rank = (id) => {
        if (ranks[id] >= 0) return ranks[id];
        ranks[id] = 0;  // a graph has no loops; a damaged one must not hang
        const least = nodes[id].kind === "result" ? 0 : 1;
        ranks[id] = Math.max(least, ...readers[id].map((reader) => rank(reader) + 1));
        return ranks[id];
    };
    nodes.forEach((node) => rank(node.id));
    return ranks;
}

const mean = (numbers) => numbers.reduce((sum, n) => sum + n, 0) / numbers.length;

/** Moves nodes of a column towards where they want to be, in order and apart. */
function place(column, wanted, nodes, y) {
    const sorted = [...column].sort((a, b) => wanted[a] - wanted[b] || a - b);
    // Runs of nodes that touch move as one, to the mean of what they want.
    const runs = [];
    for (const id of sorted) {
        const height = heightOf(nodes[id]) + kSize.gap;
        let run = { ids: [id], height, top: wanted[id], sum: wanted[id] };
        while (runs.length && runs.at(-1).top + runs.at(-1).height > run.top) {
            const before = runs.pop();
            const count = before.ids.length + run.ids.length;
            const sum = before.sum + run.sum - run.ids.length * before.height;
            run = { ids: [...before.ids, ...run.ids], height: before.height + run.height, top: sum / count, sum };
        }
        runs.push(run);
    }
    for (const run of runs) {
        let top = run.top;
        for (const id of run.ids) {
            y[id] = top;
            top += heightOf(nodes[id]) + kSize.gap;
        }
    }
}

/** Returns {x, y} for each node and the size of all. */
export function layout(nodes) {
    const readers = readersOf(nodes);
    const ranks = ranksOf(nodes, readers);
    const last = Math.max(0, ...ranks);
    const columns = Array.from({ length: last + 1 }, () => []);
    nodes.forEach((node) => columns[ranks[node.id]].push(node.id));
    const y = new Array(nodes.length).fill(0);
    for (const column of columns) {
        let top = 0;
        for (const id of column) { y[id] = top; top += heightOf(nodes[id]) + kSize.gap; }
    }
    const inputY = (reader, id) => y[reader] + kSize.head + nodes[reader].ports.findIndex((port) => port.from === id) * kSize.row - kSize.head / 2;
    for (let sweep = 0; sweep < 6; ++sweep) {
        for (const column of columns) {
            const wanted = [];
            for (const id of column) wanted[id] = readers[id].length ? mean(readers[id].map((reader) => inputY(reader, id))) : y[id];
            place(column, wanted, nodes, y);
        }
        for (const column of [...columns].reverse()) {
            const wanted = [];
            for (const id of column) {
                const from = nodes[id].ports.filter((port) => port.from !== undefined);
                wanted[id] = from.length ? (mean(from.map((port) => y[port.from])) + y[id]) / 2 : y[id];
            }
            place(column, wanted, nodes, y);
        }
    }
    const top = nodes.length ? Math.min(...y) : 0;
    const at = nodes.map((node) => ({ x: (last - ranks[node.id]) * kSize.column, y: y[node.id] - top }));
    const height = Math.max(0, ...nodes.map((node) => at[node.id].y + heightOf(node)));
    return { at, width: last * kSize.column + kSize.width, height };
}
