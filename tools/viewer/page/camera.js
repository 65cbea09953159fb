// Where the volume is looked at from: an orthographic camera about its middle, in mm.

export const kStandpoints = {
    iso: { title: "From the front, the right and above", turn: 0.55, tilt: 0.5 },
    top: { title: "From above: x to the right, y up", turn: 0, tilt: Math.PI / 2 },
    bottom: { title: "From below", turn: 0, tilt: -Math.PI / 2 },
    front: { title: "From the front: x to the right, z up", turn: 0, tilt: 0 },
    back: { title: "From behind", turn: Math.PI, tilt: 0 },
    left: { title: "From the left, where x begins", turn: -Math.PI / 2, tilt: 0 },
    right: { title: "From the right, where x ends", turn: Math.PI / 2, tilt: 0 },
};

const kTilt = Math.PI / 2;

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export class Camera {
    constructor() {
        this.stand("iso");
        this.fit();
    }

    fit() {
        this.magnified = 1;
        this.middle = [0, 0];
    }

    stand(name) {
        ({ turn: this.turn, tilt: this.tilt } = kStandpoints[name]);
    }

    turnBy(dx, dy) {
        this.turn -= dx;
        this.tilt = Math.min(Math.max(this.tilt + dy, -kTilt), kTilt);
    }

    zoom(factor) {
        this.magnified = Math.min(Math.max(this.magnified * factor, 0.3), 40);
    }

    /** What is drawn on `width` by `height` CSS pixels of a box of `size` mm: CSS pixels a mm, and directions. */
    look(size, width, height) {
        // All of it, however it is turned, as long as it is not tilted by more than 45 degrees.
        const across = Math.hypot(size[0], size[1]);
        const high = (across + size[2]) * Math.SQRT1_2;
        const scale = this.magnified * 0.94 * Math.min(width / across, height / high);
        const [ct, st, ce, se] = [Math.cos(this.turn), Math.sin(this.turn), Math.cos(this.tilt), Math.sin(this.tilt)];
        return new Look({ width, height, scale, middle: this.middle, right: [ct, st, 0], up: [-st * se, ct * se, ce], towards: [st * ce, -ct * ce, se] });
    }

    /** As the address keeps it. */
    text() {
        return [this.turn, this.tilt, this.magnified, ...this.middle].map((v) => Number(v.toFixed(4))).join(",");
    }

    set([turn, tilt, magnified, x, y]) {
        this.turn = turn;
        this.tilt = Math.min(Math.max(tilt, -kTilt), kTilt);
        this.magnified = Math.min(Math.max(magnified, 0.3), 40);
        this.middle = [x, y];
    }
}

/** One moment of a camera. Points are in mm from the middle of the box. */
class Look {
    constructor(values) { Object.assign(this, values); }

    toCanvas(point) {
        return [
            this.width / 2 + (dot(this.right, point) + this.middle[0]) * this.scale,
            this.height / 2 - (dot(this.up, point) + this.middle[1]) * this.scale,
        ];
    }

    /** The point of a plane through the middle, across the view, that is drawn at a place of the canvas. */
    fromCanvas(x, y) {
        const a = (x - this.width / 2) / this.scale - this.middle[0];
        const b = (this.height / 2 - y) / this.scale - this.middle[1];
        return [0, 1, 2].map((i) => this.right[i] * a + this.up[i] * b);
    }
}
