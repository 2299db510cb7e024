// @ts-check
/**
 * Boxes and the viewport. Pure.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {{zoom: number, x: number, y: number, stretch?: number}} Viewport   zoom: screen px per picture px vertically, times `stretch` (default 1) horizontally; x, y: picture point at the centre
 * @typedef {{width: number, height: number, stretch?: number}} Size   stretch: width of a pixel divided by its height, default 1
 * @typedef {'n'|'ne'|'e'|'se'|'s'|'sw'|'w'|'nw'|'move'} Handle
 */

/** Minimum side of a drawn box, px. */
export const MIN_BOX_SIDE_PX = 2;
const HANDLES = /** @type {const} */ ([
  ['nw', 0, 0],
  ['n', 0.5, 0],
  ['ne', 1, 0],
  ['e', 1, 0.5],
  ['se', 1, 1],
  ['s', 0.5, 1],
  ['sw', 0, 1],
  ['w', 0, 0.5],
]);

/** Screen px per picture px horizontally. @param {Viewport} view */
export const scaleX = ({ zoom, stretch = 1 }) => zoom * stretch;

/** @param {Viewport} view @param {Size} screen @param {number} x @param {number} y @returns {[number, number]} picture point */
export const toPicture = (view, screen, x, y) => [
  (x - screen.width / 2) / scaleX(view) + view.x,
  (y - screen.height / 2) / view.zoom + view.y,
];

/** @param {Viewport} view @param {Size} screen @param {number} x @param {number} y @returns {[number, number]} screen point */
export const toScreen = (view, screen, x, y) => [
  (x - view.x) * scaleX(view) + screen.width / 2,
  (y - view.y) * view.zoom + screen.height / 2,
];

/** The shape of pixels for a view; empty if they are square. @param {{stretch?: number}} shape @returns {{stretch?: number}} */
const pixelShape = ({ stretch }) => (stretch === undefined || stretch === 1 ? {} : { stretch });

/** The size of a video's pictures, and the shape of their pixels. @param {import('../types.js').Video|undefined} video @returns {Size} */
export const sizeOf = (video) => ({ width: video?.width ?? 1, height: video?.height ?? 1, ...pixelShape({ stretch: video?.pixel_ratio }) });

/** The whole picture in view. @param {Size} picture @param {Size} screen @returns {Viewport} */
export const fit = (picture, screen) => ({
  zoom: Math.max(0.01, Math.min(screen.width / (picture.width * (picture.stretch ?? 1)), screen.height / picture.height)),
  x: picture.width / 2,
  y: picture.height / 2,
  ...pixelShape(picture),
});

/**
 * Zoom so that the picture point under the pointer stays there.
 * @param {Viewport} view
 * @param {Size} screen
 * @param {Size} picture
 * @param {number} factor
 * @param {number} x        pointer, screen px
 * @param {number} y
 * @returns {Viewport}
 */
export function zoomAt(view, screen, picture, factor, x, y) {
  const minZoom = fit(picture, screen).zoom * 0.5;
  const zoom = Math.min(64, Math.max(Math.min(minZoom, 1), view.zoom * factor));
  const [px, py] = toPicture(view, screen, x, y);
  return clampView(
    { ...view, zoom, x: px - (x - screen.width / 2) / scaleX({ ...view, zoom }), y: py - (y - screen.height / 2) / zoom },
    picture,
  );
}

/** Keep some of the picture in view. @param {Viewport} view @param {Size} picture @returns {Viewport} */
export const clampView = (view, picture) => ({
  ...view,
  x: Math.min(picture.width, Math.max(0, view.x)),
  y: Math.min(picture.height, Math.max(0, view.y)),
});

/**
 * Move the view to a box outside it. Zooms out if the box does not fit.
 * @param {Viewport} view
 * @param {Size} screen
 * @param {Box} box
 * @returns {Viewport} the same object if the centre of the box is visible and the box fits
 */
export function panToBox(view, screen, box) {
  const [x, y] = [(box[0] + box[2]) / 2, (box[1] + box[3]) / 2];
  const inside = Math.abs(x - view.x) * scaleX(view) < 0.45 * screen.width && Math.abs(y - view.y) * view.zoom < 0.45 * screen.height;
  const maxZoom = 0.8 * Math.min(screen.width / ((box[2] - box[0]) * (view.stretch ?? 1)), screen.height / (box[3] - box[1]));
  return inside && view.zoom <= maxZoom ? view : { ...view, zoom: Math.min(view.zoom, maxZoom), x, y };
}

/**
 * The view in which a box has a size on the screen that is easy to judge and to drag.
 * @param {Box} box
 * @param {number} side   side of the box, screen px
 * @param {Size} picture
 * @returns {Viewport}
 */
