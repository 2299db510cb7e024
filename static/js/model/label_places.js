// @ts-check
/**
 * Where the labels of boxes stand, so that none hides a sign: several signs often hang on one post, and a label above the
 * middle one would lie on the one over it. Pure; on the screen, in CSS px.
 *
 * @typedef {import('../types.js').Box} Box
 * @typedef {import('./geometry.js').Size} Size
 *
 * @typedef {object} WantedLabel
 * @property {Box} box
 * @property {number} wide
 * @property {number} high
 * @property {'above'|'below'} where    where it stands if nothing speaks against it
 */

/** Between a box and its label. */
const GAP = 2;
/** This share of a box or a label may be covered: the boxes that several layers have of one sign differ by a pixel or two. */
const BEARABLE = 0.15;

/**
 * A place for each label, in their order: where it was wanted, else on another side of its box, else where it covers least
 * of the boxes, its own too, and of the labels before it.
 *
 * @param {readonly WantedLabel[]} wanted   the most important first
 * @param {Size} screen
 * @returns {({x: number, y: number}|null)[]} upper left corners; null: the box is not on the screen
 */
export function placeLabels(wanted, screen) {
  /** @type {Box[]} */
  const placed = [];
  return wanted.map((label) => {
    const { box, wide, high } = label;
    if (box[2] <= 0 || box[3] <= 0 || box[0] >= screen.width || box[1] >= screen.height) return null;
    let best = { x: 0, y: 0 };
    let least = Number.POSITIVE_INFINITY;
    for (const [x, y] of sides(label, screen)) {
      const place = /** @type {Box} */ ([x, y, x + wide, y + high]);
      let covered = 0;
      for (const other of wanted) covered += shareOf(other.box, place);
      for (const other of placed) covered += shareOf(other, place);
      if (covered >= least) continue;
      best = { x, y };
      least = covered;
      if (covered <= BEARABLE) break;
    }
    placed.push([best.x, best.y, best.x + wide, best.y + high]);
    return best;
  });
}

/** @param {WantedLabel} label @param {Size} screen @returns {[number, number][]} the best first, all on the screen */
function sides({ box: [x1, y1, x2, y2], wide, high, where }, screen) {
  /** @param {number} x @param {number} y @returns {[number, number]} */
  const kept = (x, y) => [Math.min(Math.max(0, x), Math.max(0, screen.width - wide)), Math.min(Math.max(0, y), Math.max(0, screen.height - high))];
  const above = y1 - high - GAP;
  const below = y2 + GAP;
  const first = where === 'above' ? (above < 0 ? below : above) : below + high > screen.height ? above : below;
  const second = first === above ? below : above;
  return [
    kept(x1 - 1, first),
    kept(x2 + GAP, y1),
    kept(x1 - wide - GAP, y1),
    kept(x1 - 1, second),
    kept(x2 - wide + 1, first),
    kept(x2 - wide + 1, second),
  ];
}

/** How much of a box is covered by another, 0..1. @param {Box} a @param {Box} by */
function shareOf(a, by) {
  const wide = Math.min(a[2], by[2]) - Math.max(a[0], by[0]);
  const high = Math.min(a[3], by[3]) - Math.max(a[1], by[1]);
  return wide <= 0 || high <= 0 ? 0 : (wide * high) / ((a[2] - a[0]) * (a[3] - a[1]));
}
