// "Save picture": what is shown, as a PNG file.

/** Puts the canvases over each other, on the colour that is behind them, and hands them to the browser as a file. */
export async function savePicture(canvases, name) {
    const shown = canvases.filter((canvas) => !canvas.hidden && canvas.clientWidth > 0);
    const picture = document.createElement("canvas");
    picture.width = Math.max(...shown.map((canvas) => canvas.width));
    picture.height = Math.max(...shown.map((canvas) => canvas.height));
    const c = picture.getContext("2d");
    c.fillStyle = getComputedStyle(shown[0].parentElement).backgroundColor;
    c.fillRect(0, 0, picture.width, picture.height);
    for (const canvas of shown) c.drawImage(canvas, 0, 0, picture.width, picture.height);
    const blob = await new Promise((done) => picture.toBlob(done, "image/png"));
    if (!blob) throw new Error("the browser could not make the picture");
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = `${name.replace(/[^\p{L}\p{N}._-]+/gu, "_")}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