export const zoomToBox = (box, side, picture) => ({
  zoom: Math.min(16, side / Math.max((box[2] - box[0]) * (picture.stretch ?? 1), box[3] - box[1], 1)),
  x: (box[0] + box[2]) / 2,
  y: (box[1] + box[3]) / 2,
  ...pixelShape(picture),
});

/** @param {Box} box @param {number} x @param {number} y */
export const contains = ([x1, y1, x2, y2], x, y) => x1 <= x && x <= x2 && y1 <= y && y <= y2;

/** @param {Box} box */
export const area = ([x1, y1, x2, y2]) => (x2 - x1) * (y2 - y1);

/** @param {Box} a @param {Box} b @returns {number} intersection over union */
export function iou(a, b) {
  const w = Math.min(a[2], b[2]) - Math.max(a[0], b[0]);
  const h = Math.min(a[3], b[3]) - Math.max(a[1], b[1]);
  const inner = Math.max(0, w) * Math.max(0, h);
  return inner === 0 ? 0 : inner / (area(a) + area(b) - inner);
}

/**
 * The handle under a point: corners first, then edges, then the inside.
 * @param {Box} box
 * @param {number} x
 * @param {number} y
 * @param {number} radius   px vertically
 * @param {number} [stretch]   factor on horizontal distances
 * @returns {Handle|null}
 */
export function handleAt(box, x, y, radius, stretch = 1) {
  let best = null;
  // in a small box the handles leave the middle free, so that the box can be moved
  let minDistance = contains(box, x, y) ? Math.min(radius, Math.min((box[2] - box[0]) * stretch, box[3] - box[1]) / 4) : radius;
  for (const [name, u, v] of HANDLES) {
    const distance = Math.max(Math.abs(x - (box[0] + u * (box[2] - box[0]))) * stretch, Math.abs(y - (box[1] + v * (box[3] - box[1]))));
    if (distance <= minDistance) [best, minDistance] = [name, distance - (name.length === 2 ? 1e-9 : 0)];
  }
  return best ?? (contains(box, x, y) ? 'move' : null);
}

/** @param {Box} box @returns {[string, number, number][]} handles with their points */
export const handlesOf = ([x1, y1, x2, y2]) => HANDLES.map(([name, u, v]) => [name, x1 + u * (x2 - x1), y1 + v * (y2 - y1)]);

/**
 * A box after its handle was dragged. If it is dragged past the opposite side, the corners swap.
 * @param {Box} box
 * @param {Handle} handle
 * @param {number} dx
 * @param {number} dy
 * @returns {Box}
 */
export function dragHandle(box, handle, dx, dy) {
  if (handle === 'move') return [box[0] + dx, box[1] + dy, box[2] + dx, box[3] + dy];
  const moved = /** @type {Box} */ ([...box]);
  if (handle.includes('w')) moved[0] += dx;
  if (handle.includes('e')) moved[2] += dx;
  if (handle.includes('n')) moved[1] += dy;
  if (handle.includes('s')) moved[3] += dy;
  return orderCorners(moved);
}

/** A box from two corners in any order. @param {Box} corners @returns {Box} */
export const orderCorners = ([a, b, c, d]) => [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)];

/**
 * A box inside the picture, no smaller than `MIN_BOX_SIDE_PX`, rounded to tenths of a pixel.
 * @param {Box} box
 * @param {Size} picture
 * @returns {Box}
 */
export function normalizeBox(box, picture) {
  /** @param {number} low @param {number} high @param {number} max @returns {[number, number]} */
  const normalizeEdges = (low, high, max) => {
    const a = Math.min(Math.max(0, low), max - MIN_BOX_SIDE_PX);
    return [round(a), round(Math.max(a + MIN_BOX_SIDE_PX, Math.min(max, high)))];
  };
  const [x1, x2] = normalizeEdges(box[0], box[2], picture.width);
  const [y1, y2] = normalizeEdges(box[1], box[3], picture.height);
  return [x1, y1, x2, y2];
}

/** A box moved as a whole, limited to the picture. @param {Box} box @param {number} dx @param {number} dy @param {Size} picture @returns {Box} */
export function moveBox(box, dx, dy, picture) {
  const x = Math.min(Math.max(dx, -box[0]), picture.width - box[2]);
  const y = Math.min(Math.max(dy, -box[1]), picture.height - box[3]);
  return normalizeBox([box[0] + x, box[1] + y, box[2] + x, box[3] + y], picture);
}

/** @param {number} value */
const round = (value) => Math.round(value * 10) / 10;

/** @param {number} value @param {number} low @param {number} high   >= low */
export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
